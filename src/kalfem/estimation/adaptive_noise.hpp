// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/estimation/filter.hpp"

namespace kalfem {

/// Noise that a filter finds along the record.
struct AdaptiveNoiseOptions {
  bool sensors = false;  ///< R, sensor by sensor
  bool process = false;  ///< a factor on the densities of the white accelerations
  double memory = 2.0;   ///< [s] > 0: a sample of that age counts e times less than the present one

  [[nodiscard]] bool any() const { return sensors || process; }
};

/// Recursive estimates of measurement noise and process noise from a filter's innovations v ~ N(0, S): the recursive
/// prediction error method [LS83] on the logarithms theta of R's variances and of the process noise's factor, with
/// exponential forgetting a = 1 - exp(-step / memory) a sample. With S_i = dS / d theta_i and v_i = dv / d theta_i,
///     g_i  = 1/2 [v^T S^-1 S_i S^-1 v - tr(S^-1 S_i)] - v^T S^-1 v_i,
///     J_ij <- (1 - a) J_ij + 1/2 tr(S^-1 S_i S^-1 S_j) + v_i^T S^-1 v_j / max(1, v^T S^-1 v / l),
///     theta <- theta + (J + D)^-1 g.
/// g is the likelihood's slope and has no mean where the noise is right, however wrong the derivatives are; J, which
/// joins all of them, only sets the size of a step. D is diagonal: of a sensor memory / 40 of samples, for which the
/// stated noise counts; of the process noise sqrt(J_ii), which bounds its wandering while no sensor sees it. What is
/// learned of a sample holds from the next one on.
///
/// Process noise: S_i and v_i are differences to a second filter with a little more process noise since the start. They
/// hold all that Q has done to S until now, and not only within one step.
/// Sensors: S_j = R_j e_j e_j^T, what R does at once; of one sensor alone the step is that of expectation maximisation
/// [SS82] over the square of its share of S, R_j <- R_j + a [(R S^-1 v)_j^2 - (R S^-1 R)_jj] / (R S^-1)_jj^2. Variances
/// change by factors between 1/2 and 20 a sample, so they stay positive.
class NoiseRecursion {
public:
  /// `noise`: R as stated; `step` between samples [s]; `least_factor` of the process noise, > 0.
  NoiseRecursion(const AdaptiveNoiseOptions& options, Eigen::MatrixXd noise, double step, double least_factor);

  /// `more`: the innovation of the filter whose process noise is exp(log_ratio) times as large; null: there is none.
  /// Samples set aside as outliers do not count, unless that is a quarter of the sensor's recent ones: its noise is
  /// then stated too small. Of such a sample nothing is learned about the process noise. Samples that were to be left
  /// out never count.
  void learn(const Innovation& innovation, const Innovation* more, double log_ratio);

  [[nodiscard]] const Eigen::MatrixXd& measurement_noise() const { return noise_; }  ///< R, l x l
  [[nodiscard]] double process_factor() const;                                       ///< on the covariance
  /// Standard deviation of ln(standard deviation of a sensor), l, and of ln(factor): what the memory allows.
  [[nodiscard]] Eigen::VectorXd sensor_uncertainty() const;
  [[nodiscard]] double process_uncertainty() const;

private:
  void note_set_aside(const Innovation& innovation);
  void learn_gated(const Innovation& innovation);
  [[nodiscard]] bool counts(Eigen::Index channel) const;
  void scale(Eigen::Index channel, double factor);

  AdaptiveNoiseOptions options_;
  double forgetting_, begin_, largest_move_;
  Eigen::MatrixXd noise_;
  Eigen::VectorXd least_noise_;
  Eigen::VectorXd share_;        ///< of a sensor's samples that were set aside of late
  std::vector<bool> set_aside_;  ///< at this sample
  Eigen::MatrixXd information_;  ///< J: sensors, then the process noise
  double log_factor_ = 0.0, least_log_factor_ = 0.0;
};

}  // namespace kalfem
