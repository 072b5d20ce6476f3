// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/filter_run.hpp"
#include "kalfem/statistics/maximum_likelihood.hpp"

namespace kalfem {

/// A problem with its likelihood unknowns at some values: the filter's model, and the record as sensors without gain
/// and with true clocks would have recorded it.
struct CorrectedProblem {
  EstimationProblemPtr problem;  ///< without likelihood unknowns
  AugmentedModelSetup setup;
  Record record;
  /// ln |d corrected / d recorded| of each sample, summed over the channels from which the filter learns.
  Eigen::VectorXd log_jacobian;
};

/// `values`: of the problem's likelihood unknowns, in their own units. A recorded channel is
///     recorded(t + delay + drift (t - since)) = gain signal(t) + noise,
/// so the corrected one is recorded(t + delay + drift (t - since)) / gain with its noise / |gain|, missing within the
/// clock's reach of either end of the record.
CorrectedProblem corrected(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                           const Eigen::VectorXd& values);

/// A record of the same sensors corrected alike.
Record corrected_record(const std::vector<LikelihoodUnknown>& unknowns, const Eigen::VectorXd& values, Record record);

/// A record of true clocks as sensors with these delays and drifts show it.
Record with_clocks(const std::vector<LikelihoodUnknown>& unknowns, const Eigen::VectorXd& values, Record record);

/// The 95 % interval from the larger of the two deviations, symmetric in the coordinate of the search.
struct LikelihoodInterval {
  double lower = 0.0, upper = 0.0;
  bool robust = false;
};

/// Values of one likelihood unknown that were tried before the search, the others at their first guesses.
struct TriedValues {
  Eigen::Index unknown = 0;
  std::vector<double> values = {};          ///< ascending [its unit]
  std::vector<double> log_likelihood = {};  ///< of the record
};

/// What the record tells of the likelihood unknowns.
struct LikelihoodEstimate {
  std::vector<LikelihoodUnknown> unknowns;
  Eigen::VectorXd values;
  Eigen::VectorXd deviation, robust_deviation;  ///< [the unknowns' units]
  /// Whether the record tells of it: its deviation is well below the prior's.
  std::vector<bool> visible;
  /// What their uncertainty adds to the covariance of the filter's unknowns, in the filter's state.
  Eigen::MatrixXd added_covariance;
  std::vector<TriedValues> tried;  ///< of clocks and gains
  bool converged = false;
  int runs = 0;  ///< of the filter over the record
  CorrectedProblem corrected;

  [[nodiscard]] LikelihoodInterval interval(Eigen::Index i) const;
};

/// Finds the likelihood unknowns of a problem: those values at which the record is most likely, the filter's unknowns
/// and states integrated out. No state of the filter stands for them, so a delay costs nothing but the search, and is
/// exact at every frequency.
///
/// 1. Gains are tried with either sign; delays and drifts over the range of their prior, one after another. One that
///    changes the likelihood by no more than chance keeps its prior.
/// 2. Newton's method, maximise_likelihood(), in delay / sample interval, drift record length / sample interval,
///    ln |gain|, ln noise. Bounds: 4 prior deviations of a delay or drift.
/// 3. Their covariance Psi widens that of the filter's unknowns theta by J Psi J^T, J = d theta / d psi from central
///    differences: the law of total covariance.
///
/// `run`: the filter over the corrected record; empty: run_filter(). Nothing where the filter fails at the first guess,
/// as the run itself will say.
std::optional<LikelihoodEstimate> estimate_likelihood_unknowns(
    const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
    const EstimationOptions& options, std::function<EstimationResult(const CorrectedProblem&)> run = {});

}  // namespace kalfem
