#pragma once

#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// Throws InvalidInput where the substructure, as `model` holds it, has no boundary or interior, where its interior
/// moves freely, or where the filter's model does not estimate the motion of its boundary.
void check_driven(const CaseStudy& study, const CoupledModel& model, const Name& substructure);

/// That the filter's model does not estimate the motion of a point that drives the substructure.
InvalidInput not_estimated(const Name& substructure, const std::string& point);

}  // namespace kalfem
