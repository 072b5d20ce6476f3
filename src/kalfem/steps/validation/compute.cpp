// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/validation/compute.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/open_loop.hpp"
#include "kalfem/identification/released_elements.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/steps/validation/outcome.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// How a motion lies about its mean: [z; z'; internal states], each row over the samples of a record.
struct MotionRange {
  VectorXd mean, reach;  ///< reach: the largest distance from the mean
  Index dofs = 0;
};

MotionRange range_of(const MatrixXd& motion, Index dofs) {
  const VectorXd mean = motion.rowwise().mean();
  return {mean, (motion.colwise() - mean).cwiseAbs().rowwise().maxCoeff(), dofs};
}

/// The structure at the estimates, as library objects.
struct EstimatedStructure {
  StructureParts parts;
  std::vector<Sensor> sensors;
  EstimationSettings settings;        ///< of the filter, without unknowns
  std::vector<SensorOffset> offsets;  ///< about the values that were found
};

/// The sensors' offsets of a problem, each about its estimate. Rest positions belong to a record.
std::vector<SensorOffset> found_offsets(const EstimationProblem& problem, const RecordEstimate& estimate) {
  std::vector<SensorOffset> offsets;
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  const Index last = estimate.result.unknowns.mean.cols() - 1;
  for (SensorOffset offset : problem.offsets) {
    const auto found = std::ranges::find(unknowns, offset.name, &UnknownParameter::name);
    if (found == unknowns.end() || is_rest_position(offset)) continue;
    offset.initial = estimate.result.unknowns.mean(found - unknowns.begin(), last);
    offset.deviation = estimate.result.unknowns.deviation(found - unknowns.begin(), last);
    offsets.push_back(std::move(offset));
  }
  return offsets;
}

EstimatedStructure structure_at_estimates(const Study& study, StructureParts parts, const StudyResults& results) {
  EstimatedStructure structure{std::move(parts), study.sensors, {}, {}};
  const auto* estimation = results.find<EstimationOutcome>();
  if (!study.problem || !estimation) return structure;
  structure.offsets = found_offsets(*study.problem, *estimation);
  structure.settings = study.problem->settings;
  structure.settings.substeps = estimation->substeps.substeps;
  const auto unknowns = std::exchange(structure.settings.unknowns, {});
  const VectorXd estimates = estimation->result.unknowns.mean.rightCols(1);
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const auto& target : unknowns[i].targets)
      if (can_be_released(study.structure->parts, target))  // others are in the parts already
        set_parameter(structure.parts, target, estimates[static_cast<Index>(i)]);
  return structure;
}

