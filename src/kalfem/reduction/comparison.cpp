// SPDX-License-Identifier: Apache-2.0
#include "kalfem/reduction/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/reduction/combinations.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double same_frequency = 1e-3;
constexpr double rounding_of_frequency = 1e-6;

double frequency(double value) { return std::sqrt(std::max(value, 0.0)) / (2.0 * std::numbers::pi); }

/// Part of a shape by mass in the span of the recovered shapes with the same frequency as the one at `place`.
double captured(const VectorXd& momentum, const MatrixXd& shapes, const VectorXd& values, Index place) {
  double part = 0.0;
  for (Index j = 0; j < values.size(); ++j)
    if (std::abs(frequency(values[j]) - frequency(values[place])) <= same_frequency * frequency(values[place]))
      part += std::pow(momentum.dot(shapes.col(j)), 2);
  return std::min(part, 1.0);
}

/// |K phi - lambda M phi| / |K phi| of the leading shapes; 0 where lambda is, as that is rounding against rounding.
VectorXd residuals(const LinearModel& full, const Eigen::Ref<const MatrixXd>& shapes, const VectorXd& values) {
  VectorXd sizes = VectorXd::Zero(shapes.cols());
  for (Index j = 0; j < shapes.cols(); ++j) {
    if (values[j] == 0.0) continue;
    const VectorXd force = full.stiffness * shapes.col(j);
    sizes[j] = (force - values[j] * (full.mass * shapes.col(j))).norm() / force.norm();
  }
  return sizes;
}

/// Band of all kept modes, or below the first left out where none is kept [Hz].
double band_of(const ReductionErrorIndicators& error_indicators) {
  const double highest = error_indicators.highest_kept;
  return highest > 0.0 ? highest * (1.0 + rounding_of_frequency) : error_indicators.next_left_out;
}

/// Largest difference of a gauge's strains in the full modes from those in the span of the recovered shapes, Phi Phi^T
/// M phi, relative to the gauge's largest strain. `exact`, `shapes`: mass-normalised.
std::map<std::string, double> compare_strains(const LinearModel& full, const MatrixXd& exact, const MatrixXd& shapes) {
  if (full.gauges.empty()) return {};
  const CombinationRows rows(full);
  const MatrixXd missing = exact - shapes * (shapes.transpose() * (full.mass * exact));
  std::map<std::string, double> errors;
  for (const auto& [gauge, combination] : full.gauges) {
    const double largest = rows.value(combination, exact).cwiseAbs().maxCoeff();
    errors[gauge] = largest > 0.0 ? rows.value(combination, missing).cwiseAbs().maxCoeff() / largest : 0.0;
  }
  return errors;
}

}  // namespace

// Each mode of the full model is looked for in the span of the reduced modes of its frequency, recovered by T: modes of
// equal frequency may be any combination of each other, and a single MAC would call a good reduction bad.
void compare_modes(const LinearModel& full, double up_to, Index at_least, const StiffnessFactor* whole,
                   Superelement& element) {
  const Stopwatch watch;
  ReductionErrorIndicators& error_indicators = element.error_indicators;
  const double band = up_to > 0.0 ? up_to : band_of(error_indicators);
  const LinearModel& reduced = element.model;
  element.full_modes = std::make_shared<const NormalModes>(lowest_normal_modes(
      full, {.count = std::max(at_least, reduced.size()), .up_to = band, .at_least = at_least}, whole));
  const NormalModes& exact = *element.full_modes;
  const Index in_band = std::min(reduced.size(), (exact.frequencies.array() <= band).count());
  const Index finite = (reduced.mass.diagonal().array() > 0.0).count();
  // Beyond the band as well, so that each full mode finds its own and those of the same frequency.
  LowestModes own = lowest_modes(reduced.stiffness, reduced.mass, {.count = std::min(finite, in_band + 8)});
  const MatrixXd shapes = element.basis * own.vectors;
  // Small as it is, the reduced stiffness does not show how large the energies are that cancel in a rigid-body mode.
  for (Index i = 0; i < own.values.size() && moves_rigidly(full.stiffness, shapes.col(i)); ++i) own.values[i] = 0.0;
  const Index count = std::min(in_band, own.values.size());
  const VectorXd residual = residuals(full, shapes.leftCols(count), own.values);
  for (Index i = 0; i < count; ++i)
    error_indicators.modes.push_back({.full = exact.frequencies[i],
                                      .reduced = frequency(own.values[i]),
                                      .mac = captured(full.mass * exact.shapes.col(i), shapes, own.values, i),
                                      .residual = residual[i]});
  // The highest kept modes strain otherwise than the full model's in any reduction, far above what sensors see.
  if (const Index lower = std::min(count, (exact.frequencies.array() <= 0.5 * band).count()); lower > 0)
    error_indicators.gauges = compare_strains(full, exact.shapes.leftCols(lower), shapes);
  error_indicators.compare_seconds = watch.seconds();
}

namespace {

constexpr double static_tolerance = 1e-6;
constexpr double frequency_tolerance = 1e-2;
constexpr double least_mac = 0.9;
constexpr double strain_tolerance = 2e-2;

std::string per_cent(double ratio) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g %%", 100.0 * ratio);
  return text;
}

std::string hertz(double frequency) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g Hz", frequency);
  return text;
}

}  // namespace

// Modes left out matter where the excitation or the sensors reach; modes kept, where they are off inside the sensors'
// band.
std::vector<std::string> reduction_warnings(const ReductionErrorIndicators& error_indicators, double excitation_band,
                                            double sensor_bandwidth) {
  std::vector<std::string> warnings;
  const double left_out = error_indicators.next_left_out;
  if (left_out > 0.0 && left_out < excitation_band)
    warnings.push_back("the first mode left out, at " + hertz(left_out) + ", is inside the band of the excitation" +
                       (std::isfinite(excitation_band) ? ", " + hertz(excitation_band) : "") +
                       ": the excitation causes motion that the reduced model cannot represent");
  if (left_out > 0.0 && std::isfinite(sensor_bandwidth) && left_out < 3.0 * sensor_bandwidth)
    warnings.push_back("the kept modes end below " + hertz(left_out) + ", less than three times the sensors' " +
                       "bandwidth of " + hertz(sensor_bandwidth) + ": keep modes up to " +
                       hertz(3.0 * sensor_bandwidth) + ", better up to " + hertz(6.0 * sensor_bandwidth));
  for (const auto& mode : error_indicators.modes) {
    if (mode.full > sensor_bandwidth) break;
    const bool frequency_off = mode.reduced - mode.full > frequency_tolerance * mode.full;
    if (!frequency_off && mode.mac >= least_mac) continue;
    char mac[16];
    std::snprintf(mac, sizeof mac, "%.2f", mode.mac);
    warnings.push_back("the mode of the full model at " + hertz(mode.full) + ", inside the sensors' bandwidth, is at " +
                       hertz(mode.reduced) + " in the reduced model, with a MAC of " + mac +
                       ": keep more modes or add boundary nodes");
  }
  for (const auto& [gauge, error] : error_indicators.gauges)
    if (error > strain_tolerance)
      warnings.push_back("the reduced model is off by up to " + per_cent(error) + " in the strain at gauge '" + gauge +
                         "', and the strain's band does not include that: keep more modes");
  if (error_indicators.static_error > static_tolerance)
    warnings.push_back("the constraint modes leave " + std::to_string(error_indicators.static_error) +
                       " of the boundary forces unbalanced: the stiffness of the interior is almost singular");
  return warnings;
}

}  // namespace kalfem
