#pragma once

#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// Everything under `update.compare`, in the order of the file: residuals of what needs no record, and what is to be
/// compared with it. Throws InvalidInput with every problem and its place.
void add_comparisons(const CaseStudy& study, UpdatingPlan& plan);

/// Problems that show without computing: substructures and sensors that do not exist, comparisons that need a record.
void check_comparisons(const CaseStudy& study, IssueList& issues);
/// Problems of the comparisons that need the estimated motion of a boundary, once there is an augmented model. `start`:
/// the structure that the updating starts from.
void check_driven_histories(const CaseStudy& study, const CoupledModel& start, IssueList& issues);

}  // namespace kalfem
