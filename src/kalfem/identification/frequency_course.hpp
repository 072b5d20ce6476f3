// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

/// Natural frequencies of the structure with the estimates of its unknowns, over the record after
/// settling.
struct FrequencyCourse {
  Eigen::VectorXd time;                  ///< instants [s]
  Eigen::MatrixXd frequency, deviation;  ///< modes x instants, ascending frequencies [Hz]
};

/// The lowest `modes` undamped frequencies at up to a hundred instants, with every connector as stiff as at rest,
///     (K(theta_k) - (2 pi f)^2 M(theta_k)) phi = 0,    phi^T M phi = 1,
/// and their standard deviations from those of the unknowns theta at that instant and the correlation of these after
/// the last sample: first order in
///     df / dtheta_i = phi^T (dK/dtheta_i - (2 pi f)^2 dM/dtheta_i) phi / (8 pi^2 f).
/// Rigid-body modes are 0 Hz, unstable ones not a number. `parts`: those that the filter's model was made of.
/// Throws InvalidInput where an estimate is not admissible.
FrequencyCourse frequency_course(const EstimationProblem& problem, const StructureParts& parts,
                                 const AugmentedModelSetup& setup, const RecordEstimate& estimate, Eigen::Index modes);

}  // namespace kalfem
