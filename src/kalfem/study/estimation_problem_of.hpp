#pragma once

#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// What the case's `estimate` asks for as a problem of the library: names looked up, values in SI. Problems go to
/// `issues` with their place.
EstimationProblem make_estimation_problem(const CaseStudy& study, IssueList& issues);

}  // namespace kalfem
