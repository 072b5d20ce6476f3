// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/verdict/checks.hpp"

namespace kalfem {

/// The innovations of a run of the filter over what the sensors measured, those before sample `first` not counting.
InnovationRecord innovations_of(const Record& measured, const EstimationResult& result, Eigen::Index first);
/// Those of an estimation: after settling.
InnovationRecord innovations_of(const RecordEstimate& estimate);

/// Whether the innovations from a sample on contradict the model.
bool innovations_contradict(const RecordEstimate& estimate, Eigen::Index first);
/// Whether those after settling do, or the scores widen a deviation by what matters.
bool contradicts_itself(const RecordEstimate& estimate);

/// What the robust covariance of the constant unknowns has beyond the filter's, in the filter's state: a factor F of
/// the excess F F^T, c x c; empty where the scores widen nothing by what matters.
Eigen::MatrixXd excess_of(const RecordEstimate& estimate);

/// Sets the deviations of the unknowns that hold where the model is not the truth, from their course (scores along
/// time). Where the innovations contradict the model, also from what frequency bands contradict each other by
/// (band_variances()), the larger one of each.
void set_robust_deviations(RecordEstimate& estimate);

}  // namespace kalfem
