// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/freed_numbers.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/identification/asked_numbers.hpp"
#include "kalfem/identification/likelihood_unknowns.hpp"
#include "kalfem/identification/measurement_unknowns.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/identification/released_elements.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr std::size_t most_tried = 3;
constexpr double usual_prior = 0.1;  ///< in the number's scale; of a clock the change that is asked for decides alone
constexpr double prior_of_asked = 3.0;    ///< in the change that is asked for
constexpr double learned = 2.0 / 3.0;     ///< of a record, before what is predicted
constexpr double likelihood_runs = 20.0;  ///< that a search for a gain takes over what is learned from, about

std::vector<MovedEstimate> moved_to(const RecordEstimate& before, const std::vector<UnknownParameter>& unknowns,
                                    const VectorXd& after) {
  std::vector<MovedEstimate> moved;
  const auto& former = before.augmented_model->options().unknowns;
  const VectorXd last = before.result.unknowns.mean.rightCols(1);
  for (std::size_t i = 0; i < former.size(); ++i) {
    const auto now = std::ranges::find(unknowns, former[i].name, &UnknownParameter::name);
    if (now == unknowns.end()) continue;
    const auto row = static_cast<Index>(i);
    const double value = after[now - unknowns.begin()];
    moved.push_back({.name = former[i].name,
                     .unit = former[i].unit,
                     .before = last[row],
                     .after = value,
                     .deviations = (value - last[row]) / interval_deviation(before, row)});
  }
  return moved;
}

/// Runs of the filter over one record, with and without a number more among its unknowns.
class TrialRuns {
public:
  TrialRuns(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
            const RecordEstimate& estimate)
      : problem_(with_substeps(*problem, estimate)),
        setup_(setup),
        record_(record),
        estimate_(estimate),
        learned_(static_cast<Index>(learned * static_cast<double>(record.samples_used()))) {
    setup_.starts_at_rest = !estimate.start.moving;
    setup_.options.substeps = estimate.augmented_model->options().substeps;
  }

  [[nodiscard]] double cost_of_run() const { return steps_of_run(*problem_, record_, *problem_->settings.substeps); }
  [[nodiscard]] double cost_of(const FixedNumber& number) const {
    return cost_of_run() * (number.parameter ? 1.0 : 1.0 + learned * likelihood_runs);
  }

  /// As it was. False where the filter stops.
  bool run_as_given() {
    auto run = run_of(problem_, setup_, record_);
    if (run.result.failure) return false;
    given_ = std::move(run.result);
    return true;
  }

  /// Where the filter stops with it, it is not kept.
  TriedNumber try_number(const FixedNumber& number, double asked) try {
    TriedNumber tried{.name = name_as_unknown(number), .number = number, .prior = prior_of(number, asked)};
    const auto with = with_unknown(*problem_, number, tried.prior);
    const auto run = number.parameter ? with_parameter(with, tried) : with_signal(with, tried);
    if (!run) return tried;
    tried.predicted = predicted_more(run->result);
    tried.kept = tried.predicted >= fewest_predicted;
    moved_ = moved_to(estimate_, run->unknowns, run->result.unknowns.mean.rightCols(1));
    return tried;
  } catch (const InvalidInput&) {
    return {.name = name_as_unknown(number), .number = number, .prior = prior_of(number, asked)};
  }

  /// By the last number that was tried.
  [[nodiscard]] const std::vector<MovedEstimate>& moved() const { return moved_; }

private:
  struct Run {
    std::vector<UnknownParameter> unknowns;
    EstimationResult result;
  };

  static EstimationProblemPtr with_substeps(const EstimationProblem& problem, const RecordEstimate& estimate) {
    auto own = std::make_shared<EstimationProblem>(problem);
    own->settings.substeps = estimate.augmented_model->options().substeps;
    return own;
  }

  static double prior_of(const FixedNumber& number, double asked) {
    if (number.deviation > 0.0) return number.deviation * number.scale;
    return number.scale * std::max(number.is_of_clock() ? 0.0 : usual_prior, prior_of_asked * std::abs(asked));
  }

  [[nodiscard]] Run run_of(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                           const Record& record) const {
    const FilterRun made = make_filter_run(problem, setup, record);
    return {made.choice.augmented_model->options().unknowns,
            kalfem::estimate(*made.choice.augmented_model, made.input,
                             rerun_options(made.choice.filter, problem->settings, estimate_))};
  }

