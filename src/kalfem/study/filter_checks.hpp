#pragma once

#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// What a filter's model must have for the case to be run: a displacement sensor where the start is read from the
/// record, and the samples that must not be missing, the first ones there and all of a channel that drives an
/// interface.
void check_augmented_model(const CaseStudy& study, IssueList& issues);

/// Throws InvalidInput where the filter of the case's `estimate` could not be made or run, as far as it shows before.
void check_filter(const CaseStudy& study);

/// Settings of `estimate` that are allowed but are probably a mistake, one sentence each.
std::vector<std::string> doubtful_estimation(const CaseStudy& study);

/// Throws InvalidInput where the substructure, as `model` holds it, has no boundary or interior, where its interior
/// moves freely, or where the filter's model does not estimate the motion of its boundary.
void check_driven(const Study& study, const CoupledModel& model, const Name& substructure);

/// That the filter's model does not estimate the motion of a point that drives the substructure.
InvalidInput not_estimated(const Name& substructure, const std::string& point);

}  // namespace kalfem
