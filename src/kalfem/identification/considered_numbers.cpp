// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "kalfem/identification/freed_numbers.hpp"
#include "kalfem/identification/record_estimation.hpp"
#include "kalfem/identification/robust_deviations.hpp"
#include "kalfem/identification/runs_beside.hpp"
#include "kalfem/identification/white_innovations.hpp"

// What an estimation does about the numbers that it holds fixed.

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t most_learnt = 12;  ///< numbers that a filter has as unknowns beside the given ones

/// Stated numbers of the structure, those first that move the record most within what is stated.
std::vector<Index> most_telling(const FixedNumberStudy& study) {
  std::vector<Index> telling;
  const auto weight = [&](Index i) {
    const double deviation = study.numbers[static_cast<std::size_t>(i)].deviation;
    return study.information(i, i) * deviation * deviation;
  };
  for (Index i = 0; i < study.size(); ++i)
    if (study.numbers[static_cast<std::size_t>(i)].parameter && weight(i) > 1.0) telling.push_back(i);
  std::ranges::stable_sort(telling, std::ranges::greater{}, weight);
  if (telling.size() > most_learnt) telling.resize(most_learnt);
  return telling;
}

}  // namespace

void RecordEstimation::study_fixed_numbers(StepBudget& budget) {
  const bool stated = !problem_->settings.known_to.empty();
  if (estimate_.result.failure || estimate_.augmented_model->layout().unknowns == 0) return;
  if (!stated && !problem_->settings.diagnose) return;
  StepBudget unlimited;
  auto found = study_numbers(stated ? unlimited : budget);
  if (!found) return estimate_.leave_out("how the estimates move with numbers that are held fixed");
  confirm_asked(problem_, screening_->setup(), screening_->record(), estimate_, found->study);
  estimate_.fixed_numbers = std::make_shared<const FixedNumberStudy>(std::move(found->study));
  if (estimate_.fixed_numbers->any_stated()) take_considered(found->considered);
}

NumberTrials RecordEstimation::try_numbers(StepBudget& budget) {
  return kalfem::try_numbers(problem_, screening_->setup(), screening_->record(), estimate_, budget);
}

std::optional<RecordEstimation> RecordEstimation::with_numbers(const ChangedNumbers& changed,
                                                               NoiseOfSensors noise) const try {
  RecordEstimation other = *this;
  if (!changed.empty()) {
    auto at = at_numbers(given_->problem, given_->setup, given_->record, changed);
    other.problem_ = std::move(at.problem);
    other.setup_ = std::move(at.setup);
    other.record_ = std::move(at.record);
    other.log_jacobian_ = at.log_jacobian.size() > 0 ? at.log_jacobian : VectorXd::Zero(other.record_.samples());
    other.changed_ = changed;
    other.correct();
    if (other.likelihood_) other.log_jacobian_ += other.likelihood_->corrected.log_jacobian;
  }
  if (noise == NoiseOfSensors::as_recorded) {
    auto problem = std::make_shared<EstimationProblem>(*other.problem_);
    problem->settings.adaptive_noise.sensors = true;
    other.problem_ = std::move(problem);
  }
  other.setup_.substeps = estimate_.substeps;
  other.looked_for_change_ = false;
  other.estimate_.jump.reset();
  other.run_first();
  if (other.estimate_.result.failure) return std::nullopt;
  StepBudget unlimited;
  other.repeat_from_estimates(unlimited);
  return other;
} catch (const InvalidInput&) {
  return std::nullopt;
}

std::optional<VectorXd> RecordEstimation::learnt_numbers(const FixedNumberStudy& study) const try {
  const std::vector<Index> telling = most_telling(study);
  if (telling.empty()) return std::nullopt;
  EstimationProblemPtr with = given_->problem;
  for (const Index i : telling) {
    const auto& number = study.numbers[static_cast<std::size_t>(i)];
    with = with_unknown(*with, number, number.deviation * number.scale);
  }
  IssueList issues;
  auto setup = make_augmented_model_setup(*with, *given_->setup.parts, given_->setup.linear_unknowns.present, issues);
  issues.raise();
  setup.substeps = estimate_.substeps;
  RecordEstimation other(with, std::move(setup), given_->record, options_);
  other.answer();
  const auto& result = other.estimate().result;
  if (result.failure) return std::nullopt;
  VectorXd changes = VectorXd::Zero(study.size());
  const VectorXd learnt = result.unknowns.mean.rightCols(1);
  for (std::size_t n = 0; n < telling.size(); ++n) {
    const auto& number = study.numbers[static_cast<std::size_t>(telling[n])];
    const Index row = learnt.size() - std::ssize(telling) + static_cast<Index>(n);
    changes[telling[n]] = (learnt[row] - number.value) / number.scale;
  }
  return changes;
} catch (const InvalidInput&) {
  return std::nullopt;
}

std::optional<FixedNumberResult> RecordEstimation::study_numbers(StepBudget& budget) const {
  return kalfem::study_fixed_numbers(problem_, screening_->setup(), screening_->record(), estimate_, options_, budget,
                                     changed_);
}

double RecordEstimation::log_likelihood() const {
  const double jacobian =
      log_jacobian_.size() == 0 ? 0.0 : log_jacobian_.tail(log_jacobian_.size() - estimate_.settled).sum();
  return log_likelihood_from(estimate_.result, estimate_.settled) + jacobian;
}

/// Innovations are those with the fixed numbers as the record asks for within what is stated. Where these agree with
/// the model, scores that the numbers bend widen no deviation.
void RecordEstimation::take_considered(const ConsideredNumbers& considered) {
  auto& result = estimate_.result;
  estimate_.considered_deviation = estimate_.fixed_numbers->considered.rowwise().norm();
  widen_monitored(considered.monitored, considered.monitored);
  const WhiteInnovations whiten(result);
  result.innovation += considered.innovation;
  const VectorXd nis = whiten(result.innovation).colwise().squaredNorm();
  result.nis = result.nis.array().isFinite().select(nis, result.nis);
  estimate_.consistency = summarise_consistency(result.nis, result.measured, result.innovation,
                                                estimate_.measurements.noise(), estimate_.settled);
  if (innovations_contradict(estimate_, estimate_.settled)) return;
  const Index last = result.unknowns.deviation.cols() - 1;
  for (Index i = 0; i < estimate_.robust_deviation.size(); ++i)
    if (std::isfinite(estimate_.robust_deviation[i]))
      estimate_.robust_deviation[i] = result.unknowns.deviation(i, last);
}

}  // namespace kalfem
