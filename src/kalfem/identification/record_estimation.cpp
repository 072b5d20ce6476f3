// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/record_estimation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/identification/change_hints.hpp"
#include "kalfem/identification/open_loop.hpp"
#include "kalfem/identification/parameter_drift.hpp"
#include "kalfem/identification/refined_filter.hpp"
#include "kalfem/identification/robust_deviations.hpp"
#include "kalfem/identification/settling.hpp"
#include "kalfem/identification/unknown_information.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Of a sample interval in the search for a jump: what finer steps add is smaller than the jumps that are told.
constexpr int most_jump_substeps = 4, limited_jump_substeps = 1;
constexpr int few_passes = 2, more_passes = 4;  ///< from a contradictory run's own estimates
constexpr double far_better = 3e-3;             ///< of a prior's deviation: an estimate's that asks for a second pass
constexpr double what_matters = 0.3;            ///< standard deviations by which this moves an estimate
/// Statistic of the scores: a step that is too coarse biases estimates alike throughout a record.
constexpr double change_beyond_steps = 100.0;
/// Mean NIS over what is expected: a run that contradicts itself, and by how much rest must be better.
constexpr double contradicting_nis = 2.0, far_less = 0.5;
constexpr double most_of_gains = 2e8;  ///< [byte]
constexpr Index first_samples = 20;    ///< by which a start is told from spikes, and more

/// Takes the rows of unknown inputs, which stand behind the monitored quantities.
std::vector<EstimatedInput> take_inputs(const std::vector<UnknownInput>& inputs, EstimatedSeries& monitored) {
  auto& [mean, deviation] = monitored;
  const auto count = static_cast<Index>(inputs.size()), others = mean.rows() - count;
  std::vector<EstimatedInput> taken;
  for (Index i = 0; i < count; ++i)
    taken.push_back(
        {inputs[static_cast<std::size_t>(i)], mean.row(others + i).transpose(), deviation.row(others + i).transpose()});
  mean.conservativeResize(others, Eigen::NoChange);
  deviation.conservativeResize(others, Eigen::NoChange);
  return taken;
}

/// Smooths the filter's run. Where rounding stops the smoother, as it may where some motions are known a million times
/// better than others, the run is repeated in physical coordinates, and with square roots of covariances, which
/// rounding does not make negative. Nothing where no form of the filter can be smoothed.
std::optional<SmoothedRecord> smooth_safely(const EstimationProblemPtr& problem, const Screening& screening,
                                            const EstimationOptions& options, const FilteredRecord& filtered) {
  if (auto smoothed = smooth(*filtered.run.choice.augmented_model, filtered.run.input, options, filtered.result))
    return smoothed;
  const auto used = filtered.run.choice.augmented_model->options().coordinates;
  const std::vector<std::pair<FilterKind, StateCoordinates>> safer{
      {FilterKind::partially_linear, StateCoordinates::physical},
      {FilterKind::partially_linear_square_root, StateCoordinates::physical}};
  for (const auto& [kind, coordinates] : safer) {
    if (kind == options.filter && coordinates == used) continue;
    const FilterRun run =
        make_filter_run_like(filtered.run, problem, screening.setup(), screening.record(), coordinates);
    EstimationOptions again = options;
    again.filter = kind;
    const EstimationResult result = estimate(*run.choice.augmented_model, run.input, again);
    if (result.failure) continue;
    if (auto smoothed = smooth(*run.choice.augmented_model, run.input, again, result)) return smoothed;
  }
  return std::nullopt;
}

/// The first sample of the error and consistency figures: a run that failed while it settled is judged from its start.
Index first_judged(const EstimationResult& result, Index settled) {
  return result.failure && settled >= std::max<Index>(1, result.failure->computed) ? 0 : settled;
}

/// The deviations of the filter's unknowns with what those of the likelihood unknowns add.
void add_uncertainty(const LikelihoodEstimate& likelihood, RecordEstimate& estimate) {
  auto& result = estimate.result;
  const Index first = estimate.augmented_model->layout().unknown(), count = likelihood.added_covariance.rows();
  if (result.failure || count == 0) return;
  result.final_covariance.block(first, first, count, count) += likelihood.added_covariance;
  for (Index i = 0; i < count; ++i) {
    const auto& transform = estimate.augmented_model->options().unknowns[static_cast<std::size_t>(i)].transform;
    const auto widened = [](double deviation, double added) { return std::sqrt(deviation * deviation + added); };
    for (Index k = 0; k < result.unknowns.mean.cols(); ++k) {
      const double slope = transform.slope(result.state.mean(first + i, k));
      result.state.deviation(first + i, k) =
          widened(result.state.deviation(first + i, k), likelihood.added_covariance(i, i));
      result.unknowns.deviation(i, k) = slope * result.state.deviation(first + i, k);
    }
    const double slope = transform.slope(result.state.mean(first + i, result.state.mean.cols() - 1));
    estimate.robust_deviation[i] =
        widened(estimate.robust_deviation[i], slope * slope * likelihood.added_covariance(i, i));
  }
}

