// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/updating/residual.hpp"

namespace kalfem {

struct ParameterStatisticsOptions {
  double rank_tolerance = 1e-7;    ///< singular values below this part of the largest count as zero
  double poor_ratio = 0.9;         ///< poorly seen: deviation > poor_ratio times that of the prior
  double poor_deviation = 1.0;     ///< poorly seen without a prior: deviation > poor_deviation scale_i
  double high_correlation = 0.99;  ///< pairs above it are reported
};

/// How well the residual determines a parameter.
enum class Seen { well, poorly, not_at_all, held };  ///< held: equal bounds, or a bound that it ended at

/// A direction in the space of parameters along which the residual hardly changes.
struct UnidentifiableCombination {
  std::vector<Eigen::Index> parameters;  ///< those that take part, the greatest change first
  std::vector<double> changes;           ///< in parts of their scales; the greatest is 1
};

struct CorrelatedPair {
  Eigen::Index first = 0, second = 0;
  double correlation = 0.0;
};

/// What a residual tells about parameters at the minimum.
struct ParameterStatistics {
  /// Standard deviations; infinite where neither residual nor prior determines one, not a number at a bound.
  Eigen::VectorXd deviations;
  Eigen::MatrixXd covariance;   ///< p x p; of a parameter with infinite deviation only the diagonal is not zero
  Eigen::MatrixXd correlation;  ///< p x p; of undetermined parameters too: +-1 between two that cannot be told apart
  Eigen::VectorXd to_prior;     ///< deviation / that of the prior; 0 where there is no prior
  double degrees_of_freedom = 0.0;            ///< N - effective number of parameters
  std::optional<double> reduced_chi_squared;  ///< |r|^2 / degrees of freedom; nothing where they are fewer than one
  double variance_inflation = 1.0;            ///< kappa, of the residual's variances
  std::vector<Seen> seen;
  std::vector<UnidentifiableCombination> unidentifiable;  ///< each of two parameters or more
  std::vector<CorrelatedPair> correlated;                 ///< not those of one unidentifiable combination
  std::vector<bool> at_bound;                             ///< ended at a bound, and the residual pulls beyond it
  /// What stated numbers that are held fixed add to the deviations; empty: nothing is stated. See consider().
  Eigen::VectorXd considered = {};
};

/// Statistics of theta at the minimum of |r|^2 / 2 and the priors' share, from the residual and its Jacobian there:
///   H = J^T J + P,  P = diag(1 / deviation_i^2),        covariance = H^-1 (kappa J^T J + P) H^-1,
///   kappa = max(1, |r|^2 / (N - trace(J^T J H^-1))).
/// Residuals that are larger than their stated deviations show that these were too small or that the model cannot
/// follow the measurement: kappa widens the residual's part of the covariance by as much. Smaller ones narrow nothing.
/// A parameter that the cost pulls beyond its bound has no distribution about its estimate: it has no deviation, and
/// the statistics of the others are those with it held. Without priors it is the covariance kappa (J^T J)^-1 of
/// nonlinear regression [SW89]; with them, H^-1 where kappa is 1, and else that of the error of this estimate, which
/// weighted the residual by its stated deviations. `value.jacobian` is N x p.
ParameterStatistics parameter_statistics(const std::vector<UpdatingParameter>& parameters,
                                         const Eigen::VectorXd& values, const ResidualValue& value,
                                         const ParameterStatisticsOptions& options = {});

/// Sentences for a reader on what the residual does not tell: parameters that it does not see or sees poorly,
/// combinations that cannot be told apart, pairs of high correlation, parameters at a bound, residuals larger than
/// their deviations. Empty where all is well.
std::vector<std::string> parameter_findings(const std::vector<UpdatingParameter>& parameters,
                                            const Eigen::VectorXd& values, const ParameterStatistics& statistics);

/// The parameters without equal bounds whose columns of the Jacobian are zero: the residual does not depend on them.
std::vector<std::string> without_effect(const std::vector<UpdatingParameter>& parameters,
                                        const Eigen::MatrixXd& jacobian);

}  // namespace kalfem
