// SPDX-License-Identifier: Apache-2.0
#include "correlation/planted_mistakes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kalfem::test {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr int modes_measured = 10;
constexpr double stiffness_off = 0.1, noise = 0.02, least_motion = 0.1;

std::string node_of(const std::string& dof) { return dof.substr(0, dof.rfind('.')); }
std::string axis_of(const std::string& dof) { return dof.substr(dof.rfind('.') + 1); }

bool names(const SetupMistake& mistake, const std::string& sensor) {
  return std::ranges::find(mistake.sensors, sensor) != mistake.sensors.end();
}

/// A mistake, with the sensors that are wrong by it.
struct Planted {
  MistakeKind kind;
  std::vector<Index> sensors;
};

Planted plant(ModalTest& test, int seed) {
  const auto count = static_cast<int>(test.rows.size());
  const Index sensor = test.any(count);
  const auto node = test.sensors_of_node(sensor);
  switch (seed % 4) {
    case 0:
      test.measured.row(sensor) *= -1.0;
      return {MistakeKind::turned, {sensor}};
    case 1: {
      const Index other = (sensor + 1 + test.any(count - 1)) % count;
      test.measured.row(sensor).swap(test.measured.row(other));
      return {MistakeKind::swapped, {sensor, other}};
    }
    case 2: {
      const std::string& own = test.sensors[static_cast<std::size_t>(sensor)].place;
      std::vector<Index> others;
      for (const Index dof : test.candidates)
        if (const auto& name = test.model.dofs[static_cast<std::size_t>(dof)];
            axis_of(name) == axis_of(own) && node_of(name) != node_of(own))
          others.push_back(dof);
      test.measured.row(sensor) =
          test.truth.shapes.row(others[static_cast<std::size_t>(test.any(static_cast<int>(others.size())))]);
      return {MistakeKind::node, {sensor}};
    }
    default:
      break;
  }
  if (node.size() < 2) {  // no other axis: turned again
    test.measured.row(sensor) *= -1.0;
    return {MistakeKind::turned, {sensor}};
  }
  const double angle = 0.5 * M_PI * (1 + test.any(3));
  MatrixXd turn = Eigen::Rotation2Dd(angle).toRotationMatrix();
  if (node.size() == 3) turn = Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(test.any(3))).toRotationMatrix();
  test.measured(node, Eigen::all) = (turn * test.measured(node, Eigen::all)).eval();
  return {MistakeKind::rotated, node};
}

}  // namespace

ModalTest::ModalTest(const TestedStructure& structure, int nodes, unsigned seed) : random(seed) {
  std::uniform_real_distribution<double> off(1.0 - stiffness_off, 1.0 + stiffness_off);
  std::vector<double> factors(structure.members.size());
  for (auto& factor : factors) factor = off(random);
  model = structure.model();
  truth = lowest_normal_modes(structure.model(factors), {.count = modes_measured});
  std::vector<Index> possible;
  for (std::size_t i = 0; i < model.dofs.size(); ++i)
    if (std::ranges::find(structure.axes, axis_of(model.dofs[i])) != structure.axes.end())
      possible.push_back(static_cast<Index>(i));
  const MatrixXd motions = lowest_normal_modes(model, {.count = modes_measured}).shapes(possible, Eigen::all);
  const Eigen::VectorXd size = motions.colwise().normalized().rowwise().norm();
  for (Index i = 0; i < size.size(); ++i)
    if (size[i] >= least_motion * size.maxCoeff()) candidates.push_back(possible[static_cast<std::size_t>(i)]);
  std::vector<std::string> places;
  for (const Index dof : candidates)
    if (const auto node = node_of(model.dofs[static_cast<std::size_t>(dof)]); places.empty() || places.back() != node)
      places.push_back(node);
  std::ranges::shuffle(places, random);
  places.resize(std::min(places.size(), static_cast<std::size_t>(nodes)));
  for (const auto& place : places)
    for (const Index dof : candidates)
      if (const auto& name = model.dofs[static_cast<std::size_t>(dof)]; node_of(name) == place) {
        rows.push_back(dof);
        sensors.push_back({"a" + std::to_string(rows.size()), name});
      }
  measured = truth.shapes(rows, Eigen::all);
}

std::vector<Index> ModalTest::sensors_of_node(Index sensor) const {
  std::vector<Index> all;
  const auto node = node_of(sensors[static_cast<std::size_t>(sensor)].place);
  for (std::size_t i = 0; i < sensors.size(); ++i)
    if (node_of(sensors[i].place) == node) all.push_back(static_cast<Index>(i));
  return all;
}

Correlation ModalTest::correlated() {
  std::normal_distribution<double> normal;
  std::vector<MeasuredMode> modes;
  for (Index i = 0; i < measured.cols(); ++i) {
    Eigen::VectorXd shape = measured.col(i);
    const double size = noise * shape.cwiseAbs().maxCoeff();
    for (auto& entry : shape) entry += size * normal(random);
    modes.push_back({.frequency = truth.frequencies[i], .deviation = 1.0, .shape = shape});
  }
  std::vector<DofCombination> points;
  for (const auto& sensor : sensors) points.push_back({{sensor.place, 1.0}});
  return correlate(modes, points, sensors, model);
}

void plant_mistakes(const TestedStructure& structure, int nodes, int first, int count, MistakeTally& tally) {
  for (int seed = first; seed < first + count; ++seed) {
    ModalTest test(structure, nodes, static_cast<unsigned>(seed));
    const auto planted = plant(test, seed);
    const auto found = test.correlated().mistakes;
    const std::string kind(word_of(planted.kind));
    ++tally.tests;
    ++tally.planted[kind];
    if (found.empty() || std::ranges::none_of(planted.sensors, [&](Index sensor) {
          return names(found[0], test.sensors[static_cast<std::size_t>(sensor)].name);
        })) {
      tally.misled += !found.empty();
      continue;
    }
    ++tally.right;
    ++tally.named[kind];
    tally.with_cause[kind] += found[0].kind == planted.kind;
  }
}

void count_alarms(const TestedStructure& structure, int nodes, int first, int count, MistakeTally& tally) {
  for (int seed = first; seed < first + count; ++seed) {
    ++tally.set_ups;
    tally.alarms += !ModalTest(structure, nodes, static_cast<unsigned>(1000 + seed)).correlated().mistakes.empty();
  }
}

std::string in_words(const MistakeTally& tally) {
  std::string text;
  for (const auto& [kind, count] : tally.planted) {
    const auto of = [&](const std::map<std::string, int>& all) { return all.contains(kind) ? all.at(kind) : 0; };
    text += fmt::format("{}{}: named first in {} of {}, with its cause in {}", text.empty() ? "" : "; ", kind,
                        of(tally.named), count, of(tally.with_cause));
  }
  if (tally.tests > 0) text += fmt::format("; others named in {} of {}", tally.misled, tally.tests);
  if (tally.set_ups > 0)
    text += fmt::format("{}alarms in {} of {} right set-ups", text.empty() ? "" : "; ", tally.alarms, tally.set_ups);
  return text;
}

}  // namespace kalfem::test
