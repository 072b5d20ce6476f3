#pragma once

#include <Eigen/Dense>

#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/study/inference_plan.hpp"

namespace kalfem {

/// Where the search for the most probable parameters begins: at what the filter has found along the record, inside the
/// priors; at the plan's own start without an estimate, or where the filter stopped. From a prior's centre the
/// likelihood of a lightly damped structure has many maxima: each is a phase that fits for a while.
Eigen::VectorXd search_start(const InferencePlan& plan, const RecordEstimate* estimate);

}  // namespace kalfem
