#include "kalfem/reduction/error_indicators.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/modal_damping.hpp"

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

}  // namespace kalfem
