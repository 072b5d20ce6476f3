// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

/// What a record and the priors tell of the constant unknowns of an estimation, all samples linearised about one point,
/// in the coordinates x of the filter's state.
struct UnknownInformation {
  std::vector<Eigen::Index> unknowns;  ///< their places among the filter's unknowns
  Eigen::MatrixXd covariance;          ///< P = (I + P_0^-1)^-1
  Eigen::VectorXd step;                ///< from the filter's estimate to the maximum of the posterior
  /// sqrt(P_ii + step_i^2) over the deviation of the filter where that is too sure of the unknown: sqrt(P_ii) is more
  /// than 1.5 times as large, or the maximum more than two of its deviations away; 0 of the others.
  Eigen::VectorXd widening = {};

  [[nodiscard]] bool any_too_sure() const { return widening.size() > 0 && widening.maxCoeff() > 0.0; }
  /// Mean square of x less the filter's estimates: P + step step^T.
  [[nodiscard]] Eigen::MatrixXd about_the_estimates() const { return covariance + step * step.transpose(); }
};

/// A filter linearises each sample about the estimate of that moment. Where the record hardly tells a combination of
/// unknowns, and the model bends along it (logarithms do), linearisations about different estimates disagree on which
/// combination that is; their sum then tells them all, and the filter's deviations are too small by any factor (Julier
/// and Uhlmann 2001, ICRA, 4238-4243; Huang, Mourikis and Roumeliotis 2010, Int. J. Robotics Research 29, 502-528).
///
/// So a filter of the motion alone runs once more, the constant unknowns held at their estimates, and keeps its gains;
/// the tangents of its mean by these numbers (run_tangents()) are d nu_k / d x, and with the covariances S_k of the
/// innovations nu_k
///     g = -sum_k (d nu_k / d x)^T S_k^-1 nu_k,   I = sum_k (d nu_k / d x)^T S_k^-1 (d nu_k / d x),
/// with which the maximum of the posterior is P (g - P_0^-1 (x - x_0)) away.
///
/// Nothing where no unknown is constant, the filter stops, the estimates make no structure, or the derivatives are
/// parallel but for rounding. `budget`: filter steps; nothing, too, where it does not allow the run.
std::optional<UnknownInformation> information_at_estimates(const EstimationProblemPtr& problem, const Record& record,
                                                           const RecordEstimate& estimate, StepBudget& budget);

}  // namespace kalfem
