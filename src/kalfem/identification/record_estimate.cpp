#include "kalfem/identification/record_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kalfem/base/units.hpp"
#include "kalfem/identification/open_loop.hpp"
#include "kalfem/identification/robust_deviations.hpp"
#include "kalfem/identification/screened_filter.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The augmented model's system at the estimated parameters.
LocallyNonlinearSystem estimated_system(const RecordEstimate& estimate) {
  const auto& options = estimate.augmented_model->options();
  const VectorXd estimates = estimate.result.unknowns.mean.rightCols(1);
  const auto linear = linear_unknowns(options);
  LocallyNonlinearSystem system =
      linear.empty() ? estimate.augmented_model->system() : options.system_at(estimates(linear));
  const auto& unknowns = options.unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const auto& target : unknowns[i].targets)
      system.connectors[static_cast<std::size_t>(target.connector)].parameters[target.parameter] =
          estimates[static_cast<Index>(i)];
  return system;
}

/// Simulates the record from the estimated parameters and initial state, without any correction by measurements. Adds
/// the offsets that the sensors show in addition to the motion.
ConvergedSolution simulate_record_again(const EstimationProblem& problem, const AugmentedModelSetup& setup,
                                        const RecordEstimate& estimate) {
  const auto& layout = estimate.augmented_model->layout();
  const Index last = estimate.result.state.mean.cols() - 1;
  const VectorXd start = estimate.result.state.mean.col(last).segment(layout.initial_state(), layout.linear);
  const VectorXd states = estimate.result.state.mean.col(last).tail(layout.connector_states);
  const LocallyNonlinearSystem system = estimated_system(estimate);
  ConvergedSolution reference = simulate_open_loop(
      {system, *setup.model, setup.sensors, problem.structure->signals},
      {start.head(layout.dofs), start.segment(layout.dofs, layout.dofs), states}, estimate.measurements);
  if (reference.sensors.size() == 0) return reference;
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const Index sensor : unknowns[i].sensors)
      reference.sensors.row(sensor).array() += estimate.result.unknowns.mean(static_cast<Index>(i), last);
  return reference;
}

void compare_open_loop(const MatrixXd& simulated, RecordEstimate& estimate) {
  const Index samples = estimate.measurements.samples();
  const Index tail = std::max<Index>(1, samples / 20);  // where the structure rests at the end
  for (Index j = 0; j < simulated.rows(); ++j) {
    const VectorXd measured = estimate.measurements.values.row(j);
    const auto missing = measured.array().isNaN();
    const VectorXd end = measured.tail(tail), known = end.array().isNaN().select(0.0, end);
    const double rest = known.sum() / std::max(1.0, static_cast<double>((!end.array().isNaN()).count()));
    const VectorXd error = missing.select(0.0, simulated.row(j).transpose() - measured);
    const VectorXd about_rest = missing.select(0.0, measured.array() - rest);
    const double scale = rms(about_rest);
    estimate.open_loop_nrmse.push_back(scale > 0.0 ? rms(error) / scale : std::numeric_limits<double>::infinity());
    estimate.open_loop_rest_error.push_back(simulated.row(j).tail(tail).mean() - rest);
  }
}

/// Compares the record with its simulation. A diverging simulation is a result: the estimates do not describe the
/// structure.
void set_open_loop(const EstimationProblem& problem, const AugmentedModelSetup& setup, RecordEstimate& estimate) {
  ConvergedSolution reference = simulate_record_again(problem, setup, estimate);
  estimate.open_loop_failure = open_loop_failure(reference, estimate.measurements, "the simulation with the estimates");
  if (!estimate.open_loop_failure.empty()) return;
  estimate.open_loop = std::move(reference.simulation);
  estimate.open_loop_sensors = std::move(reference.sensors);
  compare_open_loop(estimate.open_loop_sensors, estimate);
}

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

/// Samples before the first one of the error and consistency figures. A run that failed while it settled is judged from
/// its start.
Index settled_samples(const EstimationResult& result, const Record& measured, double settle) {
  const auto& failure = result.failure;
  const Index samples = failure ? std::max<Index>(1, failure->computed) : measured.samples();
  const auto settled = static_cast<Index>(std::llround(settle * measured.sample_rate));
  return failure && settled >= samples ? 0 : std::min(settled, samples - 1);
}

