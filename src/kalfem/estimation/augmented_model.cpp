// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/augmented_model.hpp"

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/discretisation.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void check_unknown(const UnknownParameter& unknown, const LocallyNonlinearSystem& system, IssueList& issues) {
  const std::string title = "unknown '" + unknown.name + "'";
  if (!std::isfinite(unknown.initial))
    issues.add({}, title + " has no finite initial value", "the filter starts from it");
  if (!(unknown.deviation > 0.0) || !std::isfinite(unknown.deviation))
    issues.add({}, title + " has the prior standard deviation " + std::to_string(unknown.deviation),
               "it must be > 0; to hold a parameter fixed, remove it from estimate.unknown");
  if (!(unknown.random_walk >= 0.0) || !std::isfinite(unknown.random_walk))
    issues.add({}, title + " has a random walk whose density is negative or not finite", "it must be zero or positive");
  if (!unknown.sensors.empty() && (!unknown.targets.empty() || unknown.transform.kind != TransformKind::none))
    issues.add({}, title + " is the constant of a sensor and has a target or a transform",
               "such an unknown is added to the sensor's output directly");
  for (const auto& target : unknown.targets)
    if (target.connector < 0 || target.connector >= system.connector_count() || target.parameter < 0 ||
        target.parameter >= system.connectors[static_cast<std::size_t>(target.connector)].parameters.size())
      issues.add({}, title + " names a connector parameter that does not exist", "");
  const auto& transform = unknown.transform;
  if (transform.kind == TransformKind::log && !(unknown.initial > 0.0))
    issues.add({}, title + " starts at " + std::to_string(unknown.initial), "with transform: log it must be > 0");
  if (transform.kind == TransformKind::logit && !std::isfinite(transform.upper - transform.lower))
    issues.add({}, title + " has a bound that is not finite", "transform: logit needs two finite bounds",
               "use transform: log");
  else if (transform.kind == TransformKind::logit &&
           !(transform.lower < unknown.initial && unknown.initial < transform.upper))
    issues.add({},
               title + " starts at " + std::to_string(unknown.initial) + ", outside its bounds [" +
                   std::to_string(transform.lower) + ", " + std::to_string(transform.upper) + "]",
               "the start must lie strictly between the bounds", "move the start or the bounds");
}

void check_finite(const VectorXd& values, const std::string& what, IssueList& issues) {
  if (!values.allFinite()) issues.add({}, "a " + what + " is not finite", "the filter starts from it");
}

void check_deviation(const VectorXd& values, const std::string& what, IssueList& issues) {
  if (!values.allFinite() || (values.array() < 0.0).any())
    issues.add({}, "a " + what + " is negative or not finite",
               "it is a standard deviation or a noise density; it must be zero or positive",
               "write 0 for a value that is known exactly");
}

MatrixXd symmetric(const MatrixXd& matrix) { return 0.5 * (matrix + matrix.transpose()); }

constexpr double largest_step = 0.25;  ///< of a neighbour, to the value

AugmentedModelOptions checked(AugmentedModelOptions options) {
  if (options.substeps < 1)
    throw InvalidInput("the filter's model has " + std::to_string(options.substeps) + " substeps",
                       "it needs at least one", "");
  if (options.step_order != 2 && options.step_order != 4)
    throw InvalidInput("the filter's model has a step of order " + std::to_string(options.step_order),
                       "there are steps of order 2 and 4", "use 2 or 4");
  return options;
}

}  // namespace

std::vector<Index> linear_unknowns(const AugmentedModelOptions& options) {
  const auto is_of_linear_part = [](const UnknownParameter& unknown) {
    return unknown.in_linear_part || (unknown.targets.empty() && unknown.sensors.empty());
  };
  std::vector<Index> places;
  for (std::size_t i = 0; i < options.unknowns.size(); ++i)
    if (is_of_linear_part(options.unknowns[i])) places.push_back(static_cast<Index>(i));
  return places;
}

