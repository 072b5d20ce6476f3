#include "kalfem/dynamics/simulate.hpp"

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/dynamics/damped_mode_split.hpp"
#include "kalfem/dynamics/period_correction.hpp"
#include "kalfem/dynamics/stepper.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index input_block = 4096;    ///< steps whose inputs are sampled together
constexpr Index progress_block = 256;  ///< steps between two words of progress
constexpr double most_steps = 1e10;
constexpr double most_values = 2e9;  ///< stored, 16 GB

/// Numbers that a simulation would store.
double stored_values(const LocallyNonlinearSystem& system, const SimulationOptions& options) {
  const double steps = options.duration / options.step;
  const auto a_sample =
      static_cast<double>((options.keep_motion ? 3 * system.size() : 0) + system.connector_count() +
                          3 * system.input_count() + system.connector_states() + options.every_sample.size());
  return steps * (a_sample / static_cast<double>(options.keep_every) + static_cast<double>(options.every_step.size()));
}

void check(const LocallyNonlinearSystem& system, const std::vector<SignalPtr>& signals, const InitialState& initial,
           const SimulationOptions& options) {
  IssueList issues;
  if (!(options.step > 0.0) || !std::isfinite(options.step))
    issues.add({}, "the time step is " + std::to_string(options.step) + " s", "it must be positive");
  if (!(options.duration >= options.step) || !std::isfinite(options.duration))
    issues.add({}, "the duration is " + std::to_string(options.duration) + " s", "it must be at least one time step");
  if (options.keep_every < 1) issues.add({}, "keep_every is below 1", "every so many steps one is kept");
  if (options.integrator == Integrator::hht_alpha && !(options.hht_alpha >= -1.0 / 3.0 && options.hht_alpha <= 0.0))
    issues.add({}, "alpha of HHT is " + std::to_string(options.hht_alpha), "it lies in [-1/3, 0]");
  if (options.integrator == Integrator::generalized_alpha &&
      !(options.spectral_radius >= 0.0 && options.spectral_radius <= 1.0))
    issues.add({}, "the spectral radius is " + std::to_string(options.spectral_radius), "it lies in [0, 1]");
  if (static_cast<Index>(signals.size()) != system.input_count())
    issues.add({}, std::to_string(signals.size()) + " signals for " + std::to_string(system.input_count()) + " inputs",
               "each input needs one signal");
  if (initial.displacement.size() != system.size() || initial.velocity.size() != system.size() ||
      initial.connector_states.size() != system.connector_states())
    issues.add({}, "the initial state does not fit the system's size",
               "one value a degree of freedom and internal state");
  issues.raise();
  if (options.duration / options.step > most_steps || stored_values(system, options) > most_values)
    throw InvalidInput(std::to_string(options.duration) + " s in steps of " + std::to_string(options.step) +
                           " s are more samples than fit in memory",
                       "at most 10^10 steps and 2 10^9 stored values", "shorten the duration or keep fewer samples");
}

/// Of the schemes of the generalised-alpha family; nothing for exact stepping.
std::optional<AlphaParameters> alpha_parameters(const SimulationOptions& options) {
  switch (options.integrator) {
    case Integrator::newmark:
      return newmark_parameters();
    case Integrator::hht_alpha:
      return hht_parameters(options.hht_alpha);
    case Integrator::generalized_alpha:
      return generalized_alpha_parameters(options.spectral_radius);
    case Integrator::exact:
      break;
  }
  return std::nullopt;
}

/// [r; r'; r''] of all inputs at `count` steps from `first` on, 3 n_u x count.
MatrixXd sample_inputs(const std::vector<SignalPtr>& signals, double step, Index first, Index count) {
  const auto n_u = static_cast<Index>(signals.size());
  MatrixXd inputs(3 * n_u, count);
  for (Index i = 0; i < n_u; ++i) {
    const auto sampled = signals[static_cast<std::size_t>(i)]->sample(static_cast<double>(first) * step, step, count);
    for (Index derivative = 0; derivative < 3; ++derivative)
      inputs.row(derivative * n_u + i) = sampled.col(derivative).matrix().transpose();
  }
  return inputs;
}

Trajectory allocate(const LocallyNonlinearSystem& system, const SimulationOptions& options, Index samples) {
  const MatrixXd motion = MatrixXd::Zero(options.keep_motion ? system.size() : 0, samples);
  return {options.step * static_cast<double>(options.keep_every),
          motion,
          motion,
          motion,
          MatrixXd::Zero(system.connector_count(), samples),
          MatrixXd::Zero(3 * system.input_count(), samples),
          MatrixXd::Zero(system.connector_states(), samples)};
}

/// Leaves the first `samples` samples.
void truncate(Trajectory& trajectory, Index samples) {
  for (auto* series : {&trajectory.displacement, &trajectory.velocity, &trajectory.acceleration, &trajectory.force,
                       &trajectory.inputs, &trajectory.connector_states})
    series->conservativeResize(Eigen::NoChange, samples);
}

void observe(const OutputMap& map, const Motion& motion, const VectorXd& inputs, MatrixXd::RowXpr row) {
  const Index n_u = inputs.size() / 3;
  row = (map.displacement * motion.displacement + map.velocity * motion.velocity +
         map.acceleration * motion.acceleration + map.force * motion.force + map.input_value * inputs.head(n_u) +
         map.input_rate * inputs.segment(n_u, n_u) + map.input_acceleration * inputs.tail(n_u))
            .transpose();
}

