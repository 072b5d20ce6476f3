// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/statistics/band_clusters.hpp"

namespace kalfem {

/// How far robust_covariance() widens the deviations of a right model by chance: the largest factor of each parameter
/// over 99 records in which the innovations are white and of size one, with the derivatives of this record, so that it
/// is exceeded once in a hundred times. Where a record says little of a parameter, its score is a small difference of
/// large ones, and the scatter of these along time is itself hardly known. The numbers are drawn from one seed: the
/// same record gives the same factors. `prior`: the information of the prior, p x p.
Eigen::VectorXd widening_by_chance(const SensitiveInnovations& innovations,
                                   const Eigen::Ref<const Eigen::MatrixXd>& prior);

}  // namespace kalfem
