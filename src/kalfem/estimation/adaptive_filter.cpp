// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/adaptive_filter.hpp"

#include <cmath>

#include "kalfem/estimation/covariance_factor.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double log_ratio = 0.05;      ///< of the second filter's process noise: differences then hardly round
constexpr double smallest_move = 0.01;  ///< of ln(factor), for which the filters are given another Q
constexpr double hardly_visible = 1e-3, invisible = 1e-5;  ///< of a sensor's variance
constexpr double horizon_share = 0.1;                      ///< of the memory

VectorXd unit_density(const AugmentedModel& model) {
  const auto& unit = model.options().process_noise.unit_acceleration;
  return unit.size() > 0 ? unit : VectorXd::Ones(model.layout().dofs);
}

bool states_density(const AugmentedModel& model) {
  return (model.options().process_noise.acceleration.array() > 0.0).any();
}

/// The largest part of a sensor's variance that the accelerations of this density make within `horizon` seconds.
double visible_part(const AugmentedModel& first, const VectorXd& density, const MatrixXd& noise, const Gaussian& prior,
                    FilterSetup& setup, double horizon) {
  MatrixXd factor;
  if (!covariance_factor(first.acceleration_noise(density, horizon), factor)) return 0.0;
  auto transform = UnscentedTransform::linearised();
  auto& map = setup.measurement;
  if (map.moving_gain() > 0) map.set_mean(prior.mean);
  if (!transform.apply(map, prior.mean, factor, FactorShape::lower_triangular)) return 0.0;
  const VectorXd seen = transform.deviations().rowwise().squaredNorm();
  return seen.cwiseQuotient(noise.diagonal().cwiseMax(1e-300)).maxCoeff();
}

}  // namespace

ScaledProcessNoise::ScaledProcessNoise(const AugmentedModel& first, const VectorXd& density)
    : first_(first),
      others_(first.other_process_noise()),
      scaled_(first.acceleration_noise(density, first.options().step)) {}

MatrixXd ScaledProcessNoise::at(double factor, const AugmentedModel& model) const {
  MatrixXd noise = others_ + factor * scaled_;
  return &model == &first_ ? noise : model.own_covariance(first_.physical_covariance(noise));
}

AdaptiveDensity adaptive_density(const AugmentedModel& first, const MatrixXd& noise, const Gaussian& prior,
                                 FilterSetup& setup, double horizon) {
  const VectorXd unit = unit_density(first), &stated = first.options().process_noise.acceleration;
  AdaptiveDensity density{states_density(first) ? stated : unit};
  const double part = visible_part(first, density.on_dofs, noise, prior, setup, horizon);
  if (!states_density(first)) {
    const double scale = part > 0.0 && std::isfinite(part) ? std::sqrt(hardly_visible / part) : 0.0;
    density.on_dofs *= scale;
    density.least_factor = invisible / hardly_visible;
  } else if (part > 0.0 && std::isfinite(part)) {
    density.least_factor = std::min(1.0, invisible / part);
  }
  for (Index i = 0; i < unit.size(); ++i)
    if (unit[i] != 0.0) density.at_points = std::max(density.at_points, std::abs(density.on_dofs[i] / unit[i]));
  return density;
}

NoiseAdaptation::NoiseAdaptation(const AugmentedModel& first, const FilterInput& input,
                                 const EstimationOptions& options, const Gaussian& prior, FilterSetup& setup)
    : first_(first),
      input_(input),
      options_(options),
      density_([&] {
        if (!options.adaptive_noise.process) return AdaptiveDensity{};
        setup.measurement.set_inputs(input.inputs.col(0));
        return adaptive_density(first, input.noise, prior, setup, horizon_share * options.adaptive_noise.memory);
      }()),
      recursion_(options.adaptive_noise, input.noise, first.options().step, density_.least_factor) {
  options_.monitored = {};
  const Index samples = input.measured.samples();
  course_.sensors = MatrixXd::Constant(input.noise.rows(), samples, std::nan(""));
  if (!options.adaptive_noise.process) return;
  course_.process_factor = VectorXd::Constant(samples, std::nan(""));
  process_.emplace(first, density_.on_dofs);
  neighbour_ = std::make_unique<FilterSetup>(setup.augmented_model, input.noise, options_);
  neighbour_->filter->reset(prior);
  apply(1.0, setup);
}