/// Stores what the options ask for while a simulation runs, in the system's own coordinates whatever it is stepped in.
class Recorder {
public:
  Recorder(const LocallyNonlinearSystem& system, const SimulationOptions& options, const DampedModeSplit* split,
           Index steps, SimulationResult& result)
      : options_(options),
        split_(split),
        every_step_(split ? split->outputs(options.every_step) : options.every_step),
        every_sample_(split ? split->outputs(options.every_sample) : options.every_sample),
        result_(result) {
    const Index samples = steps / options.keep_every + 1;
    result.trajectory = allocate(system, options, samples);
    result.every_step.setZero(every_step_.size() > 0 ? steps + 1 : 0, every_step_.size());
    result.every_sample.setZero(samples, every_sample_.size());
  }

  void store(Index step, const Motion& motion, const VectorXd& inputs) {
    if (every_step_.size() > 0) observe(every_step_, motion, inputs, result_.every_step.row(step));
    if (step % options_.keep_every == 0) store_sample(step / options_.keep_every, motion, inputs);
  }

private:
  void store_sample(Index sample, const Motion& motion, const VectorXd& inputs) {
    auto& trajectory = result_.trajectory;
    if (options_.keep_motion) {
      trajectory.displacement.col(sample) = merged(motion.displacement);
      trajectory.velocity.col(sample) = merged(motion.velocity);
      trajectory.acceleration.col(sample) = merged(motion.acceleration);
    }
    trajectory.force.col(sample) = motion.force;
    trajectory.inputs.col(sample) = inputs;
    trajectory.connector_states.col(sample) = motion.connector_states;
    if (every_sample_.size() > 0) observe(every_sample_, motion, inputs, result_.every_sample.row(sample));
    if (options_.snapshot && sample % options_.snapshot_every == 0)
      options_.snapshot(static_cast<double>(sample) * trajectory.step, merged(motion.displacement));
  }

  [[nodiscard]] VectorXd merged(const VectorXd& motion) const { return split_ ? split_->merge(motion) : motion; }

  const SimulationOptions& options_;
  const DampedModeSplit* split_;
  OutputMap every_step_, every_sample_;
  SimulationResult& result_;
};

std::optional<SimulationFailure> failure_of(const ForceSolveOutcome& outcome, const Motion& motion, double time) {
  if (!outcome.finite || !motion.acceleration.allFinite())
    return SimulationFailure{
        time,
        "a connector force or the motion is no longer finite: a law divides by zero, or the response "
        "grows without bound (exact stepping with connectors much stiffer than the rest does so "
        "where omega h is above about 3.5: take more steps, or newmark)"};
  if (!outcome.converged)
    return SimulationFailure{time, "the connector forces did not converge: take a smaller step or a smoother law"};
  return std::nullopt;
}

}  // namespace

InitialState at_rest(Index dofs, Index connector_states) {
  return {VectorXd::Zero(dofs), VectorXd::Zero(dofs), VectorXd::Zero(connector_states)};
}

AlphaParameters newmark_parameters() { return {}; }

AlphaParameters hht_parameters(double alpha) { return {(1.0 - alpha) * (1.0 - alpha) / 4.0, 0.5 - alpha, 0.0, -alpha}; }

AlphaParameters generalized_alpha_parameters(double rho) {
  const double a_m = (2.0 * rho - 1.0) / (rho + 1.0), a_f = rho / (rho + 1.0);
  return {(1.0 - a_m + a_f) * (1.0 - a_m + a_f) / 4.0, 0.5 - a_m + a_f, a_m, a_f};
}

SimulationResult simulate(const LocallyNonlinearSystem& system, const std::vector<SignalPtr>& signals,
                          const InitialState& initial, const SimulationOptions& options) {
  check(system, signals, initial, options);
  const auto scheme = alpha_parameters(options);
  auto split = scheme ? split_damped_modes(system) : std::nullopt;
  if (split) correct_periods(split->system, system.size(), options.step, *scheme);
  const auto in_coordinates = [&](const VectorXd& motion) { return split ? split->split(motion) : motion; };
  const auto steps = static_cast<Index>(std::llround(options.duration / options.step));
  const auto& stepped = split ? split->system : system;
  const auto stepper = scheme ? make_alpha_stepper(stepped, options.step, *scheme, options.forces)
                              : make_exact_stepper(stepped, options.step, options.forces);
  SimulationResult result;
  Recorder recorder(system, options, split ? &*split : nullptr, steps, result);
  Motion motion{in_coordinates(initial.displacement), in_coordinates(initial.velocity),
                in_coordinates(VectorXd::Zero(system.size())), VectorXd::Zero(system.connector_count()),
                initial.connector_states};

  MatrixXd inputs = sample_inputs(signals, options.step, 0, std::min(input_block, steps) + 1);
  Index block_start = 0;
  result.failure = failure_of(stepper->start(motion, inputs.col(0)), motion, 0.0);
  recorder.store(0, motion, inputs.col(0));
  VectorXd begin = inputs.col(0), end;
  Index k = 1;
  for (; k <= steps && !result.failure; ++k) {
    if (k - block_start > input_block) {
      block_start = k - 1;
      inputs = sample_inputs(signals, options.step, block_start, std::min(input_block, steps - block_start) + 1);
    }
    if (options.progress && k % progress_block == 0)
      options.progress("simulate", static_cast<double>(k) / static_cast<double>(steps));
    end = inputs.col(k - block_start);
    const auto outcome = stepper->advance(motion, begin, end);
    result.failure = failure_of(outcome, motion, static_cast<double>(k) * options.step);
    recorder.store(k, motion, end);
    begin.swap(end);
  }
  if (result.failure) {
    const Index failed = k - 1, samples = failed == 0 ? 0 : (failed - 1) / options.keep_every + 1;
    truncate(result.trajectory, samples);
    result.every_sample.conservativeResize(samples, Eigen::NoChange);
    if (result.every_step.size() > 0) result.every_step.conservativeResize(failed, Eigen::NoChange);
  }
  return result;
}

}  // namespace kalfem