/// The finite elements are reduced again if the linear unknowns moved further than this, relative: the error of a fixed
/// basis is about its square. The second constant limits the repetitions.
constexpr double reduction_reach = 0.02;
constexpr int most_reductions = 3;

/// Largest relative distance of the linear unknowns from the values at which the finite elements were reduced. Only
/// unknowns on which the bases depend count.
double distance(const LinearUnknowns& unknowns, const VectorXd& values) {
  double largest = 0.0;
  for (const auto& [index, parameter] : unknowns.bindings) {
    const auto* target = std::get_if<FiniteElementParameter>(&parameter.where);
    if (!target || target->kind != FiniteElementParameter::Kind::matrix) continue;
    const double before = unknowns.reduced_at[index];
    if (before != 0.0) largest = std::max(largest, std::abs(values[index] / before - 1.0));
  }
  return largest;
}

}  // namespace

std::string RecordEstimate::failure() const {
  if (!result.failure) return "";
  return "the filter stopped at " + shortest(measurements.start + result.failure->time) +
         " s: " + result.failure->reason;
}

VectorXd linear_estimates(const RecordEstimate& estimate) {
  return estimate.result.unknowns.mean.rightCols(1)(linear_unknowns(estimate.augmented_model->options()), 0);
}

namespace {

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

/// A change of an unknown as an event of the record.
SensorEvent event_of(const RecordEstimate& estimate, const ParameterJump& jump) {
  const auto& unknown = estimate.augmented_model->options().unknowns[static_cast<std::size_t>(jump.unknown)];
  const double time = estimate.measurements.time(jump.sample);
  return {.kind = EventKind::jump,
          .channel = unknown.name,
          .from = time,
          .to = time,
          .count = estimate.measurements.samples() - jump.sample,
          .text = fmt::format(
              "'{}' changes at {:.6g} s from {:.6g} to {:.6g} {} (by {:.3g}, standard deviation {:.2g})", unknown.name,
              time, jump.before, jump.after, unknown.unit, jump.after - jump.before, jump.deviation)};
}

EstimationOptions filter_options(const EstimationProblem& problem, const AugmentedModelSetup& setup,
                                 const RecordEstimateOptions& options) {
  const auto& settings = problem.settings;
  return {.unscented = settings.unscented,
          .threads = filter_threads(settings),
          .passes = settings.passes,
          .state_deviations = false,
          .deviation_stride = options.deviation_stride,
          .keep_unknowns = true,
          .adaptive_noise = settings.adaptive_noise,
          .monitored = with_inputs(make_outputs(*setup.model, options.monitored),
                                   held_by(settings.unknown_inputs, setup), *setup.model),
          .progress = options.progress};
}

/// The estimation of a problem without likelihood unknowns.
RecordEstimate estimate_by_filter(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                                  const Record& record, const RecordEstimateOptions& options) {
  const auto& settings = problem->settings;
  const auto unknown_inputs = held_by(settings.unknown_inputs, setup);
  EstimationOptions of_filter = filter_options(*problem, setup, options);
  auto screened = run_screened_filter(problem, setup, record, of_filter);
  auto& [filtered, substeps] = screened.refined;
  of_filter.filter = filtered.run.choice.filter;
  of_filter.held_out = screened.held_out;
  of_filter.outliers.treatment = screened.outliers;
  std::optional<SmoothedRecord> smoothed;
  if (settings.smooth && !filtered.result.failure) {
    smoothed = smooth(*filtered.run.choice.augmented_model, filtered.run.input, of_filter, filtered.result);
  }
  std::optional<ParameterJump> jump;
  if (settings.diagnose && !substeps.limited)  // otherwise the estimates are those of the step, not of the record
    jump = find_parameter_jump(*filtered.run.choice.augmented_model, filtered.run.input, of_filter, filtered.result,
                               settled_samples(filtered.result, filtered.run.input.measured, settings.settle));
  RecordEstimate estimate{.filter = filtered.run.choice.filter,
                          .filter_reason = filtered.run.choice.reason,
                          .attempts = std::move(filtered.attempts),
                          .substeps = std::move(substeps),
                          .start = filtered.run.start,
                          .augmented_model = filtered.augmented_model(),
                          .result = std::move(filtered.result),
                          .measurements = without(std::move(filtered.run.input.measured), screened.events),
                          .outliers = screened.outliers,
                          .held_out = screened.held_out,
                          .events = std::move(screened.events)};
  estimate.settled = settled_samples(estimate.result, estimate.measurements, settings.settle);
  estimate.inputs = take_inputs(unknown_inputs, estimate.result.monitored);
  if (smoothed) estimate.smoothed_inputs = take_inputs(unknown_inputs, smoothed->monitored);
  estimate.smoothed = std::move(smoothed);
  estimate.consistency =
      summarise_consistency(estimate.result.nis, estimate.result.measured, estimate.result.innovation,
                            estimate.measurements.noise(), estimate.settled);
  set_robust_deviations(estimate);
  if (jump) {
    estimate.jump = jump;
    estimate.events.push_back(event_of(estimate, *jump));
  }
  if (settings.estimate_initial_state && !estimate.result.failure && !settings.local && unknown_inputs.empty())
    set_open_loop(*problem, setup, estimate);
  return estimate;
}

/// Where the filter fails with the likelihood unknowns at their first guesses: its failure.
RecordEstimate estimate_at_first_guesses(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                                         const Record& record, const RecordEstimateOptions& options) {
  const auto& unknowns = problem->settings.likelihood_unknowns;
  VectorXd values(static_cast<Index>(unknowns.size()));
  for (Index i = 0; i < values.size(); ++i) values[i] = unknowns[static_cast<std::size_t>(i)].initial;
  const auto at = corrected(problem, setup, record, values);
  return estimate_by_filter(at.problem, at.setup, at.record, options);
}

}  // namespace