/// Whether the structure is taken to move at the first sample because of the first samples alone.
bool start_is_read_off(const RecordStart& start, const AugmentedModelSetup& setup, const Record& record,
                       const EstimationSettings& settings) {
  return start.moving && !setup.starts_at_rest && record.start <= 0.0 && !states_initial_motion(settings);
}

/// Mean NIS from a sample on, over what is expected of it; infinite where the filter stopped.
double relative_nis(const FilteredRecord& filtered, Index first = 0) {
  const auto& result = filtered.result;
  if (result.failure) return std::numeric_limits<double>::infinity();
  const auto found =
      summarise_consistency(result.nis, result.measured, result.innovation, filtered.run.input.measured.noise(), first);
  return found.mean_nis / found.expected_nis;
}

/// Whether the innovations of a run's last quarter agree with the model.
bool agrees_at_its_end(const RecordEstimate& estimate) {
  return !innovations_contradict(estimate, std::max(estimate.settled, 3 * estimate.measurements.samples() / 4));
}

/// Whether a run over the record no longer contradicts itself where the one before did.
bool explains_more(const RecordEstimate& again, const RecordEstimate& before) {
  if (again.result.failure || innovations_contradict(again, again.settled)) return false;
  return innovations_contradict(before, before.settled) || !contradicts_itself(again);
}

/// Whether the record knows an unknown much better than its prior.
bool is_far_better_known(const RecordEstimate& estimate) {
  const auto& model = *estimate.augmented_model;
  const auto& deviation = estimate.result.state.deviation;
  for (Index i = 0; i < model.layout().unknowns; ++i) {
    const auto& unknown = model.options().unknowns[static_cast<std::size_t>(i)];
    const double prior = unknown.deviation / unknown.transform.slope(unknown.transform.to_state(unknown.initial));
    const double now = deviation(model.layout().unknown() + i, deviation.cols() - 1);
    if (unknown.random_walk == 0.0 && now < far_better * prior) return true;
  }
  return false;
}

/// Whether another run's estimates lie elsewhere by what matters beside their deviations.
bool moves(const RecordEstimate& before, const RecordEstimate& after) {
  const auto& [mean, deviation] = after.result.unknowns;
  const Eigen::ArrayXd distance = (mean.rightCols(1) - before.result.unknowns.mean.rightCols(1)).array().abs();
  return (distance > what_matters * deviation.rightCols(1).array()).any();
}

/// Whether the run is judged by its gains, see RecordEstimation::widen_by_step().
bool keeps_gains(const EstimationProblem& problem, const AugmentedModelSetup& setup, const Record& record,
                 const RecordEstimateOptions& options) {
  const auto states = static_cast<double>(2 * setup.model->system().size() + std::ssize(setup.options.unknowns));
  const double memory = sizeof(double) * states * static_cast<double>(std::ssize(setup.sensors) * record.samples());
  return !options.monitored.empty() && !problem.settings.substeps && memory <= most_of_gains;
}

EstimationOptions filter_options(const EstimationProblem& problem, const AugmentedModelSetup& setup,
                                 const Record& record, const RecordEstimateOptions& options) {
  const auto& settings = problem.settings;
  return {.unscented = settings.unscented,
          .threads = filter_threads(settings),
          .passes = settings.passes,
          .state_deviations = false,
          .deviation_stride = options.deviation_stride,
          .keep_gains = keeps_gains(problem, setup, record, options),
          .keep_unknowns = true,
          .step_shift = can_judge_step(settings) && !settings.substeps && !setup.substeps,
          .adaptive_noise = settings.adaptive_noise,
          .monitored = with_inputs(make_outputs(*setup.model, options.monitored),
                                   held_by(settings.unknown_inputs, setup), *setup.model),
          .progress = options.progress};
}

}  // namespace

RecordEstimation::RecordEstimation(EstimationProblemPtr problem, AugmentedModelSetup setup, Record record,
                                   const RecordEstimateOptions& options)
    : given_(std::make_shared<Given>(Given{problem, setup, record})),
      problem_(std::move(problem)),
      setup_(std::move(setup)),
      record_(std::move(record)),
      options_(options) {
  options_.progress = passes_of(options.progress, "filter pass");
}