/// A filter's problem on the lead-in: the parameters are known, the initial state is not.
EstimationProblemPtr lead_in_problem(const Study& study, const EstimatedStructure& structure,
                                     const PreparedRecord& record, const std::vector<SignalPtr>& signals) {
  auto excited = std::make_shared<StructureModel>(*study.structure);
  excited->signals = signals;
  EstimationProblem problem{excited, structure.sensors, {}, record.record.sample_rate, structure.settings};
  problem.settings.initial_state.clear();
  problem.settings.initial_connector_states.clear();
  problem.settings.initial_state_from_record = false;
  problem.settings.estimate_initial_state = true;
  problem.settings.passes = 1;
  problem.offsets = structure.offsets;
  if (record.free_response && record.free_response->rest_is_unknown())
    for (const auto& sensor : structure.sensors)
      problem.offsets.push_back(
          rest_position(sensor.name, record.free_response->deviation[record.record.find(sensor.name)]));
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

/// The initial state that the filter finds from the first samples of the record: a fixed-point smoother over them.
Start estimated_start(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, Record record,
                      Index samples) {
  record.values.conservativeResize(Eigen::NoChange, samples);
  record.used.reset();
  const auto filtered = run_filter(problem, setup, record,
                                   {.unscented = problem->settings.unscented,
                                    .threads = filter_threads(problem->settings),
                                    .state_deviations = false,
                                    .adaptive_noise = problem->settings.adaptive_noise});
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
  const auto filtered = run_filter(problem, setup, record,
                                   {.unscented = problem->settings.unscented,
                                    .threads = filter_threads(problem->settings),
                                    .state_deviations = false,
                                    .adaptive_noise = problem->settings.adaptive_noise});
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

/// Simulates the record from the state that its first samples show. `lead_in` [s]; nothing: from rest.
OpenLoopComparison compare_open_loop(const Study& study, const EstimatedStructure& structure,
                                     const PreparedRecord& record, const std::vector<SignalPtr>& signals,
                                     std::optional<double> lead_in, const MotionRange& range, StepBudget& budget) try {
  const auto problem = lead_in_problem(study, structure, record, signals);
  IssueList issues;
  AugmentedModelSetup setup = make_augmented_model_setup(*problem, structure.parts, {}, issues);
  issues.raise();
  std::vector<std::string> names;
  for (const auto& sensor : setup.sensors) names.push_back(sensor.name);
  OpenLoopComparison comparison{.measured = select_channels(record.record, names)};
  const auto& system = setup.model->system();
  Start start{at_rest(system.size(), system.connector_states()), VectorXd::Zero(std::ssize(names)), ""};
  const bool has_state = system.size() + system.connector_states() > 0;  // a component's law may have none
  if (lead_in) {
    set_prior(range, setup.options.prior);
    comparison.first = lead_in_samples(*lead_in, comparison.measured);
    if (has_state) start = estimated_start(problem, setup, record.record, comparison.first);
  }
  if (!start.failure.empty()) {
    comparison.failure = "the initial state was not found in the lead-in: " + start.failure;
    return comparison;
  }
  ConvergedSolution simulated =
      simulate_open_loop({system, *setup.model, setup.sensors, signals}, start.state, comparison.measured);
  comparison.failure = open_loop_failure(simulated, comparison.measured, "the simulation with the estimates");
  if (!comparison.failure.empty()) return comparison;
  comparison.simulated = simulated.sensors.colwise() + start.rest;
  set_errors(has_state ? one_step_errors(problem, setup, record.record, budget) : MatrixXd(), comparison);
  return comparison;
} catch (const InvalidInput& error) {
  return {.failure = "the estimates make no structure: " + error.issues().front().what};
}

/// The record without the gains and delays that were found.
PreparedRecord corrected(PreparedRecord prepared, const StudyResults& results) {
  const auto* estimation = results.find<EstimationOutcome>();
  if (!estimation || !estimation->likelihood) return prepared;
  const auto& found = *estimation->likelihood;
  prepared.record = corrected_record(found.unknowns, found.values, std::move(prepared.record));
  return prepared;
}

/// The motion that the filter estimated; without a filter, that of the structure from rest under its excitation.
MotionRange usual_motion(const Study& study, const EstimatedStructure& structure, const StudyResults& results) {
  if (const auto* estimation = results.find<EstimationOutcome>()) {
    const auto& layout = estimation->augmented_model->layout();
    const auto& mean = estimation->result.state.mean;
    MatrixXd motion(2 * layout.dofs + layout.connector_states, mean.cols());
    motion << mean.topRows(2 * layout.dofs), mean.middleRows(layout.connector_state(), layout.connector_states);
    return range_of(motion, layout.dofs);
  }
  const CoupledModel model = couple(structure.parts);
  const Index dofs = model.system().size();
  const auto& plan = *study.validation;
  const auto simulated = simulate_open_loop({model.system(), model, structure.sensors, plan.signals},
                                            at_rest(dofs, model.system().connector_states()), plan.record.record);
  const auto& motion = simulated.simulation.trajectory;
  MatrixXd all(2 * dofs + motion.connector_states.rows(), motion.displacement.cols());
  all << motion.displacement, motion.velocity, motion.connector_states;
  return range_of(all, dofs);
}

}  // namespace

// The same for both parts: the state at the first sample is estimated from a short lead-in with the parameters held,
// then the whole part is simulated, and what lies behind the lead-in counts.
ValidationOutcome run_validation(const Study& study, const StructureParts& base, const StudyResults& results) {
  const auto& plan = *study.validation;
  const EstimatedStructure structure = structure_at_estimates(study, base, results);
  const std::optional<double> lead_in = plan.from_rest ? std::nullopt : std::optional(plan.lead_in);
  MotionRange range;
  try {
    if (lead_in) range = usual_motion(study, structure, results);
  } catch (const InvalidInput& error) {
    ValidationOutcome outcome;
    outcome.held_back.failure = "the estimates make no structure: " + error.issues().front().what;
    return outcome;
  }
  const auto* estimation = results.find<EstimationOutcome>();
  StepBudget budget(estimation ? estimation->steps_left : StepBudget::unlimited);
  ValidationOutcome outcome{.held_back = compare_open_loop(study, structure, corrected(plan.record, results),
                                                           plan.signals, lead_in, range, budget)};
  outcome.one_step_left_out = budget.refused();
  if (!study.record) return outcome;
  const Record& own = study.record->record;
  const auto own_lead_in = lead_in ? std::optional(std::min(*lead_in, 0.5 * (own.end() - own.start))) : std::nullopt;
  outcome.own = compare_open_loop(study, structure, corrected(*study.record, results), study.structure->signals,
                                  own_lead_in, range, budget);
  outcome.one_step_left_out = budget.refused();
  return outcome;
}

}  // namespace kalfem