// How the model inside the filter is made:
//   1. the first-order form of the system with sensors' chains and modelled inputs, in physical coordinates or in the
//      modal ones in which its dynamics is block diagonal (AugmentedModelForm);
//   2. the step over one part of the sample interval (CollocationStep): the linear part exact, connector forces linear
//   or
//      quadratic over it;
//   3. the prior of [x; s; theta; x(0); s(0)] in physical coordinates, then carried over. Standard deviations of an
//      unknown go through the slope of its transform. A kept initial state is fully correlated with the state;
//   4. Q of a whole interval: the linear part from its white-noise densities by Van Loan's integral [VL78], the random
//      walks of internal states and unknowns as density times the step;
//   5. two neighbours an unknown of the linear part, theta_0 +- s, whose maps give the columns of ParameterTangent.
AugmentedModel::AugmentedModel(Bare /*tag*/, const LocallyNonlinearSystem& system, const OutputMap& sensors,
                               const std::vector<MeasurementChain>& chains, AugmentedModelOptions options)
    : system_(system),
      sensors_(sensors),
      chains_(chains),
      options_(checked(std::move(options))),
      form_(system_, sensors, chains, options_.inputs, options_.coordinates),
      step_(form_.first_order, options_.step / options_.substeps, options_.step_order),
      layout_{system.size(), form_.first_order.size(), system.connector_states(),
              static_cast<Index>(options_.unknowns.size()), options_.keep_initial_state} {}

AugmentedModel::AugmentedModel(const LocallyNonlinearSystem& system, const OutputMap& sensors,
                               const std::vector<MeasurementChain>& chains, AugmentedModelOptions options)
    : AugmentedModel(Bare{}, system, sensors, chains, std::move(options)) {
  check();
  set_prior();
  process_noise_ = linear_noise(options_.process_noise.acceleration, options_.process_noise.input, options_.step);
  add_walks(process_noise_);
  const auto linear = linear_unknowns(options_);
  VectorXd values(static_cast<Index>(linear.size())), deviations(values.size());
  for (std::size_t i = 0; i < linear.size(); ++i) {
    values[static_cast<Index>(i)] = options_.unknowns[static_cast<std::size_t>(linear[i])].initial;
    deviations[static_cast<Index>(i)] = options_.unknowns[static_cast<std::size_t>(linear[i])].deviation;
  }
  set_neighbours(values, deviations);
}

/// Prior and noise go over through physical coordinates, because the modal ones depend on the values.
AugmentedModel AugmentedModel::about(const VectorXd& values, const VectorXd& deviations) const {
  AugmentedModel other(Bare{}, options_.system_at(values), sensors_, chains_, options_);
  other.prior_ = {other.own(physical(prior_.mean)), other.own_covariance(physical_covariance(prior_.covariance))};
  other.process_noise_ = other.own_covariance(physical_covariance(process_noise_));
  other.set_neighbours(values, deviations);
  return other;
}

/// s = sqrt(3) deviations, where sigma points along the unknown would stand, but never so far that the structure
/// changes its nature.
void AugmentedModel::set_neighbours(const VectorXd& values, const VectorXd& deviations) {
  AugmentedModelOptions options = options_;
  options.coordinates = StateCoordinates::physical;
  const auto linear = linear_unknowns(options_);
  for (Index i = 0; i < values.size(); ++i) {
    const double step =
        std::min(std::sqrt(3.0) * deviations[i], values[i] == 0.0 ? deviations[i] : largest_step * std::abs(values[i]));
    const auto beside = [&](double by) {
      const VectorXd moved = values + by * VectorXd::Unit(values.size(), i);
      return std::shared_ptr<const AugmentedModel>(
          new AugmentedModel(Bare{}, options_.system_at(moved), sensors_, chains_, options));
    };
    neighbours_.push_back({linear[static_cast<std::size_t>(i)], values[i], step, beside(-step), beside(step)});
  }
}

