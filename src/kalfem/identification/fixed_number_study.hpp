// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/identification/numbers_at.hpp"
#include "kalfem/identification/step_budget.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

struct RecordEstimate;
struct RecordEstimateOptions;

/// How an estimation moves with the numbers c that it holds fixed, and what the record says of them. Each c_i is
/// counted in its scale; c = 0 is the value that is held. Derivatives hold where the estimation stands.
struct FixedNumberStudy {
  std::vector<FixedNumber> numbers;
  Eigen::VectorXd stands_at;  ///< c of the estimation, of which the scores at c = 0 follow
  Eigen::MatrixXd shift;  ///< d theta_j / d c_i, the last estimates of the unknowns, unknowns x numbers [their unit]
  Eigen::VectorXd score;  ///< g_i = d ln L / d c_i
  /// I_ij = -d2 ln L / d c_i d c_j, the unknowns estimated along with c.
  Eigen::MatrixXd information;
  /// The most likely change of each stated number within what is stated: (I + S^-1)^-1 g, S the stated variances; 0 of
  /// the others.
  Eigen::VectorXd allowed;
  /// What the record asks for: the change of c_i alone that makes it most likely, the other stated numbers allowed for;
  /// its standard deviation, infinite where the record does not tell; and the rise of ln L.
  Eigen::VectorXd asked, asked_deviation, gain;
  /// The rise of ln L, and of the logarithm of what is stated of the other numbers, with the asked change; not a number
  /// where confirm_asked() did not look.
  Eigen::VectorXd confirmed;
  /// Standard deviations that the stated numbers add to the unknowns, each by itself, unknowns x numbers. A share s of
  /// the held value, which may be meant of the true one, counts as s / (1 - s). Where the estimation stands at other
  /// values than are held, they are those of the posterior (I + S^-1)^-1, by its square root.
  Eigen::MatrixXd considered;
  std::vector<std::string> failed = {};   ///< numbers beside whose value no run was possible
  std::vector<std::string> by_runs = {};  ///< numbers without a tangent, from a run beside their value

  [[nodiscard]] Eigen::Index size() const { return score.size(); }
  [[nodiscard]] bool any_stated() const;
  [[nodiscard]] bool is_moved() const { return (stands_at.array() != 0.0).any(); }
  /// Whether the change that the record asks for is significant at .5 % over all numbers together, beyond what is
  /// stated of the number.
  [[nodiscard]] bool is_significant(Eigen::Index i) const;
  /// By which what is stated of number i may be larger, counted from what the record asks for.
  [[nodiscard]] double room(Eigen::Index i) const;
  /// Number i at what is asked for, though not further than `most` from where it stands; the stated ones as it then
  /// allows them.
  [[nodiscard]] Eigen::VectorXd with_asked(Eigen::Index i, double most) const;
  /// What the linear prediction has for `confirmed`.
  [[nodiscard]] double promised_rise(Eigen::Index i) const;
};

/// What stated numbers do to an estimation along its record.
struct ConsideredNumbers {
  Eigen::MatrixXd monitored;   ///< standard deviations that they add to monitored quantities, quantities x samples
  Eigen::MatrixXd innovation;  ///< what the allowed changes add to the innovations, channels x samples
};

struct FixedNumberResult {
  FixedNumberStudy study;
  ConsideredNumbers considered;  ///< empty where nothing is stated
};

/// Score test of every number that an estimation holds fixed (Rao 1948, Proc. Camb. Phil. Soc. 44, 50-57), and what
/// numbers that are known to some deviation add to its own (consider parameters: Schmidt 1966, Advances in Control
/// Systems 3, 293-340).
///
/// The filter runs once more, about the estimates, and keeps its gains K_k; a run of the mean alone with these gains
/// and the tangents of the numbers (run_tangents()) tells how innovations and estimates move,
///     D_i,k = d nu_k / d c_i,   d theta / d c_i,
/// and with the innovations nu_k and their covariances S_k of the filter
///     g_i = -sum_k D_i,k^T S_k^-1 nu_k,   I_ij = sum_k D_i,k^T S_k^-1 D_j,k.
/// over the samples that are judged: behind an unknown start, its wide prior bends more than a wrong number does. Gains
/// and S_k do not depend on c here: what that leaves out is of second order where innovations are white.
/// `changed`: the numbers of the problem, where they are not as they are held; about them
///     g(0) = g + I c.
///
/// Nothing where the filter stops, the estimates make no structure, or its gains and derivatives need more than a
/// gigabyte; `budget`: filter steps.
std::optional<FixedNumberResult> study_fixed_numbers(const EstimationProblemPtr& problem,
                                                     const AugmentedModelSetup& setup, const Record& record,
                                                     const RecordEstimate& estimate,
                                                     const RecordEstimateOptions& options, StepBudget& budget,
                                                     const ChangedNumbers& changed = {});

/// Repeats the run of an estimate with each of up to three of the likeliest significant changes that its study found,
/// and sets `confirmed`: their linear prediction may reach too far, as along a direction that the record hardly tells a
/// change is large; and about the estimates the filter learns otherwise than from its first guess. The problem is that
/// of the estimate: it stands at the study's changes.
void confirm_asked(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                   const RecordEstimate& estimate, FixedNumberStudy& study);

}  // namespace kalfem
