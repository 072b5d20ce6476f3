#pragma once

#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// The case's structural modifications with their names looked up. Problems go to `issues` with their place.
std::vector<StructuralModification> make_modifications(const CaseStudy& study, IssueList& issues);

}  // namespace kalfem
