// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "kalfem/estimation/adaptive_noise.hpp"
#include "kalfem/estimation/estimate.hpp"
#include "kalfem/estimation/filter_setup.hpp"

namespace kalfem {

/// Process noise of which one part, white accelerations, has a factor.
class ScaledProcessNoise {
public:
  /// `density`: of the accelerations at factor one [m/s^2/sqrt(Hz)], one per degree of freedom of the first model.
  ScaledProcessNoise(const AugmentedModel& first, const Eigen::VectorXd& density);
  /// Q in the coordinates of the first model, or of one that has been linearised elsewhere.
  [[nodiscard]] Eigen::MatrixXd at(double factor, const AugmentedModel& model) const;

private:
  const AugmentedModel& first_;
  Eigen::MatrixXd others_, scaled_;
};

/// The densities at factor one, and what a sensor can see of them.
struct AdaptiveDensity {
  Eigen::VectorXd on_dofs;    ///< [m/s^2/sqrt(Hz)]
  double at_points = 0.0;     ///< the largest, at a point of the structure [m/s^2/sqrt(Hz)]
  double least_factor = 1.0;  ///< below it no sensor would see it
};

/// The stated densities. Where all are zero, the density of which `horizon` seconds show as a thousandth of a sensor's
/// variance, so that it can grow. `setup`: about the first model, with the inputs of the first sample.
AdaptiveDensity adaptive_density(const AugmentedModel& first, const Eigen::MatrixXd& noise, const Gaussian& prior,
                                 FilterSetup& setup, double horizon);

/// Adapts the noise of a filter along a record: NoiseRecursion, with the second filter that the process noise needs. It
/// doubles the cost of a run; the noise of sensors alone costs nothing.
class NoiseAdaptation {
public:
  /// `setup`: that of the run, about the first model.
  NoiseAdaptation(const AugmentedModel& first, const FilterInput& input, const EstimationOptions& options,
                  const Gaussian& prior, FilterSetup& setup);

  /// The second filter's way to sample k; before that of the run.
  void predict_to(Eigen::Index k);
  /// Stores the noise with which the update at sample k was made, and gives the filter that of the next one.
  void learn(Eigen::Index k, const Innovation& innovation, FilterSetup& setup);
  /// To the model that `setup` has been linearised about.
  void move_to(FilterSetup& setup);
  /// Widens an unknown as in the run.
  void widen(Eigen::Index state, double variance);

  [[nodiscard]] const Eigen::MatrixXd& measurement_noise() const { return recursion_.measurement_noise(); }
  [[nodiscard]] NoiseCourse finish();

private:
  void restart(const FilterSetup& setup);
  void apply(double factor, FilterSetup& setup);

  const AugmentedModel& first_;
  const FilterInput& input_;
  EstimationOptions options_;
  AdaptiveDensity density_;
  std::optional<ScaledProcessNoise> process_;
  NoiseRecursion recursion_;
  std::unique_ptr<FilterSetup> neighbour_;
  bool neighbour_usable_ = true;
  double factor_ = 1.0;  ///< in force
  Innovation innovation_;
  Eigen::VectorXd measured_;
  NoiseCourse course_;
};

/// Gives the filter the noise with which a run predicted to, or updated at, sample k.
class NoiseReplay {
public:
  /// `course`: of the run; the noise as stated where there is none.
  NoiseReplay(const AugmentedModel& first, const Eigen::MatrixXd& stated, const std::optional<NoiseCourse>& course);
  /// A setup has been made anew.
  void forget_setup() { set_ = nullptr; }
  void before_prediction(Eigen::Index k, FilterSetup& setup);
  void before_update(Eigen::Index k, FilterSetup& setup) const;

private:
  const std::optional<NoiseCourse>& course_;
  Eigen::MatrixXd correlation_;
  std::optional<ScaledProcessNoise> process_;
  const FilterSetup* set_ = nullptr;  ///< whose filter has the factor below
  double factor_ = 0.0;
};

}  // namespace kalfem
