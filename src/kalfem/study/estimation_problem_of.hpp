#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// What the case's `estimate` asks for as a problem of the library: names looked up, values in SI. Problems go to
/// `issues` with their place.
EstimationProblem make_estimation_problem(const CaseStudy& study, IssueList& issues);

/// The names that an unknown applies to: its own where it does not say.
std::vector<Name> names_of(const std::string& name, const description::Unknown& given);

/// What is wrong with `damping.modal` as one parameter where the substructure's ratios differ: it would make them one
/// number. Nothing for other parameters.
std::optional<Issue> unlike_ratios(const description::Case& given, const Parameter& parameter, const Name& name);

}  // namespace kalfem
