// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/modes_at_points.hpp"

#include <algorithm>

#include "kalfem/base/units.hpp"
#include "kalfem/updating/modes_of_set.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

std::vector<MeasuredMode> frequencies_of(const std::vector<MeasuredFrequency>& given) {
  std::vector<MeasuredMode> modes;
  IssueList issues;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const auto& [frequency, std, mode] = given[i];
    if (!(frequency > 0.0) || !(std > 0.0))
      issues.add({},
                 "frequencies[" + std::to_string(i) + "]: " + shortest(frequency) +
                     " Hz with a standard deviation of " + shortest(std) + " Hz",
                 "both must be > 0", "");
    modes.push_back({.frequency = frequency, .deviation = std, .model_mode = mode});
  }
  if (given.empty()) issues.add({}, "frequencies: the list is empty", "there is nothing to compare with", "");
  issues.raise();
  return modes;
}

void add_shapes(const MeasuredModes& given, const LinearModel& model, std::vector<MeasuredMode>& modes,
                std::vector<DofCombination>& points) {
  if (given.shapes.rows() != std::ssize(given.points) || given.shapes.cols() != std::ssize(modes))
    throw InvalidInput("shapes: " + std::to_string(given.shapes.rows()) + " x " + std::to_string(given.shapes.cols()) +
                           " values, but there are " + std::to_string(given.points.size()) + " points and " +
                           std::to_string(modes.size()) + " frequencies",
                       "each mode is a column", "give one row per point and one column per frequency");
  if (!(given.shape_std > 0.0))
    throw InvalidInput("shape_std: it is " + shortest(given.shape_std), "it must be > 0", "");
  if (given.shape_stds.size() > 0 &&
      (given.shape_stds.rows() != given.shapes.rows() || given.shape_stds.cols() != given.shapes.cols()))
    throw InvalidInput("shape_stds: they are not as many as the entries of the shapes", "each entry has its own", "");
  if (!given.shape_covariances.empty() && given.shape_covariances.size() != modes.size())
    throw InvalidInput("shape_covariances: there are " + std::to_string(given.shape_covariances.size()),
                       "each frequency has one", "");
  IssueList issues;
  for (const auto& point : given.points) try {
      points.push_back(combination_of(model, point_in(given.substructure, point)));
    } catch (const InvalidInput& error) {
      issues.add(error, {});
    }
  issues.raise();
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (given.shapes.col(static_cast<Index>(i)).array().isNaN().all()) continue;  // its frequency alone was measured
    modes[i].shape = given.shapes.col(static_cast<Index>(i));
    modes[i].shape_deviation = given.shape_std;
    if (given.shape_stds.size() > 0) modes[i].shape_deviations = given.shape_stds.col(static_cast<Index>(i));
    if (!given.shape_covariances.empty()) modes[i].shape_covariance = given.shape_covariances[i];
  }
}

void add_dampings(const MeasuredModes& given, std::vector<MeasuredMode>& modes) {
  if (given.dampings.size() != modes.size() || given.damping_stds.size() != modes.size())
    throw InvalidInput("dampings: " + std::to_string(given.dampings.size()) + " ratios with " +
                           std::to_string(given.damping_stds.size()) + " standard deviations, but there are " +
                           std::to_string(modes.size()) + " frequencies",
                       "each mode has its own", "give one of each per frequency");
  for (std::size_t i = 0; i < modes.size(); ++i) {
    modes[i].damping = given.dampings[i];
    modes[i].damping_deviation = given.damping_stds[i];
  }
}

}  // namespace

std::pair<std::string, std::string> split_point(const std::string& point) {
  const auto dot = point.find('.');
  if (dot == std::string::npos)
    throw InvalidInput("'" + point + "' names no substructure", "points are qualified",
                       "write substructure.point, such as body.1 or frame.tip.z");
  return {point.substr(0, dot), point.substr(dot + 1)};
}

std::string point_in(const std::string& substructure, const std::string& point) {
  const auto [owner, name] = split_point(point);
  if (owner != substructure)
    throw InvalidInput("'" + point + "' is not a point of '" + substructure + "'",
                       "a comparison is of one substructure without connectors", "make a comparison of each");
  return name;
}

DofCombination combination_of(const LinearModel& model, const std::string& point) {
  if (const auto named = model.points.find(point); named != model.points.end()) return named->second;
  if (std::ranges::find(model.dofs, point) != model.dofs.end()) return {{point, 1.0}};
  std::vector<std::string> known;
  for (const auto& [each, combination] : model.points) known.push_back(each);
  if (!model.points_only) known.insert(known.end(), model.dofs.begin(), model.dofs.end());
  throw InvalidInput("there is no point '" + point + "'" + did_you_mean(point, known), "", "");
}

ModesAtPoints modes_at_points(const MeasuredModes& given, const LinearModel& model) {
  ModesAtPoints measured{frequencies_of(given.frequencies), {}};
  if (given.shapes.size() > 0 || !given.points.empty()) add_shapes(given, model, measured.modes, measured.points);
  if (!given.dampings.empty()) add_dampings(given, measured.modes);
  return measured;
}

MeasuredModes measured_modes(const ModeSet& set, const std::string& substructure,
                             const std::vector<std::pair<std::string, std::string>>& points,
                             const ModeSetOptions& options) {
  MeasuredModes measured{.substructure = substructure, .frequencies = {}};
  std::vector<std::string> names;
  for (const auto& [point, name] : points) {
    measured.points.push_back(point);
    names.push_back(name);
  }
  const auto modes = modes_of_set(at_points(set, names), options);
  measured.sensors = std::move(names);
  measured.shape_std = options.shape_deviation.value_or(measured.shape_std);
  if (!points.empty())
    measured.shapes = Eigen::MatrixXd::Constant(std::ssize(points), std::ssize(modes), ModeSet::unknown);
  for (std::size_t i = 0; i < modes.size(); ++i) {
    measured.frequencies.push_back({modes[i].frequency, modes[i].deviation});
    if (modes[i].shape.size() > 0) measured.shapes.col(static_cast<Index>(i)) = modes[i].shape;
    measured.shape_covariances.push_back(modes[i].shape_covariance);
    if (!modes[i].damping) continue;
    measured.dampings.push_back(*modes[i].damping);
    measured.damping_stds.push_back(modes[i].damping_deviation);
  }
  if (std::ranges::all_of(modes, [](const auto& mode) { return mode.shape_covariance.size() == 0; }))
    measured.shape_covariances.clear();
  return measured;
}

}  // namespace kalfem
