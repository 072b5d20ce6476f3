// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/identification/step_budget.hpp"

namespace kalfem {

/// An unknown that has one value before a time and another one from it on, or drifts from one to the other.
struct ParameterJump {
  Eigen::Index unknown = 0;  ///< its place among all unknowns
  Eigen::Index sample = 0;   ///< the first one with the new value; of a drift, which has no such place, 0
  /// 95 % interval of that sample, as far as other places were tried: there the log-likelihood is lower by 3.7, which
  /// the largest of a walk with that drift exceeds once in twenty times (Siegmund 1988, Int. Stat. Review 56, 31-48).
  /// Of a drift the samples between which its course goes furthest, from `before` to `after`.
  Eigen::Index earliest = 0, latest = 0;
  double before = 0.0, after = 0.0;  ///< its estimates from the samples before, and at the end [its unit]
  double deviation = 0.0;            ///< standard deviation of after - before [its unit]
  /// Twice the rise of the log-likelihood over that of a constant, less where the run with the jump still contradicts
  /// the record: over the square of the factor by which its deviations are too small.
  double gain = 0.0;
  /// Whether innovations of the run with the jump agree with the model, so that nothing else is to be explained.
  bool explains = false;

  [[nodiscard]] bool is_drift() const { return sample == 0; }
};

struct JumpSearchResult {
  std::optional<ParameterJump> jump = {};
  bool stopped = false;  ///< before its end, as the budget allowed no further run
};

/// Looks for one unknown that changed once.
///
/// 1. From the run's own history, without another run: the scores u_k = P_k^-1 (theta_k - theta_N) of the samples until
///    k, about the last estimate, add up to a bridge of covariance J_k - J_k P_N J_k, J_k = P_k^-1 - P_0^-1, where the
///    unknowns are constant. T_i(k) = u_k,i^2 / (.)_ii is the Lagrange multiplier statistic of a change of unknown i at
///    sample k; its largest value over k is tested (Andrews 1993, Econometrica 61, 821-856).
/// 2. A run that forgets, as it renews every unknown after each fortieth of the record: about a model that holds a
///    changing unknown constant, scores are those of a compromise, and may hint at another unknown.
/// 3. For the unknown whose stretches show two levels most clearly, and those with a large T_i: runs that renew it at a
///    sample, which is moved by halved steps to the largest likelihood (generalised likelihood ratio, Willsky and Jones
///    1976, IEEE Trans. Automatic Control 21, 108-112). Within a limited budget the search ends where its first runs
///    explain little, and places the change as well as the budget allows.
///
/// Nothing where no change is significant, where it is within its own 95 % interval, or where the best one leaves most
/// of the contradiction: then the model is wrong in another way. `result`: of a run over the same record which kept the
/// unknowns' history; its model may have more substeps. `first`: the first sample that counts. `steps`: filter steps of
/// one run.
JumpSearchResult find_parameter_jump(const AugmentedModel& augmented_model, const FilterInput& input,
                                     const EstimationOptions& options, const EstimationResult& result,
                                     Eigen::Index first, double steps, StepBudget& budget);

}  // namespace kalfem
