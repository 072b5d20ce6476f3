#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/identification/refined_filter.hpp"
#include "kalfem/pipeline/open_loop.hpp"
#include "kalfem/pipeline/reported_quantities.hpp"
#include "kalfem/pipeline/run_steps.hpp"
#include "kalfem/study/study_elements.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The augmented model's system at the estimated parameters.
LocallyNonlinearSystem estimated_system(const EstimationOutcome& outcome) {
  const auto& options = outcome.augmented_model->options();
  const VectorXd estimates = outcome.result.unknowns.mean.rightCols(1);
  const auto linear = linear_unknowns(options);
  LocallyNonlinearSystem system =
      linear.empty() ? outcome.augmented_model->system() : options.system_at(estimates(linear));
  const auto& unknowns = options.unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const auto& target : unknowns[i].targets)
      system.connectors[static_cast<std::size_t>(target.connector)].parameters[target.parameter] =
          estimates[static_cast<Index>(i)];
  return system;
}

/// Simulates the record from the estimated parameters and initial state, without any correction by measurements. Adds
/// the offsets that the sensors show in addition to the motion.
ConvergedSolution simulate_record_again(const Study& study, const AugmentedModelSetup& setup,
                                        const EstimationOutcome& outcome) {
  const auto& layout = outcome.augmented_model->layout();
  const Index last = outcome.result.state.mean.cols() - 1;
  const VectorXd start = outcome.result.state.mean.col(last).segment(layout.initial_state(), layout.linear);
  const VectorXd states = outcome.result.state.mean.col(last).tail(layout.connector_states);
  const LocallyNonlinearSystem system = estimated_system(outcome);
  ConvergedSolution reference = simulate_open_loop(
      {system, *setup.model, setup.sensors, study.structure->signals},
      {start.head(layout.dofs), start.segment(layout.dofs, layout.dofs), states}, outcome.measurements);
  if (reference.sensors.size() == 0) return reference;
  const auto& unknowns = outcome.augmented_model->options().unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const Index sensor : unknowns[i].sensors)
      reference.sensors.row(sensor).array() += outcome.result.unknowns.mean(static_cast<Index>(i), last);
  return reference;
}

void compare_open_loop(const MatrixXd& simulated, EstimationOutcome& outcome) {
  const Index samples = outcome.measurements.samples();
  const Index tail = std::max<Index>(1, samples / 20);  // where the structure rests at the end
  for (Index j = 0; j < simulated.rows(); ++j) {
    const VectorXd measured = outcome.measurements.values.row(j);
    const auto missing = measured.array().isNaN();
    const VectorXd end = measured.tail(tail), known = end.array().isNaN().select(0.0, end);
    const double rest = known.sum() / std::max(1.0, static_cast<double>((!end.array().isNaN()).count()));
    const VectorXd error = missing.select(0.0, simulated.row(j).transpose() - measured);
    const VectorXd about_rest = missing.select(0.0, measured.array() - rest);
    const double scale = rms(about_rest);
    outcome.open_loop_nrmse.push_back(scale > 0.0 ? rms(error) / scale : std::numeric_limits<double>::infinity());
    outcome.open_loop_rest_error.push_back(simulated.row(j).tail(tail).mean() - rest);
  }
}

/// Compares the record with its simulation. A diverging simulation is a result: the estimates do not describe the
/// structure.
void set_open_loop(const Study& study, const AugmentedModelSetup& setup, EstimationOutcome& outcome) {
  ConvergedSolution reference = simulate_record_again(study, setup, outcome);
  outcome.open_loop_failure = open_loop_failure(reference, outcome.measurements, "the simulation with the estimates");
  if (!outcome.open_loop_failure.empty()) return;
  outcome.open_loop = std::move(reference.simulation);
  outcome.open_loop_sensors = std::move(reference.sensors);
  compare_open_loop(outcome.open_loop_sensors, outcome);
}

/// Standard deviations of the motion change slowly, so a hundred values per second suffice.
int samples_between_deviations(double sample_rate) {
  return std::max(1, static_cast<int>(std::lround(sample_rate / 100.0)));
}

/// What was computed before a failure: the rest would be drawn as nothing and averaged as zero. At least one sample
/// stays, which holds no number where none was computed.
void keep_computed(EstimationOutcome& outcome) {
  auto& result = outcome.result;
  if (!result.failure) return;
  const Index count = std::max<Index>(1, result.failure->computed);
  const auto cut = [&](MatrixXd& series) { series = series.leftCols(std::min(count, series.cols())).eval(); };
  for (auto* series : {&result.state, &result.unknowns, &result.monitored}) {
    cut(series->mean);
    cut(series->deviation);
  }
  for (auto* series : {&result.innovation, &result.innovation_deviation, &outcome.measurements.values}) cut(*series);
  result.nis = result.nis.head(count).eval();
  result.measured = result.measured.head(count).eval();
  if (outcome.measurements.used) outcome.measurements.used = std::min(*outcome.measurements.used, count);
}