void RecordEstimation::answer() {
  correct();
  run_first();
  const SubstepChoice& choice = estimate_.substeps;
  if (!choice.chosen || setup_.substeps || estimate_.result.failure) return;
  screening_->keep_start(estimate_.start);
  SubstepOptions options = SubstepOptions::of(problem_->settings.step_order);
  options.first = choice.substeps;
  if (auto within = judge_within_run(screening_->setup(), estimate_.result, options)) {
    estimate_.substeps = *std::move(within);
    return;
  }
  SubstepChoice compared = compare_with_half(problem_, screening_->setup(), screening_->record(), screening_->options(),
                                             estimate_.result, options);
  other_steps_ += steps_of_run(*problem_, record_, choice.substeps / 2);
  estimate_.substeps = std::move(compared);
}

/// Finds gains, delays and noise by maximum likelihood. Where the filter fails at their first guesses, these are taken,
/// for its failure.
void RecordEstimation::correct() {
  const auto& unknowns = problem_->settings.likelihood_unknowns;
  if (unknowns.empty()) return;
  likelihood_ = estimate_likelihood_unknowns(
      problem_, setup_, record_,
      {.unscented = problem_->settings.unscented, .adaptive_noise = problem_->settings.adaptive_noise});
  CorrectedProblem at;
  if (likelihood_) {
    at = likelihood_->corrected;
  } else {
    VectorXd values(static_cast<Index>(unknowns.size()));
    for (Index i = 0; i < values.size(); ++i) values[i] = unknowns[static_cast<std::size_t>(i)].initial;
    at = corrected(problem_, setup_, record_, values);
  }
  problem_ = at.problem;
  setup_ = at.setup;
  record_ = at.record;
}

/// With the substeps that are given, those decided before, or the first ones to try.
void RecordEstimation::run_first() {
  const auto options = SubstepOptions::of(problem_->settings.step_order);
  SubstepChoice choice{.substeps = options.first, .chosen = true};
  const auto& given = problem_->settings.substeps;
  if (given) choice = {.substeps = *given, .words = "given"};
  if (!given && setup_.substeps) choice = *setup_.substeps;
  const auto screen = [&](int substeps) {
    screening_.emplace(problem_, setup_, record_, filter_options(*problem_, setup_, record_, options_));
    return screening_->run(substeps);
  };
  FilteredRecord filtered = screen(choice.substeps);
  if (filtered.result.failure && !given && !setup_.substeps) {
    const Screening coarse = *screening_;
    FilteredRecord finer = screen(options.rescue * choice.substeps);
    if (finer.result.failure) {
      screening_ = coarse;
    } else {
      choice.substeps *= options.rescue;
      filtered = std::move(finer);
    }
  }
  if (start_is_read_off(filtered.run.start, setup_, record_, problem_->settings) &&
      relative_nis(filtered) > contradicting_nis)
    try_rest(filtered, choice.substeps);
  evaluate(std::move(filtered), std::move(choice));
}

/// The filter from rest, which stays where it contradicts itself far less behind the first samples, as spikes among
/// these may be all that looks like motion.
void RecordEstimation::try_rest(FilteredRecord& filtered, int substeps) {
  AugmentedModelSetup from_rest = setup_;
  from_rest.starts_at_rest = true;
  Screening screening(problem_, from_rest, record_, filter_options(*problem_, setup_, record_, options_));
  FilteredRecord at_rest = screening.run(substeps);
  const bool better = relative_nis(at_rest, first_samples) < far_less * relative_nis(filtered, first_samples);
  other_steps_ += better ? screening_->steps() : screening.steps();
  if (!better) return;
  setup_ = std::move(from_rest);
  screening_ = std::move(screening);
  filtered = std::move(at_rest);
}

