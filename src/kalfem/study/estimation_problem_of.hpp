// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// Translates the case's `estimate` into a problem of the library: looks up names and converts values to SI. Problems
/// go to `issues` with their place.
EstimationProblem make_estimation_problem(const CaseStudy& study, IssueList& issues);

/// The names that an unknown applies to: its own if `applies_to` is empty.
std::vector<Name> names_of(const std::string& name, const description::Unknown& given);

/// The issue of using `damping.modal` as one parameter if the ratios of the substructure differ: one value would
/// replace them all. Nothing for other parameters.
std::optional<Issue> unlike_ratios(const description::Case& given, const Parameter& parameter, const Name& name);

}  // namespace kalfem
