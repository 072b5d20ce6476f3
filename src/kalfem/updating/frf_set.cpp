#include "kalfem/updating/frf_set.hpp"

#include <algorithm>
#include <map>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Displacement of a point per degree of freedom; unknown ones become issues.
class Points {
public:
  explicit Points(const LinearModel& model) : model_(model) {
    for (std::size_t i = 0; i < model.dofs.size(); ++i) places_[model.dofs[i]] = static_cast<Index>(i);
  }

  [[nodiscard]] VectorXd vector(const std::string& name, IssueList& issues) const {
    VectorXd vector = VectorXd::Zero(model_.size());
    if (const auto point = model_.points.find(name); point != model_.points.end())
      for (const auto& [dof, coefficient] : point->second) vector[places_.at(dof)] += coefficient;
    else if (const auto dof = places_.find(name); dof != places_.end())
      vector[dof->second] = 1.0;
    else
      issues.add({}, "there is no point '" + name + "'" + did_you_mean(name, names()),
                 "an FRF needs degrees of freedom or named points of the model");
    return vector;
  }

private:
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
  const std::string output = set.quantity == ResponseQuantity::displacement ? "m"
                             : set.quantity == ResponseQuantity::velocity   ? "m/s"
                                                                            : "m/s^2";
  const std::string input = set.input == FrfInput::force                 ? "N"
                            : set.input == FrfInput::ground_displacement ? "m"
                                                                         : "m/s^2";
  const auto in_brackets = [](const std::string& unit) { return unit.size() > 1 ? "(" + unit + ")" : unit; };
  return in_brackets(output) + "/" + in_brackets(input);
}

std::string name_of(ResponseQuantity quantity) {
  return quantity == ResponseQuantity::displacement ? "displacement"
         : quantity == ResponseQuantity::velocity   ? "velocity"
                                                    : "acceleration";
}

int derivative_order(const FrfSet& set) {
  return static_cast<int>(set.quantity) - (set.input == FrfInput::ground_acceleration ? 2 : 0);
}

FrfPlaces places_of(const FrfSet& set, const LinearModel& model, IssueList& issues) {
  const Points points(model);
  FrfPlaces places;
  if (set.input == FrfInput::force)
    places.force = points.vector(set.place, issues);
  else
    check_ground(model, set.place, issues);
  places.outputs.resize(model.size(), std::ssize(set.outputs));
  for (Index j = 0; j < places.outputs.cols(); ++j)
    places.outputs.col(j) = points.vector(set.outputs[static_cast<std::size_t>(j)], issues);
  return places;
}

const GroundCoupling& ground_of(const LinearModel& model, const std::string& name) { return *find_ground(model, name); }

}  // namespace kalfem