RecordEstimate estimate_record(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                               const Record& record, const RecordEstimateOptions& given) {
  RecordEstimateOptions options = given;
  options.progress = passes_of(given.progress, "filter pass");
  if (problem->settings.likelihood_unknowns.empty()) return estimate_by_filter(problem, setup, record, options);
  auto likelihood = estimate_likelihood_unknowns(
      problem, setup, record,
      {.unscented = problem->settings.unscented, .adaptive_noise = problem->settings.adaptive_noise});
  if (!likelihood) return estimate_at_first_guesses(problem, setup, record, options);
  const auto& [corrected_problem, corrected_setup, corrected_record, log_jacobian] = likelihood->corrected;
  RecordEstimate estimate = estimate_by_filter(corrected_problem, corrected_setup, corrected_record, options);
  add_uncertainty(*likelihood, estimate);
  estimate.likelihood = std::move(likelihood);
  return estimate;
}

namespace {

/// estimate_record(), repeated with finite elements that are reduced at the estimates.
RecordEstimate estimate_in_bases_of_estimates(const EstimationProblemPtr& problem, AugmentedModelSetup& setup,
                                              const Record& record, const RecordEstimateOptions& options) {
  auto estimate = estimate_record(problem, setup, record, options);
  if (setup.linear_unknowns.bindings.empty()) return estimate;
  for (estimate.reductions = 1; estimate.reductions < most_reductions && !estimate.result.failure;) {
    const VectorXd values = linear_estimates(estimate);
    if (distance(setup.linear_unknowns, values) < reduction_reach) break;
    IssueList issues;
    setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues, values);
    issues.raise();
    setup.substeps = estimate.substeps;
    const int reductions = estimate.reductions + 1;
    estimate = estimate_record(problem, setup, record, options);
    estimate.reductions = reductions;
  }
  return estimate;
}

}  // namespace

RecordEstimate estimate_record_thoroughly(const EstimationProblemPtr& problem, AugmentedModelSetup& setup,
                                          const Record& record, const RecordEstimateOptions& options) {
  auto estimate = estimate_in_bases_of_estimates(problem, setup, record, options);
  if (!problem->settings.diagnose || estimate.substeps.limited) return estimate;
  if (const auto& likelihood = estimate.likelihood) {
    const CorrectedProblem& at = likelihood->corrected;
    estimate.process_noise = study_process_noise(at.problem, at.setup, at.record, estimate);
  } else {
    estimate.process_noise = study_process_noise(problem, setup, record, estimate);
  }
  return estimate;
}

}  // namespace kalfem
