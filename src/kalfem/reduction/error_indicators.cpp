#include "kalfem/reduction/error_indicators.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/modal_damping.hpp"
#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double same_frequency = 1e-3;

double frequency(double value) { return std::sqrt(std::max(value, 0.0)) / (2.0 * std::numbers::pi); }

/// Part of a shape by mass in the span of the recovered shapes with the same frequency as the one at `place`.
double captured(const VectorXd& momentum, const MatrixXd& shapes, const VectorXd& values, Index place) {
  double part = 0.0;
  for (Index j = 0; j < values.size(); ++j)
    if (std::abs(frequency(values[j]) - frequency(values[place])) <= same_frequency * frequency(values[place]))
      part += std::pow(momentum.dot(shapes.col(j)), 2);
  return std::min(part, 1.0);
}

double residual(const LinearModel& full, const VectorXd& shape, double value) {
  if (value == 0.0) return 0.0;  // rounding against rounding
  const VectorXd elastic = full.stiffness * shape;
  return (elastic - value * (full.mass * shape)).norm() / elastic.norm();
}

}  // namespace

std::vector<ModeComparison> compare_modes(const LinearModel& full, const LinearModel& reduced, const MatrixXd& basis,
                                          double up_to) {
  const NormalModes exact = lowest_normal_modes(full, reduced.size(), up_to);
  const Index finite = (reduced.mass.diagonal().array() > 0.0).count();
  // Beyond the band as well, so that each full mode finds its own and those of the same frequency.
  LowestModes own =
      lowest_modes(reduced.stiffness, reduced.mass, {.count = std::min(finite, exact.frequencies.size() + 8)});
  const MatrixXd shapes = basis * own.vectors;
  // Small as it is, the reduced stiffness does not show how large the energies are that cancel in a rigid-body mode.
  for (Index i = 0; i < own.values.size() && moves_rigidly(full.stiffness, shapes.col(i)); ++i) own.values[i] = 0.0;
  std::vector<ModeComparison> modes;
  for (Index i = 0; i < std::min(exact.frequencies.size(), own.values.size()); ++i)
    modes.push_back({.full = exact.frequencies[i],
                     .reduced = frequency(own.values[i]),
                     .mac = captured(full.mass * exact.shapes.col(i), shapes, own.values, i),
                     .residual = residual(full, shapes.col(i), own.values[i])});
  return modes;
}

namespace {

constexpr double static_tolerance = 1e-6;
constexpr double frequency_tolerance = 1e-2;
constexpr double least_mac = 0.9;

std::string hertz(double frequency) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g Hz", frequency);
  return text;
}

}  // namespace

std::vector<std::string> reduction_warnings(const ReductionErrorIndicators& error_indicators, double excitation_band,
                                            double sensor_bandwidth) {
  std::vector<std::string> warnings;
  const double left_out = error_indicators.next_left_out;
  if (left_out > 0.0 && left_out < excitation_band)
    warnings.push_back("the first mode left out, at " + hertz(left_out) + ", is inside the band of the excitation, " +
                       hertz(excitation_band) +
                       ": the excitation causes motion that the reduced model cannot represent");
  if (left_out > 0.0 && left_out < 3.0 * sensor_bandwidth)
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
  if (error_indicators.static_error > static_tolerance)
    warnings.push_back("the constraint modes leave " + std::to_string(error_indicators.static_error) +
                       " of the boundary forces unbalanced: the stiffness of the interior is almost singular");
  return warnings;
}

}  // namespace kalfem
