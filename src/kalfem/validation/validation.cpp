// SPDX-License-Identifier: Apache-2.0
#include "kalfem/validation/validation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/open_loop.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A filter's problem on the lead-in: the parameters are known, the initial state is not.
EstimationProblemPtr lead_in_problem(const EstimatedStructure& structure, const ValidationPart& part) {
  const auto& [record, preparation, free_response, began] = part.record;
  auto excited = std::make_shared<StructureModel>(*structure.structure);
  excited->signals = part.signals;
  EstimationProblem problem{excited, structure.sensors, structure.offsets, record.sample_rate, structure.settings};
  problem.settings.initial_state.clear();
  problem.settings.initial_connector_states.clear();
  problem.settings.initial_state_from_record = false;
  problem.settings.estimate_initial_state = true;
  problem.settings.passes = 1;
  if (free_response && free_response->rest_is_unknown())
    for (const auto& sensor : structure.sensors)
      problem.offsets.push_back(rest_position(sensor.name, free_response->deviation[record.find(sensor.name)]));
  return std::make_shared<const EstimationProblem>(std::move(problem));
}

void set_prior(const MotionRange& range, StatePrior& prior) {
  const Index states = range.mean.size() - 2 * range.dofs;
  prior.mean = {range.mean.head(range.dofs), range.mean.segment(range.dofs, range.dofs), range.mean.tail(states)};
  prior.displacement_deviation = range.reach.head(range.dofs);
  prior.velocity_deviation = range.reach.segment(range.dofs, range.dofs);
  prior.connector_state_deviation = range.reach.tail(states);
}

struct Start {
  InitialState state;
  VectorXd rest;  ///< offset of each sensor
  std::string failure;
};

FilteredRecord filtered_by(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup,
                           const Record& record) {
  return run_filter(problem, setup, record,
                    {.unscented = problem->settings.unscented,
                     .threads = filter_threads(problem->settings),
                     .state_deviations = false,
                     .adaptive_noise = problem->settings.adaptive_noise});
}

/// The initial state that the filter finds from the first samples of the record: a fixed-point smoother over them.
Start estimated_start(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, Record record,
                      Index samples) {
  record.values.conservativeResize(Eigen::NoChange, samples);
  record.used.reset();
  const auto filtered = filtered_by(problem, setup, record);
  Start start{.rest = VectorXd::Zero(static_cast<Index>(setup.sensors.size()))};
  if (filtered.result.failure) start.failure = filtered.result.failure->reason;
  const auto& layout = filtered.augmented_model()->layout();
  const VectorXd last = filtered.result.state.mean.col(samples - 1);
  start.state = {last.segment(layout.initial_state(), layout.dofs),
                 last.segment(layout.initial_state() + layout.dofs, layout.dofs), last.tail(layout.connector_states)};
  const auto& unknowns = filtered.augmented_model()->options().unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const Index sensor : unknowns[i].sensors)
      start.rest[sensor] += filtered.result.unknowns.mean(static_cast<Index>(i), samples - 1);
  return start;
}

/// rms of the samples that are there.
double rms_of_known(const VectorXd& values) {
  const auto known = values.array().isFinite();
  const double samples = std::max<double>(1.0, static_cast<double>(known.count()));
  return std::sqrt(known.select(values.array().square(), 0.0).sum() / samples);
}

double mean_of_known(const VectorXd& values) {
  const auto known = values.array().isFinite();
  return known.select(values.array(), 0.0).sum() / std::max<double>(1.0, static_cast<double>(known.count()));
}

/// What the filter predicts one sample ahead with the parameters held, less what was measured; empty where it stops,
/// and where the budget does not allow that.
MatrixXd one_step_errors(const EstimationProblemPtr& problem, AugmentedModelSetup setup, const Record& record,
                         StepBudget& budget) {
  if (!budget.take(steps_of_run(*problem, record, setup.options.substeps))) return {};
  setup.options.keep_initial_state = false;
  const auto filtered = filtered_by(problem, setup, record);
  return filtered.result.failure ? MatrixXd() : filtered.result.innovation;
}

