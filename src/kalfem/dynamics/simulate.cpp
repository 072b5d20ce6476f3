// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/simulate.hpp"

#include <cmath>

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/dynamics/modal_coordinates.hpp"
#include "kalfem/dynamics/stepper.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index input_block = 65536;   ///< steps whose inputs are sampled together
constexpr Index progress_block = 256;  ///< steps between two reports of progress
constexpr double most_steps = 1e10;
constexpr double most_values = 2e9;  ///< stored, 16 GB

// Counted as a double, and before anything is allocated: a step of microseconds over hours must be refused with a
// sentence.
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
  if (options.keep_every < 1) issues.add({}, "keep_every is below 1", "it is the number of steps per stored sample");
  if (options.integrator == Integrator::hht_alpha && !(options.hht_alpha >= -1.0 / 3.0 && options.hht_alpha <= 0.0))
    issues.add({}, "alpha of HHT is " + std::to_string(options.hht_alpha), "it must lie in [-1/3, 0]");
  if (options.integrator == Integrator::generalized_alpha &&
      !(options.spectral_radius >= 0.0 && options.spectral_radius <= 1.0))
    issues.add({}, "the spectral radius is " + std::to_string(options.spectral_radius), "it must lie in [0, 1]");
  if (static_cast<Index>(signals.size()) != system.input_count())
    issues.add({}, std::to_string(signals.size()) + " signals for " + std::to_string(system.input_count()) + " inputs",
               "every input needs one signal");
  if (initial.displacement.size() != system.size() || initial.velocity.size() != system.size() ||
      initial.connector_states.size() != system.connector_states())
    issues.add({}, "the initial state does not fit the system's size",
               "it needs one value per degree of freedom and internal state");
  issues.raise();
  if (options.duration / options.step > most_steps || stored_values(system, options) > most_values)
    throw InvalidInput(std::to_string(options.duration) + " s in steps of " + std::to_string(options.step) +
                           " s are more samples than fit in memory",
                       "at most 10^10 steps and 2 10^9 stored values are possible",
                       "shorten the duration or keep fewer samples");
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

/// [r; r'; r''] of all inputs at every step, sampled some thousand steps at a time: signals are fast by blocks, and all
/// steps at once may not fit in memory. Steps are asked for in order.
class SampledInputs {
public:
  SampledInputs(const std::vector<SignalPtr>& signals, double step, Index steps)
      : signals_(signals), step_(step), steps_(steps) {
    sample_from(0);
  }

  /// Goes on to step k, 3 n_u values.
  const VectorXd& at(Index k) {
    previous_.swap(current_);
    if (k - first_ > input_block) sample_from(k - 1);
    current_ = block_.col(k - first_);
    return current_;
  }
  [[nodiscard]] const VectorXd& current() const { return current_; }
  [[nodiscard]] const VectorXd& previous() const { return previous_; }  ///< of the step before

private:
  void sample_from(Index first) {
    const auto n_u = static_cast<Index>(signals_.size()), count = std::min(input_block, steps_ - first) + 1;
    first_ = first;
    block_.resize(3 * n_u, count);
    for (Index i = 0; i < n_u; ++i) {
      const auto sampled =
          signals_[static_cast<std::size_t>(i)]->sample(static_cast<double>(first) * step_, step_, count);
      for (Index derivative = 0; derivative < 3; ++derivative)
        block_.row(derivative * n_u + i) = sampled.col(derivative).matrix().transpose();
    }
  }

  const std::vector<SignalPtr>& signals_;
  double step_;
  Index steps_, first_ = 0;
  MatrixXd block_;
  VectorXd previous_, current_;
};

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

// y = S_d z + S_v z' + S_a z'' + F f + T_0 r + T_1 r' + T_2 r'', all at the same instant.
void observe(const OutputMap& map, const Motion& motion, const VectorXd& inputs, MatrixXd::ColXpr column) {
  const Index n_u = inputs.size() / 3;
  column = map.displacement * motion.displacement + map.velocity * motion.velocity +
           map.acceleration * motion.acceleration + map.force * motion.force + map.input_value * inputs.head(n_u) +
           map.input_rate * inputs.segment(n_u, n_u) + map.input_acceleration * inputs.tail(n_u);
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
    result.every_step.setZero(every_step_.size(), every_step_.size() > 0 ? steps + 1 : 0);
    result.every_sample.setZero(every_sample_.size(), samples);
  }

  void store(Index step, const Motion& motion, const VectorXd& inputs) {
    if (every_step_.size() > 0) observe(every_step_, motion, inputs, result_.every_step.col(step));
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
    if (every_sample_.size() > 0) observe(every_sample_, motion, inputs, result_.every_sample.col(sample));
    if (options_.snapshot && sample % options_.snapshot_every == 0)
      options_.snapshot(static_cast<double>(sample) * trajectory.step, merged(motion.displacement));
  }

  [[nodiscard]] VectorXd merged(const VectorXd& motion) const { return split_ ? split_->merge(motion) : motion; }

  const SimulationOptions& options_;
  const DampedModeSplit* split_;
  OutputMap every_step_, every_sample_;
  SimulationResult& result_;
};

// A failure is a value, not an exception: a search over parameters meets many, and goes on with the next point.
std::optional<SimulationFailure> failure_of(const ForceSolveOutcome& outcome, const Motion& motion, double time) {
  if (!outcome.finite || !motion.acceleration.allFinite())
    return SimulationFailure{time,
                             "a connector force or the motion is no longer finite: a law divides by zero or the "
                             "response grows without bound; with integrator: exact, connectors much stiffer than the "
                             "rest cause this when omega h exceeds about 3.5: use more steps or newmark"};
  if (!outcome.converged)
    return SimulationFailure{time, "the connector forces did not converge: use a smaller step or a smoother law"};
  return std::nullopt;
}