void NoiseAdaptation::predict_to(Index k) {
  if (neighbour_ && neighbour_usable_)
    neighbour_usable_ = kalfem::predict_to(k, input_, *neighbour_) == FilterOutcome::usable;
}

void NoiseAdaptation::learn(Index k, const Innovation& innovation, FilterSetup& setup) {
  course_.sensors.col(k) = measurement_noise().diagonal().cwiseSqrt();
  if (neighbour_) {
    course_.process_factor[k] = factor_;
    neighbour_usable_ = neighbour_usable_ && update_at(k, input_, options_.held_out, *neighbour_, measured_,
                                                       innovation_) == FilterOutcome::usable;
  }
  recursion_.learn(innovation, neighbour_ && neighbour_usable_ ? &innovation_ : nullptr, log_ratio);
  if (neighbour_) {
    if (!neighbour_usable_) restart(setup);
    if (std::abs(std::log(recursion_.process_factor() / factor_)) > smallest_move)
      apply(recursion_.process_factor(), setup);
  }
  if (!options_.adaptive_noise.sensors) return;
  setup.filter->set_measurement_noise(measurement_noise());
  if (neighbour_) neighbour_->filter->set_measurement_noise(measurement_noise());
}

/// A second filter that stopped starts again from the estimate: its differences have to grow anew.
void NoiseAdaptation::restart(const FilterSetup& setup) {
  neighbour_->filter->reset({setup.filter->mean(), setup.filter->covariance()});
  neighbour_usable_ = true;
}

void NoiseAdaptation::apply(double factor, FilterSetup& setup) {
  factor_ = factor;
  setup.filter->set_process_noise(process_->at(factor, *setup.augmented_model));
  neighbour_->filter->set_process_noise(process_->at(factor * std::exp(log_ratio), *setup.augmented_model));
}

void NoiseAdaptation::move_to(FilterSetup& setup) {
  if (!neighbour_) return;
  neighbour_ = moved_to(setup.augmented_model, *neighbour_, measurement_noise(), options_);
  apply(factor_, setup);
}

void NoiseAdaptation::widen(Index state, double variance) {
  if (neighbour_) kalfem::widen(*neighbour_, state, variance);
}

NoiseCourse NoiseAdaptation::finish() {
  course_.sensors_adapt = options_.adaptive_noise.sensors;
  course_.density = density_.at_points;
  course_.density_is_stated = states_density(first_);
  course_.sensor_uncertainty = recursion_.sensor_uncertainty();
  course_.process_uncertainty = recursion_.process_uncertainty();
  return std::move(course_);
}

NoiseReplay::NoiseReplay(const AugmentedModel& first, const MatrixXd& stated, const std::optional<NoiseCourse>& course)
    : course_(course) {
  if (!course) return;
  const VectorXd scale = stated.diagonal().cwiseSqrt().cwiseInverse();
  correlation_ = scale.asDiagonal() * stated * scale.asDiagonal();
  if (course->process_factor.size() == 0) return;
  const VectorXd density = states_density(first) ? first.options().process_noise.acceleration
                                                 : VectorXd(course->density * unit_density(first));
  process_.emplace(first, density);
}

void NoiseReplay::before_prediction(Index k, FilterSetup& setup) {
  if (!process_ || (set_ == &setup && factor_ == course_->process_factor[k])) return;
  set_ = &setup;
  factor_ = course_->process_factor[k];
  setup.filter->set_process_noise(process_->at(factor_, *setup.augmented_model));
}

void NoiseReplay::before_update(Index k, FilterSetup& setup) const {
  if (!course_) return;
  const auto deviation = course_->sensors.col(k).asDiagonal();
  setup.filter->set_measurement_noise(deviation * correlation_ * deviation);
}

}  // namespace kalfem