/// Further passes, each from the parameters of the one before, or from these and the motion at the start where that is
/// unknown. They are kept where the last one no longer contradicts itself, or its innovations no longer do: so the
/// first guess was all that was wrong. A run that still contradicts itself at its end was misled further, and gets more
/// passes at once, unless the budget is limited.
void RecordEstimation::repeat_from_estimates(StepBudget& budget) {
  const auto& settings = problem_->settings;
  if (settings.passes > 1 || settings.adaptive_noise.any()) return;
  if (estimate_.result.failure || !contradicts_itself(estimate_)) return;
  struct Form {
    int passes;
    bool with_start;
  };
  std::vector<Form> forms{{few_passes, false}, {more_passes, false}};
  if (estimate_.start.moving || states_initial_motion(settings)) forms.push_back({few_passes, true});
  const bool at_first = agrees_at_its_end(estimate_);
  if (!at_first) forms = {{more_passes, false}};
  if (budget.is_limited()) std::erase_if(forms, [](const Form& form) { return form.passes > few_passes; });
  for (const auto& [passes, with_start] : forms) {
    if (!budget.take(passes * steps_of_run(*problem_, record_, estimate_.substeps.substeps)))
      return estimate_.leave_out("further passes from the estimates");
    RecordEstimation again = *this;
    again.pass_again(passes, with_start);
    if (explains_more(again.estimate_, estimate_)) {
      *this = std::move(again);
      return;
    }
    other_steps_ += again.screening_->steps() - screening_->steps();
  }
}

/// Where a record tells an unknown far better than its prior does, what the filter's linearisation about the first
/// guess bends can be large beside its deviation though no innovation shows it: a second pass, from the estimates,
/// tells. It is kept where it moves an estimate, and agrees with the model as well.
void RecordEstimation::confirm_by_second_pass(StepBudget& budget) {
  const auto& settings = problem_->settings;
  if (settings.passes > 1 || settings.adaptive_noise.any() || estimate_.substeps.limited) return;
  if (estimate_.result.failure || contradicts_itself(estimate_) || !is_far_better_known(estimate_)) return;
  if (!budget.take(few_passes * steps_of_run(*problem_, record_, estimate_.substeps.substeps)))
    return estimate_.leave_out("a second pass from the estimates");
  RecordEstimation again = *this;
  again.pass_again(few_passes, false);
  if (!again.estimate_.result.failure && !contradicts_itself(again.estimate_) && moves(estimate_, again.estimate_)) {
    *this = std::move(again);
    return;
  }
  other_steps_ += again.screening_->steps() - screening_->steps();
}

void RecordEstimation::pass_again(int passes, bool with_start) {
  auto repeated = std::make_shared<EstimationProblem>(*problem_);
  repeated->settings.passes = passes;
  problem_ = std::move(repeated);
  screening_->pass_again(passes, with_start);
  evaluate(screening_->run(estimate_.substeps.substeps), estimate_.substeps);
}

void RecordEstimation::settle_substeps(StepBudget& budget) {
  const SubstepChoice& first = estimate_.substeps;
  if (!first.limited || !first.chosen || estimate_.result.failure) return;
  SubstepOptions options = SubstepOptions::of(problem_->settings.step_order);
  options.first = first.substeps;
  auto [choice, run] = kalfem::settle_substeps(
      *problem_, screening_->setup(), screening_->record(), [&](int substeps) { return screening_->run(substeps); },
      estimate_.result, first, budget, options);
  if (choice.stopped) estimate_.leave_out("more substeps");
  if (run)
    evaluate(*std::move(run), std::move(choice));
  else
    estimate_.substeps = std::move(choice);
}

/// The run of the estimate with so many substeps.
FilterRun RecordEstimation::run_with(int substeps) const {
  AugmentedModelSetup setup = screening_->setup();
  setup.starts_at_rest = !estimate_.start.moving;
  setup.options.substeps = substeps;
  return make_filter_run(problem_, setup, screening_->record());
}

bool RecordEstimation::shows_a_change() const {
  const auto hints = change_hints(estimate_.result.unknowns_history, estimate_.settled);
  return !estimate_.result.failure && !hints.empty() && hints.front().statistic > change_beyond_steps;
}

void RecordEstimation::look_for_jump(StepBudget& budget) {
  if (!problem_->settings.diagnose || looked_for_change_) return;
  // Where the step is too coarse, the estimates are those of the step, not of the record, unless they change along it.
  if (estimate_.substeps.limited && !shows_a_change()) return;
  const bool limited = budget.is_limited();
  const int substeps = std::min(limited ? limited_jump_substeps : most_jump_substeps, estimate_.substeps.substeps);
  const std::optional<FilterRun> coarse =
      estimate_.substeps.substeps > substeps ? std::optional(run_with(substeps)) : std::nullopt;
  const FilterRun& run = coarse ? *coarse : *run_;
  looked_for_change_ = true;
  EstimationOptions options = screening_->options();
  options.filter = run.choice.filter;
  options.step_shift = options.keep_gains = false;
  const auto search = find_parameter_jump(*run.choice.augmented_model, run.input, options, estimate_.result,
                                          estimate_.settled, static_cast<double>(record_.samples()) * substeps, budget);
  if (search.stopped) estimate_.leave_out("a change of an unknown within the record");
  if (!search.jump) return;
  estimate_.jump = search.jump;
  add_event_of_change();
}