/// Samples before the first one of the error and consistency figures. A run that failed while it settled is judged from
/// its start.
Index settled_samples(const EstimationOutcome& outcome, double settle) {
  const Index samples = outcome.measurements.samples();
  const auto settled = static_cast<Index>(std::llround(settle * outcome.measurements.sample_rate));
  if (outcome.result.failure && settled >= samples) return 0;
  return std::min(settled, samples - 1);
}

/// Deviations that hold where innovations are correlated, from the course of the unknowns.
void set_robust_deviations(EstimationOutcome& outcome) {
  const auto& history = outcome.result.unknowns_history;
  const auto& unknowns = outcome.augmented_model->options().unknowns;
  outcome.robust_deviation.setConstant(static_cast<Index>(unknowns.size()), std::numeric_limits<double>::quiet_NaN());
  if (outcome.result.failure || history.empty()) return;
  outcome.robust = robust_covariance(history);
  for (std::size_t i = 0; i < history.unknowns.size(); ++i) {
    const Index unknown = history.unknowns[i], place = static_cast<Index>(i);
    const auto& transform = unknowns[static_cast<std::size_t>(unknown)].transform;
    outcome.robust_deviation[unknown] =
        transform.slope(history.mean.back()[place]) * std::sqrt(outcome.robust.covariance(place, place));
  }
}

}  // namespace

// Runs the filter over the record, then evaluates its result: consistency of the innovations after settling, and each
// monitored quantity against the reference if the record was simulated. If the initial state was estimated too, a
// simulation from the estimates alone (open loop) shows whether they describe the structure.
EstimationOutcome run_estimation(const Study& study, const AugmentedModelSetup& setup, const StudyResults& results,
                                 const Progress& progress, std::string& failure) {
  const Stopwatch watch;
  const auto& given = study.problem->settings;
  const Record& record = record_of(study, results);
  EstimationOutcome outcome;
  const auto monitored = reported_quantities(*setup.model);
  const EstimationOptions options{.unscented = given.unscented,
                                  .threads = filter_threads(study.problem->settings),
                                  .passes = given.passes,
                                  .state_deviations = false,
                                  .deviation_stride = samples_between_deviations(study.sample_rate()),
                                  .keep_unknowns = true,
                                  .monitored = make_outputs(*setup.model, monitored),
                                  .progress = progress};
  auto [filtered, substeps] = run_refined_filter(study.problem, setup, record, options);
  outcome.augmented_model = filtered.augmented_model();
  outcome.result = std::move(filtered.result);
  outcome.measurements = std::move(filtered.run.input.measured);
  outcome.filter = filtered.run.choice.filter;
  outcome.filter_reason = filtered.run.choice.reason;
  outcome.substeps = std::move(substeps);
  outcome.start = filtered.run.start;
  outcome.attempts = std::move(filtered.attempts);
  if (outcome.result.failure)
    failure = "the filter stopped at " + shortest(outcome.measurements.start + outcome.result.failure->time) +
              " s: " + outcome.result.failure->reason;
  keep_computed(outcome);
  outcome.settled = settled_samples(outcome, given.settle);
  outcome.band = study.excitation_band;
  outcome.consistency = summarise_consistency(outcome.result.nis, outcome.result.measured, outcome.result.innovation,
                                              outcome.measurements.noise(), outcome.settled);
  set_robust_deviations(outcome);
  for (std::size_t i = 0; i < monitored.size(); ++i) {
    const auto row = static_cast<Index>(i);
    PointQuantity quantity{monitored[i].name,
                           monitored[i].quantity,
                           outcome.result.monitored.mean.row(row).transpose(),
                           outcome.result.monitored.deviation.row(row).transpose(),
                           {},
                           {},
                           {}};
    if (results.simulation)
      if (const auto* truth = find_quantity(results.simulation->points, quantity.point, quantity.quantity))
        compare(quantity, truth->mean.head(outcome.measurements.samples()),
                {outcome.settled, study.sample_rate(), outcome.band});
    outcome.points.push_back(std::move(quantity));
  }
  if (given.estimate_initial_state && !outcome.result.failure && !given.local) set_open_loop(study, setup, outcome);
  outcome.seconds = watch.seconds();
  return outcome;
}

}  // namespace kalfem