/// What a simulation is stepped with: the system itself, or under modal damping its split into damped modes and the
/// rest, with the periods of the damped modes corrected for the scheme (split_damped_modes(), correct_periods()).
struct SteppedSystem {
  std::optional<AlphaParameters> scheme;  ///< none: exact steps
  std::optional<DampedModeSplit> split;   ///< none: the system's own coordinates
  std::unique_ptr<Stepper> stepper;

  SteppedSystem(const LocallyNonlinearSystem& system, const SimulationOptions& options)
      : scheme(alpha_parameters(options)), split(scheme ? split_damped_modes(system) : std::nullopt) {
    if (split) correct_periods(split->system, system.size(), options.step, *scheme);
    const auto& stepped = split ? split->system : system;
    stepper = scheme ? make_alpha_stepper(stepped, options.step, *scheme, options.forces, options.precision)
                     : make_exact_stepper(stepped, options.step, options.forces);
  }

  [[nodiscard]] Motion motion_of(const InitialState& initial, Index connectors) const {
    const auto own = [&](const VectorXd& motion) { return split ? split->split(motion) : motion; };
    return {own(initial.displacement), own(initial.velocity), own(VectorXd::Zero(initial.displacement.size())),
            VectorXd::Zero(connectors), initial.connector_states};
  }
};

// The loop, step by step: solve for the accelerations and connector forces at the start; then advance by one step from
// the inputs at its start and end. After each: stop where a force or the motion is not finite or a solve has not
// converged; store what is asked for at every step and at every so many steps, in the system's own coordinates; report.
/// A transient in steps of equal length. The first failure ends it: what is stored ends before the step that failed.
class TransientRun {
public:
  TransientRun(const LocallyNonlinearSystem& system, const std::vector<SignalPtr>& signals, const InitialState& initial,
               const SimulationOptions& options)
      : options_(options),
        steps_(static_cast<Index>(std::llround(options.duration / options.step))),
        stepped_(system, options),
        inputs_(signals, options.step, steps_),
        motion_(stepped_.motion_of(initial, system.connector_count())),
        recorder_(system, options, stepped_.split ? &*stepped_.split : nullptr, steps_, result_) {
    result_.solve_error = stepped_.stepper->solve_error();
  }

  SimulationResult run() {
    for (Index k = 0; k <= steps_; ++k) {
      stop_if_asked();
      // Accelerations and connector forces at the start belong to the initial state, then step by step.
      const auto outcome = k == 0 ? start() : advance(k);
      if (failed(outcome, k)) return ended_before(k);
      recorder_.store(k, motion_, inputs_.current());
      report_progress(k);
    }
    return std::move(result_);
  }

private:
  ForceSolveOutcome start() { return stepped_.stepper->start(motion_, inputs_.at(0)); }

  ForceSolveOutcome advance(Index k) {
    const auto& end = inputs_.at(k);
    return stepped_.stepper->advance(motion_, inputs_.previous(), end);
  }

  bool failed(const ForceSolveOutcome& outcome, Index k) {
    result_.failure = failure_of(outcome, motion_, static_cast<double>(k) * options_.step);
    return result_.failure.has_value();
  }

  void report_progress(Index k) const {
    if (options_.progress && k > 0 && k % progress_block == 0)
      options_.progress("simulate", static_cast<double>(k) / static_cast<double>(steps_));
  }

  SimulationResult ended_before(Index k) {
    const Index samples = k == 0 ? 0 : (k - 1) / options_.keep_every + 1;
    truncate(result_.trajectory, samples);
    result_.every_sample.conservativeResize(Eigen::NoChange, samples);
    if (result_.every_step.size() > 0) result_.every_step.conservativeResize(Eigen::NoChange, k);
    return std::move(result_);
  }

  const SimulationOptions& options_;
  Index steps_;
  SteppedSystem stepped_;
  SampledInputs inputs_;
  Motion motion_;
  SimulationResult result_;
  Recorder recorder_;
};

}  // namespace

InitialState at_rest(Index dofs, Index connector_states) {
  return {VectorXd::Zero(dofs), VectorXd::Zero(dofs), VectorXd::Zero(connector_states)};
}

AlphaParameters newmark_parameters() { return {}; }

// beta and gamma of second order and largest damping at high frequencies, for HHT from alpha and for generalised-alpha
// from the spectral radius at infinite frequency: gamma = 1/2 - a_m + a_f, beta = (1 - a_m + a_f)^2 / 4.
AlphaParameters hht_parameters(double alpha) { return {(1.0 - alpha) * (1.0 - alpha) / 4.0, 0.5 - alpha, 0.0, -alpha}; }

AlphaParameters generalized_alpha_parameters(double rho) {
  const double a_m = (2.0 * rho - 1.0) / (rho + 1.0), a_f = rho / (rho + 1.0);
  return {(1.0 - a_m + a_f) * (1.0 - a_m + a_f) / 4.0, 0.5 - a_m + a_f, a_m, a_f};
}

SimulationResult simulate(const LocallyNonlinearSystem& system, const std::vector<SignalPtr>& signals,
                          const InitialState& initial, const SimulationOptions& options) {
  check(system, signals, initial, options);
  return TransientRun(system, signals, initial, options).run();
}

}  // namespace kalfem
