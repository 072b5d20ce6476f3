// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/frf_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Displacement of a point, and strain at a gauge, per degree of freedom; unknown ones become issues.
class Places {
public:
  explicit Places(const LinearModel& model) : model_(model) {
    for (std::size_t i = 0; i < model.dofs.size(); ++i) places_[model.dofs[i]] = static_cast<Index>(i);
  }

  [[nodiscard]] VectorXd point(const std::string& name, IssueList& issues) const {
    if (const auto point = model_.points.find(name); point != model_.points.end()) return vector(point->second);
    if (places_.contains(name)) return vector({{name, 1.0}});
    issues.add({}, "there is no point '" + name + "'" + did_you_mean(name, names()),
               "an FRF needs degrees of freedom or named points of the model");
    return vector({});
  }

  [[nodiscard]] VectorXd gauge(const std::string& name, IssueList& issues) const {
    if (const auto gauge = model_.gauges.find(name); gauge != model_.gauges.end()) return vector(gauge->second);
    std::vector<std::string> known;
    for (const auto& [each, combination] : model_.gauges) known.push_back(each);
    issues.add({}, "there is no strain gauge '" + name + "'" + did_you_mean(name, known),
               "an FRF of a strain needs a gauge of the model");
    return vector({});
  }

private:
  [[nodiscard]] VectorXd vector(const DofCombination& combination) const {
    VectorXd vector = VectorXd::Zero(model_.size());
    for (const auto& [dof, coefficient] : combination) vector[places_.at(dof)] += coefficient;
    return vector;
  }

  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> known;
    for (const auto& [name, combination] : model_.points) known.push_back(name);
    if (!model_.points_only) known.insert(known.end(), model_.dofs.begin(), model_.dofs.end());
    return known;
  }

  const LinearModel& model_;
  std::map<std::string, Index> places_;
};

const GroundCoupling* find_ground(const LinearModel& model, const std::string& name) {
  const auto found = std::ranges::find(model.grounds, name, &GroundCoupling::ground);
  return found == model.grounds.end() ? nullptr : &*found;
}

void check_ground(const LinearModel& model, const std::string& name, IssueList& issues) {
  std::vector<std::string> known;
  for (const auto& ground : model.grounds) known.push_back(ground.ground);
  const GroundCoupling* ground = find_ground(model, name);
  if (!ground)
    issues.add({}, "there is no ground '" + name + "'" + did_you_mean(name, known),
               "a base-excited FRF needs the ground that moves");
  else if (ground->stiffness.isZero() && ground->damping.isZero())
    issues.add({}, "nothing is attached to the ground '" + name + "'", "its motion would have no effect");
}

}  // namespace

std::string per_input(const FrfSet& set) {
  return (set.input == FrfInput::force ? " per force at " : " per motion of ") + set.place;
}

std::string unit_of(const FrfSet& set) {
  constexpr std::array outputs = {"m", "m/s", "m/s^2", "m/m"};
  const std::string output = outputs[static_cast<std::size_t>(set.quantity)];
  const std::string input = set.input == FrfInput::force                 ? "N"
                            : set.input == FrfInput::ground_displacement ? "m"
                                                                         : "m/s^2";
  const auto in_brackets = [](const std::string& unit) { return unit.size() > 1 ? "(" + unit + ")" : unit; };
  return in_brackets(output) + "/" + in_brackets(input);
}

std::string name_of(ResponseQuantity quantity) {
  constexpr std::array names = {"displacement", "velocity", "acceleration", "strain"};
  return names[static_cast<std::size_t>(quantity)];
}

int derivative_order(const FrfSet& set) {
  const int of_output = set.quantity == ResponseQuantity::strain ? 0 : static_cast<int>(set.quantity);
  return of_output - (set.input == FrfInput::ground_acceleration ? 2 : 0);
}

FrfPlaces places_of(const FrfSet& set, const LinearModel& model, IssueList& issues) {
  const Places of(model);
  FrfPlaces places;
  if (set.input == FrfInput::force)
    places.force = of.point(set.place, issues);
  else
    check_ground(model, set.place, issues);
  places.outputs.resize(model.size(), std::ssize(set.outputs));
  for (Index j = 0; j < places.outputs.cols(); ++j) {
    const std::string& output = set.outputs[static_cast<std::size_t>(j)];
    places.outputs.col(j) =
        set.quantity == ResponseQuantity::strain ? of.gauge(output, issues) : of.point(output, issues);
  }
  return places;
}

InvalidInput singular_at(double frequency) {
  const bool is_static = frequency == 0.0;
  return InvalidInput(
      fmt::format("the equations of motion are singular at {:.6g} Hz", frequency),
      is_static ? "the structure can move as a rigid body, so it has no static response"
                : "an undamped mode resonates there: its response is infinite",
      is_static ? "begin above 0 Hz or support the structure" : "give the structure damping or choose other lines");
}

const GroundCoupling& ground_of(const LinearModel& model, const std::string& name) { return *find_ground(model, name); }

}  // namespace kalfem