/// Errors and noise of each sensor over the samples that count, relative to its motion about its mean.
void set_errors(const MatrixXd& one_step, OpenLoopComparison& comparison) {
  const Index count = std::max<Index>(0, comparison.measured.samples_used() - comparison.first);
  for (Index j = 0; j < comparison.simulated.rows(); ++j) {
    const VectorXd measured = comparison.measured.values.row(j).segment(comparison.first, count);
    const VectorXd simulated = comparison.simulated.row(j).segment(comparison.first, count);
    const double size = rms_of_known(measured.array() - mean_of_known(measured));
    const auto relative = [&](double part) {
      return size > 0.0 ? part / size : std::numeric_limits<double>::infinity();
    };
    comparison.nrmse.push_back(relative(rms_of_known(simulated - measured)));
    comparison.noise.push_back(relative(comparison.measured.channels[static_cast<std::size_t>(j)].noise));
    if (one_step.rows() > 0)
      comparison.one_step.push_back(
          relative(rms_of_known(one_step.row(j).segment(comparison.first, count).transpose())));
  }
}

/// Samples of a lead-in [s]; two at least, as of every record.
Index lead_in_samples(double lead_in, const Record& record) {
  return std::clamp<Index>(std::llround(lead_in * record.sample_rate), 2, record.samples() - 1);
}

/// `range`: of the usual motion, for parts that do not start at rest.
OpenLoopComparison compare_open_loop(const EstimatedStructure& structure, const ValidationPart& part,
                                     const MotionRange& range, StepBudget& budget) try {
  const auto& record = part.record.record;
  const auto problem = lead_in_problem(structure, part);
  IssueList issues;
  AugmentedModelSetup setup = make_augmented_model_setup(*problem, structure.parts, {}, issues);
  issues.raise();
  std::vector<std::string> names;
  for (const auto& sensor : setup.sensors) names.push_back(sensor.name);
  OpenLoopComparison comparison{.measured = select_channels(record, names)};
  const auto& system = setup.model->system();
  Start start{at_rest(system.size(), system.connector_states()), VectorXd::Zero(std::ssize(names)), ""};
  const bool has_state = system.size() + system.connector_states() > 0;  // a component's law may have none
  if (!part.from_rest) {
    set_prior(range, setup.options.prior);
    comparison.first = lead_in_samples(part.lead_in, comparison.measured);
    if (has_state) start = estimated_start(problem, setup, record, comparison.first);
  }
  if (!start.failure.empty()) {
    comparison.failure = "the initial state was not found in the lead-in: " + start.failure;
    return comparison;
  }
  ConvergedSolution simulated =
      simulate_open_loop({system, *setup.model, setup.sensors, part.signals}, start.state, comparison.measured);
  comparison.failure = open_loop_failure(simulated, comparison.measured, "the simulation with the estimates");
  if (!comparison.failure.empty()) return comparison;
  comparison.simulated = simulated.sensors.colwise() + start.rest;
  set_errors(has_state ? one_step_errors(problem, setup, record, budget) : MatrixXd(), comparison);
  return comparison;
} catch (const InvalidInput& error) {
  return {.failure = "the estimates make no structure: " + error.issues().front().what};
}

/// The motion of the structure from rest under the excitation of a part.
MotionRange simulated_motion(const EstimatedStructure& structure, const ValidationPart& part) {
  const CoupledModel model = couple(structure.parts);
  const Index dofs = model.system().size();
  const auto simulated = simulate_open_loop({model.system(), model, structure.sensors, part.signals},
                                            at_rest(dofs, model.system().connector_states()), part.record.record);
  const auto& motion = simulated.simulation.trajectory;
  MatrixXd all(2 * dofs + motion.connector_states.rows(), motion.displacement.cols());
  all << motion.displacement, motion.velocity, motion.connector_states;
  return range_of(all, dofs);
}

}  // namespace

Validation validate(const ValidationProblem& problem) {
  const auto& [structure, held_back, own, motion, steps] = problem;
  MotionRange range;
  try {
    if (!held_back.from_rest) range = motion ? *motion : simulated_motion(structure, held_back);
  } catch (const InvalidInput& error) {
    return {.held_back = {.failure = "the estimates make no structure: " + error.issues().front().what}};
  }
  StepBudget budget(steps);
  Validation validation{.held_back = compare_open_loop(structure, held_back, range, budget)};
  if (own) validation.own = compare_open_loop(structure, *own, range, budget);
  validation.one_step_left_out = budget.refused();
  return validation;
}

}  // namespace kalfem