void RecordEstimation::confirm_information(StepBudget& budget) {
  if (estimate_.result.failure || !problem_->settings.diagnose || contradicts_itself(estimate_)) return;
  auto found = information_at_estimates(problem_, screening_->record(), estimate_, budget);
  if (!found) {
    if (budget.refused()) estimate_.leave_out("whether the filter is too sure of its estimates");
    return;
  }
  if (found->any_too_sure()) estimate_.robust.covariance = found->about_the_estimates();
  for (std::size_t i = 0; i < found->unknowns.size(); ++i)
    if (const double widening = found->widening[static_cast<Index>(i)]; widening > 0.0)
      estimate_.robust_deviation[found->unknowns[i]] =
          widening * estimate_.result.unknowns.deviation.rightCols(1)(found->unknowns[i], 0);
  estimate_.information = std::make_shared<const UnknownInformation>(*std::move(found));
}

void RecordEstimation::add_event_of_change() {
  const auto& unknowns = estimate_.augmented_model->options().unknowns;
  const auto& change = *estimate_.jump;
  estimate_.events.push_back(
      event_of(change, unknowns[static_cast<std::size_t>(change.unknown)], estimate_.measurements));
}

void RecordEstimation::study_process_noise(StepBudget& budget) {
  if (!problem_->settings.diagnose || estimate_.substeps.limited) return;
  // Of a run that contradicts itself the mistake is looked for first.
  const bool contradictory = !innovation_reasons(innovations_of(estimate_)).empty();
  if (budget.is_limited() && contradictory) return estimate_.leave_out("other process noise");
  auto study = kalfem::study_process_noise(problem_, setup_, record_, estimate_, budget);
  if (study.stopped) estimate_.leave_out("other process noise");
  estimate_.process_noise = std::move(study.trials);
}

/// Makes the estimate of a run.
void RecordEstimation::evaluate(FilteredRecord filtered, SubstepChoice substeps) {
  const auto& settings = problem_->settings;
  const auto unknown_inputs = held_by(settings.unknown_inputs, setup_);
  EstimationOptions of_filter = screening_->options();
  of_filter.filter = filtered.run.choice.filter;
  std::optional<SmoothedRecord> smoothed;
  if (settings.smooth && !filtered.result.failure) smoothed = smooth_safely(problem_, *screening_, of_filter, filtered);
  auto events = screening_->events(filtered.result);
  Record measurements = without(filtered.run.input.measured, events);
  RecordEstimate estimate{.filter = filtered.run.choice.filter,
                          .filter_reason = filtered.run.choice.reason,
                          .attempts = std::move(filtered.attempts),
                          .substeps = std::move(substeps),
                          .start = filtered.run.start,
                          .augmented_model = filtered.augmented_model(),
                          .result = std::move(filtered.result),
                          .measurements = std::move(measurements),
                          .outliers = of_filter.outliers.treatment,
                          .held_out = of_filter.held_out,
                          .events = std::move(events)};
  estimate.settled = first_judged(
      estimate.result, first_settled_sample(settings, screening_->setup(), estimate.start, estimate.measurements));
  estimate.inputs = take_inputs(unknown_inputs, estimate.result.monitored);
  if (smoothed) estimate.smoothed_inputs = take_inputs(unknown_inputs, smoothed->monitored);
  estimate.smoothed = std::move(smoothed);
  estimate.consistency =
      summarise_consistency(estimate.result.nis, estimate.result.measured, estimate.result.innovation,
                            estimate.measurements.noise(), estimate.settled);
  set_robust_deviations(estimate);
  if (settings.estimate_initial_state && !estimate.result.failure && !settings.local && unknown_inputs.empty())
    set_open_loop(*problem_, setup_, estimate);
  if (likelihood_) add_uncertainty(*likelihood_, estimate);
  estimate.likelihood = likelihood_;
  estimate.second_thoughts = estimate_.second_thoughts;
  estimate.left_out = std::move(estimate_.left_out);
  estimate.reductions = estimate_.reductions;
  estimate.jump = estimate_.jump;
  estimate.freed = estimate_.freed;
  run_ = std::move(filtered.run);
  estimate_ = std::move(estimate);
  if (estimate_.jump) add_event_of_change();
}

}  // namespace kalfem