/// Everything that the caller may have got wrong, at once.
void AugmentedModel::check() const {
  IssueList issues;
  for (const auto& unknown : options_.unknowns) {
    check_unknown(unknown, system_, issues);
    for (const Index sensor : unknown.sensors)
      if (sensor < 0 || sensor >= form().outputs().state.rows())
        issues.add({}, "unknown '" + unknown.name + "' names a sensor that does not exist", "");
    if (unknown.targets.empty() && unknown.sensors.empty() && !options_.system_at)
      issues.add({}, "unknown '" + unknown.name + "' has no effect on the model", "name a parameter of a connector");
    else if (unknown.in_linear_part && !options_.system_at)
      issues.add({},
                 "unknown '" + unknown.name + "' belongs to the linear part, which was not given as a function of it",
                 "set AugmentedModelOptions::system_at");
  }
  const auto& prior = options_.prior;
  const auto& noise = options_.process_noise;
  const Index n = layout_.dofs, s = layout_.connector_states, u = system_.input_count();
  const bool fits = prior.mean.displacement.size() == n && prior.mean.velocity.size() == n &&
                    prior.mean.connector_states.size() == s && prior.displacement_deviation.size() == n &&
                    prior.velocity_deviation.size() == n && prior.connector_state_deviation.size() == s &&
                    (prior.motion_covariance.size() == 0 ||
                     (prior.motion_covariance.rows() == 2 * n && prior.motion_covariance.cols() == 2 * n)) &&
                    prior.input_deviation.size() == u && prior.input_rate_deviation.size() == u &&
                    noise.acceleration.size() == n && noise.input.size() == u && noise.connector_states.size() == s;
  if (!fits) issues.add({}, "prior or process noise does not fit the system's size", "it needs one value per state");
  check_finite(prior.mean.displacement, "initial displacement", issues);
  check_finite(prior.mean.velocity, "initial velocity", issues);
  check_finite(prior.mean.connector_states, "initial internal state of a connector", issues);
  check_finite(prior.motion_covariance.reshaped(), "prior covariance of the motion", issues);
  check_deviation(prior.displacement_deviation, "prior standard deviation of a displacement", issues);
  check_deviation(prior.velocity_deviation, "prior standard deviation of a velocity", issues);
  check_deviation(prior.connector_state_deviation, "prior standard deviation of a connector's internal state", issues);
  check_deviation(prior.input_deviation, "prior standard deviation of an input", issues);
  check_deviation(prior.input_rate_deviation, "prior standard deviation of an input's rate", issues);
  check_deviation(VectorXd::Constant(1, prior.sensor_state_deviation), "prior standard deviation of a sensor's state",
                  issues);
  check_deviation(noise.acceleration, "process noise of a degree of freedom", issues);
  check_deviation(noise.input, "process noise of an input", issues);
  check_deviation(noise.connector_states, "process noise of a connector's internal state", issues);
  issues.raise();
}

void AugmentedModel::set_prior() {
  const auto& prior = options_.prior;
  const Index n = layout_.dofs;
  VectorXd deviation = VectorXd::Zero(layout_.size());
  deviation.segment(2 * n, layout_.linear - 2 * n).setConstant(prior.sensor_state_deviation);
  deviation.head(n) = prior.displacement_deviation;
  deviation.segment(n, n) = prior.velocity_deviation;
  for (Index i = 0; i < system_.input_count(); ++i) {
    const Index state = form().input_state(i);
    if (state < 0) continue;
    if (options_.inputs[static_cast<std::size_t>(i)].model == InputModel::integrated) {
      deviation[state] = prior.input_deviation[i];
      deviation[state + 1] = prior.input_rate_deviation[i];
    } else {
      deviation.segment(state, options_.inputs[static_cast<std::size_t>(i)].states()).setZero();
    }
  }
  deviation.segment(layout_.connector_state(), layout_.connector_states) = prior.connector_state_deviation;

  VectorXd unknowns(layout_.unknowns);
  for (Index i = 0; i < layout_.unknowns; ++i) {
    const auto& unknown = options_.unknowns[static_cast<std::size_t>(i)];
    unknowns[i] = unknown.transform.to_state(unknown.initial);
    deviation[layout_.unknown() + i] = unknown.deviation / unknown.transform.slope(unknowns[i]);
  }
  prior_.covariance = deviation.cwiseAbs2().asDiagonal();
  add_latent_inputs(prior_.covariance);
  if (prior.motion_covariance.size() > 0) prior_.covariance.topLeftCorner(2 * n, 2 * n) += prior.motion_covariance;
  if (layout_.keeps_initial_state) {  // x(0) is the same random variable as x at the start
    const Index begin = layout_.initial_state(), count = layout_.size() - begin;
    const MatrixXd start = prior_.covariance.topLeftCorner(count, count);
    prior_.covariance.block(begin, begin, count, count) = start;
    prior_.covariance.block(begin, 0, count, count) = start;
    prior_.covariance.block(0, begin, count, count) = start;
  }
  prior_.covariance = own_covariance(prior_.covariance);
  VectorXd linear = VectorXd::Zero(layout_.linear);
  linear.head(n) = prior.mean.displacement;
  linear.segment(n, n) = prior.mean.velocity;
  prior_ = prior_about(unknowns, linear, prior.mean.connector_states);
}

