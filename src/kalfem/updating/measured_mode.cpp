// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/measured_mode.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

std::string number(double value) { return fmt::format("{:.4g}", value); }

void check_deviations(const std::string& name, const MeasuredMode& mode, IssueList& issues) {
  const Index points = mode.shape.size();
  const auto measured = mode.shape.array().isFinite();
  if (mode.shape_covariance.size() > 0) {
    const VectorXd variances = mode.shape_covariance.diagonal();
    if (mode.shape_covariance.rows() != points || mode.shape_covariance.cols() != points)
      issues.add({},
                 "the covariance of the shape of " + name + " is not " + std::to_string(points) + " x " +
                     std::to_string(points),
                 "it is of all entries", "");
    else if ((measured && !(variances.array() >= 0.0)).any() || !((measured && variances.array() > 0.0).any()))
      issues.add({}, "the covariance of the shape of " + name + " has no positive variances", "", "");
  } else if (mode.shape_deviations.size() > 0) {
    if (mode.shape_deviations.size() != points)
      issues.add(
          {}, "the shape of " + name + " has " + std::to_string(mode.shape_deviations.size()) + " standard deviations",
          "it has " + std::to_string(points) + " entries", "give one an entry");
    else if ((measured && !(mode.shape_deviations.array() > 0.0)).any())
      issues.add({}, "a standard deviation of the shape of " + name + " is not positive",
                 "every measured entry has an error", "give a positive one, or leave the entry out");
  } else if (!(mode.shape_deviation > 0.0)) {
    issues.add({}, "the standard deviation of the shape of " + name + " is " + number(mode.shape_deviation),
               "it must be positive", "give it relative to the largest entry: 0.02 for 2 %");
  }
}

void check_shape(const std::string& name, const MeasuredMode& mode, std::size_t points, IssueList& issues) {
  if (mode.shape.size() != static_cast<Index>(points))
    issues.add({}, name + " has a shape of " + std::to_string(mode.shape.size()) + " entries",
               "there are " + std::to_string(points) + " measured points", "give one entry per point");
  else if (!(largest_entry(mode.shape) > 0.0))
    issues.add({}, name + " has a shape without an entry that was measured and moves");
  else
    check_deviations(name, mode, issues);
}

void check_damping(const std::string& name, const MeasuredMode& mode, IssueList& issues) {
  if (!(*mode.damping >= 0.0) || !(*mode.damping < 1.0))
    issues.add({}, "the damping ratio of " + name + " is " + number(*mode.damping), "it lies between 0 and 1", "");
  if (!(mode.damping_deviation > 0.0))
    issues.add({}, "the standard deviation of the damping of " + name + " is " + number(mode.damping_deviation),
               "it must be positive", "give the accuracy of the measurement, such as 10 % of the damping");
}

}  // namespace

std::string named_mode(std::size_t position, double frequency) {
  return fmt::format("measured mode {} ({:.4g} Hz)", position + 1, frequency);
}

double largest_entry(const VectorXd& shape) {
  double largest = 0.0;
  for (const double entry : shape)
    if (std::isfinite(entry)) largest = std::max(largest, std::abs(entry));
  return largest;
}

void check_modes(const std::vector<MeasuredMode>& measured, std::size_t points, IssueList& issues) {
  std::set<int> numbers;
  if (measured.empty()) issues.add({}, "there are no measured modes", "a modal residual needs at least one");
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const MeasuredMode& mode = measured[i];
    const std::string name = named_mode(i, mode.frequency);
    if (!(mode.frequency > 0.0) || !std::isfinite(mode.frequency))
      issues.add({}, "the frequency of " + name + " is not a positive number");
    if (!(mode.deviation > 0.0))
      issues.add({}, "the standard deviation of " + name + " is " + number(mode.deviation) + " Hz",
                 "it must be positive", "give the accuracy of the measurement, such as 0.5 % of the frequency");
    if (mode.model_mode && *mode.model_mode < 1)
      issues.add({}, name + " refers to model mode " + std::to_string(*mode.model_mode),
                 "elastic modes are numbered from 1");
    if (mode.model_mode && !numbers.insert(*mode.model_mode).second)
      issues.add({},
                 name + " refers to model mode " + std::to_string(*mode.model_mode) + ", as another measured mode does",
                 "a model mode can pair with only one measured mode");
    if (mode.shape.size() > 0) check_shape(name, mode, points, issues);
    if (mode.damping) check_damping(name, mode, issues);
  }
}

}  // namespace kalfem
