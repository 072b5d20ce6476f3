#pragma once

#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// The parameters of the case's `update`. Problems go to `issues` with their place: names that no substructure has,
/// bounds that exclude the start, one parameter under two names.
UpdatingSetup make_updating_setup(const CaseStudy& study, IssueList& issues);

/// How they are refined. Needs the study's setup. Throws InvalidInput with every problem of the comparisons.
UpdatingPlan make_updating_plan(const CaseStudy& study);

}  // namespace kalfem