/// A latent input starts with the stationary covariance of its process.
void AugmentedModel::add_latent_inputs(MatrixXd& covariance) const {
  for (Index i = 0; i < system_.input_count(); ++i) {
    if (form().input_state(i) < 0) continue;
    const auto& treatment = options_.inputs[static_cast<std::size_t>(i)];
    if (!treatment.is_latent()) continue;
    const Index first = form().input_state(i) + treatment.first_derivative(), order = treatment.process.order;
    covariance.block(first, first, order, order) = treatment.process.covariance(options_.prior.input_deviation[i]);
  }
}

Gaussian AugmentedModel::prior_about(const VectorXd& unknowns, const VectorXd& linear_state,
                                     const VectorXd& connector_states) const {
  Gaussian prior{VectorXd::Zero(layout_.size()), prior_.covariance};
  prior.mean.head(layout_.linear) = linear_state;
  prior.mean.segment(layout_.connector_state(), layout_.connector_states) = connector_states;
  prior.mean.segment(layout_.unknown(), layout_.unknowns) = unknowns;
  if (layout_.keeps_initial_state)
    prior.mean.tail(layout_.size() - layout_.initial_state()) << linear_state, connector_states;
  prior.mean = own(prior.mean);
  return prior;
}

/// The state and, where it is kept, the initial state; internal states and unknowns are the same in any coordinates.
MatrixXd AugmentedModel::moved(MatrixXd rows, Move move) const {
  if (form_.coordinates == StateCoordinates::physical) return rows;
  rows.topRows(layout_.linear) = (form_.*move)(rows.topRows(layout_.linear));
  if (layout_.keeps_initial_state) {
    const auto kept = Eigen::seqN(layout_.initial_state(), layout_.linear);
    rows(kept, Eigen::all) = (form_.*move)(rows(kept, Eigen::all));
  }
  return rows;
}

MatrixXd AugmentedModel::physical_covariance(const MatrixXd& covariance) const {
  return symmetric(physical(physical(covariance).transpose()));
}

MatrixXd AugmentedModel::own_covariance(const MatrixXd& physical) const {
  return symmetric(own(own(physical).transpose()));
}

MatrixXd AugmentedModel::acceleration_noise(const VectorXd& density, double interval) const {
  return linear_noise(density, VectorXd::Zero(system_.input_count()), interval);
}

MatrixXd AugmentedModel::other_process_noise() const {
  MatrixXd noise = linear_noise(VectorXd::Zero(layout_.dofs), options_.process_noise.input, options_.step);
  add_walks(noise);
  return noise;
}

/// White acceleration drives the velocities; white noise drives the last state of every input that has states.
MatrixXd AugmentedModel::linear_noise(const VectorXd& acceleration, const VectorXd& input, double interval) const {
  const Index n = layout_.dofs;
  MatrixXd density = MatrixXd::Zero(layout_.linear, layout_.linear);
  density.diagonal().segment(n, n) = acceleration.cwiseAbs2();
  for (Index i = 0; i < system_.input_count(); ++i) {
    const Index state = form().input_state(i);
    if (state < 0) continue;
    const Index last = state + options_.inputs[static_cast<std::size_t>(i)].states() - 1;
    density(last, last) = input[i] * input[i];
  }
  MatrixXd noise = MatrixXd::Zero(layout_.size(), layout_.size());
  density = symmetric(form_.from_physical(form_.from_physical(density).transpose()));
  if (!density.isZero(0.0))
    noise.topLeftCorner(layout_.linear, layout_.linear) =
        process_noise_covariance(form().dynamics(), density, interval);
  return noise;
}

/// Of internal states and unknowns.
void AugmentedModel::add_walks(MatrixXd& noise) const {
  noise.diagonal().segment(layout_.connector_state(), layout_.connector_states) =
      options_.step * options_.process_noise.connector_states.cwiseAbs2();
  for (Index i = 0; i < layout_.unknowns; ++i) {
    const auto& unknown = options_.unknowns[static_cast<std::size_t>(i)];
    const double walk = unknown.random_walk / unknown.transform.slope(unknown.transform.to_state(unknown.initial));
    noise(layout_.unknown() + i, layout_.unknown() + i) = options_.step * walk * walk;
  }
}

}  // namespace kalfem