  [[nodiscard]] std::optional<Run> with_parameter(const EstimationProblemPtr& with, TriedNumber& tried) const {
    IssueList issues;
    auto setup = make_augmented_model_setup(*with, *setup_.parts, setup_.linear_unknowns.present, issues);
    issues.raise();
    setup.starts_at_rest = setup_.starts_at_rest;
    Run run = run_of(with, setup, record_);
    if (run.result.failure) return std::nullopt;
    const Index row = std::ssize(with->settings.unknowns) - 1, last = run.result.unknowns.mean.cols() - 1;
    tried.value = run.result.unknowns.mean(row, last);
    tried.deviation = run.result.unknowns.deviation(row, last);
    return run;
  }

  /// A gain, delay or drift, found from what is before the last third.
  [[nodiscard]] std::optional<Run> with_signal(const EstimationProblemPtr& with, TriedNumber& tried) const {
    Record before = record_;
    before.used = learned_;
    const auto found = estimate_likelihood_unknowns(with, setup_, before, {.unscented = problem_->settings.unscented});
    if (!found) return std::nullopt;
    tried.value = found->values[0];
    tried.deviation = found->deviation[0];
    const CorrectedProblem whole = corrected(with, setup_, record_, found->values);
    Run run = run_of(whole.problem, whole.setup, whole.record);
    if (run.result.failure) return std::nullopt;
    run.result.log_density += whole.log_jacobian;
    return run;
  }

  /// Over the last third, where both saw the same channels.
  [[nodiscard]] double predicted_more(const EstimationResult& with) const {
    double sum = 0.0;
    for (Index k = learned_; k < with.log_density.size(); ++k)
      if (with.measured[k] == given_.measured[k]) sum += with.log_density[k] - given_.log_density[k];
    return sum;
  }

  EstimationProblemPtr problem_;
  AugmentedModelSetup setup_;
  const Record& record_;
  const RecordEstimate& estimate_;
  Index learned_;  ///< samples before the last third
  EstimationResult given_;
  std::vector<MovedEstimate> moved_;
};

}  // namespace

std::vector<TriedNumber> FreedNumbers::kept() const {
  std::vector<TriedNumber> kept;
  std::ranges::copy_if(tried, std::back_inserter(kept), &TriedNumber::kept);
  return kept;
}

bool can_be_freed(const FixedNumber& number) {
  return number.parameter.has_value() || number.kind == FixedNumberKind::gain ||
         (number.is_of_clock() && number.of_sensor);
}

std::string name_as_unknown(const FixedNumber& number) {
  return number.of_sensor ? "sensors." + number.name : number.name;
}

EstimationProblemPtr with_unknown(const EstimationProblem& problem, const FixedNumber& number, double prior) {
  auto with = std::make_shared<EstimationProblem>(problem);
  std::erase_if(with->settings.known_to, [&](const KnownTo& known) { return known.name == number.name; });
  if (!number.parameter) {
    add_measurement_unknown(name_as_unknown(number), {.initial = number.value, .deviation = prior}, *with);
    return with;
  }
  const Parameter& target = *number.parameter;
  const bool stays_positive =
      number.value > 0.0 && (!can_be_released(problem.structure->parts, target) || is_positive_by_nature(target));
  with->settings.unknowns.push_back({.name = number.name,
                                     .targets = {target},
                                     .transform = {stays_positive ? TransformKind::log : TransformKind::none},
                                     .initial = number.value,
                                     .deviation = prior});
  return with;
}

NumberTrials try_numbers(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                         const RecordEstimate& estimate, StepBudget& budget) {
  NumberTrials trials;
  const auto& study = *estimate.fixed_numbers;
  std::vector<Index> asked = asked_numbers(estimate);
  const double most = asked.empty() ? 0.0 : study.gain[asked.front()];
  std::erase_if(asked, [&](Index i) {
    return !can_be_freed(study.numbers[static_cast<std::size_t>(i)]) || study.gain[i] < most - as_likely;
  });
  if (asked.size() > most_tried) asked.resize(most_tried);
  if (asked.empty()) return trials;
  TrialRuns runs(problem, setup, record, estimate);
  trials.stopped = !budget.take(runs.cost_of_run());
  if (trials.stopped || !runs.run_as_given()) return trials;
  for (const Index i : asked) {
    const FixedNumber& number = study.numbers[static_cast<std::size_t>(i)];
    trials.stopped = !budget.take(runs.cost_of(number));
    if (trials.stopped) return trials;
    trials.tried.push_back(runs.try_number(number, study.asked[i]));
    if (!trials.tried.back().kept) continue;
    trials.moved = runs.moved();
    return trials;
  }
  return trials;
}

std::vector<MovedEstimate> moved_estimates(const RecordEstimate& before, const RecordEstimate& after) {
  return moved_to(before, after.augmented_model->options().unknowns, after.result.unknowns.mean.rightCols(1));
}

}  // namespace kalfem
