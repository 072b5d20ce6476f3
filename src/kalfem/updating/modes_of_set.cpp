// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/modes_of_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/modal/real_shape.hpp"

namespace kalfem {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double default_deviation = 0.01, default_shape_deviation = 0.05, default_damping_deviation = 0.1;

double deviation_of(double value, double own, std::optional<double> given, double otherwise) {
  if (given) return *given * value;
  return std::isfinite(own) ? own : otherwise * value;
}

MatrixXd shrunk(MatrixXd covariance, double degrees_of_freedom) {
  if (!std::isfinite(degrees_of_freedom)) return covariance;
  const double share = std::min(1.0, static_cast<double>(covariance.rows() + 1) / degrees_of_freedom);
  const VectorXd diagonal = covariance.diagonal();
  covariance *= 1.0 - share;
  covariance.diagonal() = diagonal;
  return covariance;
}

void take_shape(const ModeSet::Mode& mode, const ModeSetOptions& options, const std::string& name,
                MeasuredMode& measured, IssueList& issues) {
  const auto real = real_shape(mode.shape, mode.shape_covariance);
  if (real.complexity > options.max_complexity)
    issues.add(
        {}, fmt::format("the shape of {} is complex: {:.2g} % of it are out of phase", name, 100 * real.complexity),
        fmt::format("a shape of the model is real; at most {:.2g} % are turned away", 100 * options.max_complexity),
        "look for close modes, a wandering clock or local damping; compare its frequency alone, or allow more "
        "(max_complexity)");
  if (!(real.values.array().isFinite() && real.values.array() != 0.0).any()) return;
  measured.shape = real.values;
  measured.complexity = real.complexity;
  measured.shape_deviation = options.shape_deviation.value_or(default_shape_deviation);
  if (!options.shape_deviation && real.covariance.size() > 0)
    measured.shape_covariance = shrunk(real.covariance, mode.degrees_of_freedom);
}

}  // namespace

std::vector<MeasuredMode> modes_of_set(const ModeSet& set, const ModeSetOptions& options) {
  std::vector<MeasuredMode> all;
  IssueList issues;
  for (std::size_t i = 0; i < set.modes.size(); ++i) {
    const auto& mode = set.modes[i];
    const std::string name = named_mode(i, mode.frequency);
    if (!(mode.frequency > 0.0) || !std::isfinite(mode.frequency))
      issues.add({}, fmt::format("measured mode {} has no frequency", i + 1), "it is compared by it", "leave it out");
    MeasuredMode measured{
        .frequency = mode.frequency,
        .deviation = deviation_of(mode.frequency, mode.frequency_std, options.deviation, default_deviation)};
    if (options.dampings) {
      if (!(mode.damping > 0.0) || !std::isfinite(mode.damping))
        issues.add({}, name + " has no damping", "the dampings are compared", "leave the mode out, or the dampings");
      measured.damping = mode.damping;
      measured.damping_deviation =
          deviation_of(mode.damping, mode.damping_std, options.damping_deviation, default_damping_deviation);
    }
    if (!set.points.empty()) take_shape(mode, options, name, measured, issues);
    all.push_back(std::move(measured));
  }
  issues.raise();
  return all;
}

}  // namespace kalfem
