// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/local_model.hpp"

#include <algorithm>

namespace kalfem {

using Eigen::Index;

namespace {

bool belongs(const std::string& point, const std::set<std::string>& substructures) {
  return substructures.contains(point.substr(0, point.find('.')));
}

LatentProcess process_of(const InterfaceForce& force) {
  return {.order = 1, .correlation_time = force.correlation_time};
}

}  // namespace

LocalModel::LocalModel(const LocalModelOptions& local, StructureParts& parts, IssueList& issues)
    : local_(local), parts_(parts), issues_(issues) {
  for (const auto& name : local.substructures) kept_.insert(name.value);
}

// The order matters. Grounds of dropped substructures are collected before these are removed. Connectors are removed
// last, once all points of the local model are known: kept substructures, kept grounds, and interfaces that move as
// measured.
void LocalModel::apply(AugmentedModelSetup& setup) {
  check_names();
  check_joints();
  const auto grounds = grounds_left_out();
  std::erase_if(parts_.substructures, [&](const auto& part) { return !kept_.contains(part.name); });
  std::erase_if(parts_.finite_elements, [&](const auto& part) { return !kept_.contains(part.name); });
  keep_grounds(grounds);
  std::erase_if(parts_.inputs, [&](auto& input) { return !remains(input); });
  for (const auto& input : parts_.inputs) {
    setup.input_sources.push_back(input.name);
    setup.options.inputs.push_back({});
  }
  for (const auto& [point, interface] : local_.interface) add_interface(point, interface, setup);
  std::erase_if(parts_.connectors, [&](const auto& c) { return !reachable(c.from) || !reachable(c.to); });
}

void LocalModel::set_priors(AugmentedModelSetup& setup) const {
  auto& prior = setup.options.prior;
  auto& noise = setup.options.process_noise.input;
  for (std::size_t i = 0; i < parts_.inputs.size(); ++i) {
    const auto index = static_cast<Index>(i);
    const auto found =
        std::ranges::find_if(local_.interface, [&](const auto& each) { return each.first == parts_.inputs[i].name; });
    if (found == local_.interface.end()) continue;
    if (const auto* measured = std::get_if<InterfaceAcceleration>(&found->second.value.motion)) {
      prior.input_deviation[index] = measured->displacement_std;
      prior.input_rate_deviation[index] = measured->velocity_std;
      noise[index] = 0.0;  // from the sensor's noise, once the record is known
    } else {
      const auto& force = std::get<InterfaceForce>(found->second.value.motion);
      prior.input_deviation[index] = force.std;
      noise[index] = process_of(force).density(force.std);
    }
  }
}

void LocalModel::check_names() {
  std::vector<std::string> known;
  for (const auto& part : parts_.substructures) known.push_back(part.name);
  for (const auto& part : parts_.finite_elements) known.push_back(part.name);
  for (const auto& name : local_.substructures)
    if (std::ranges::find(known, name.value) == known.end())
      issues_.add(name.location,
                  name.path + ": there is no substructure '" + name.value + "'" + did_you_mean(name.value, known));
}

/// Joined substructures are one body: they stay together, or are left out together.
void LocalModel::check_joints() {
  for (const auto& [first, second] : parts_.shared)
    if (belongs(first, kept_) != belongs(second, kept_)) {
      const auto& place = local_.substructures.front();
      issues_.add(place.location,
                  place.path + ": the joint of '" + first + "' and '" + second + "' leads out of the local model",
                  "the forces in a joint are no interface", "name both substructures, or neither");
      break;
    }
  std::erase_if(parts_.shared, [&](const SharedDof& dof) { return !belongs(dof.first, kept_); });
}

/// Grounds of dropped substructures. Their motion is known, as they are either fixed or driven.
std::vector<std::string> LocalModel::grounds_left_out() const {
  std::vector<std::string> grounds;
  for (const auto& part : parts_.substructures)
    for (const auto& ground : part.grounds)
      if (!kept_.contains(part.name)) grounds.push_back(part.name + "." + ground);
  for (const auto& part : parts_.finite_elements)
    for (const auto& ground : part.model->grounds)
      if (!kept_.contains(part.name)) grounds.push_back(part.name + "." + ground.ground);
  return grounds;
}

/// Keeps those of these grounds at which a connector of the local model ends.
void LocalModel::keep_grounds(const std::vector<std::string>& grounds) {
  const auto keep = [&](const std::string& end, const std::string& other) {
    if (!belongs(other, kept_) || std::ranges::find(grounds, end) == grounds.end() || reachable(end)) return;
    const auto dot = end.find('.');
    add_moving_point(end.substr(0, dot), end.substr(dot + 1));
    moving_.push_back(end);
  };
  for (const auto& connector : parts_.connectors) {
    keep(connector.from, connector.to);
    keep(connector.to, connector.from);
  }
}

/// Whether an input drives the local model. Of several grounds it keeps only those in the model.
bool LocalModel::remains(InputDescription& input) const {
  if (input.kind == InputKind::base_acceleration) return true;
  if (input.direction.empty()) return reachable(input.target);
  std::erase_if(input.direction, [&](const auto& ground) { return !reachable(ground.first); });
  return !input.direction.empty();
}

bool LocalModel::reachable(const std::string& point) const {
  return point == fixed_ground || belongs(point, kept_) || std::ranges::find(moving_, point) != moving_.end();
}

void LocalModel::add_interface(const std::string& point, const Located<Interface>& interface,
                               AugmentedModelSetup& setup) {
  const auto& motion = interface.value.motion;
  const bool inside = belongs(point, kept_);
  if (const auto* measured = std::get_if<InterfaceAcceleration>(&motion)) {
    const auto dot = point.find('.');
    if (inside || dot == std::string::npos) {
      issues_.add(measured->sensor.location,
                  "estimate.local.interface." + point +
                      ": an interface that moves as measured must lie outside the local substructures",
                  "", "name a point of the part that is left out");
      return;
    }
    add_moving_point(point.substr(0, dot), point.substr(dot + 1));
    moving_.push_back(point);
    parts_.inputs.push_back({point, InputKind::base_displacement, point, {}, interface.location});
    setup.input_sources.push_back("@" + measured->sensor.value);
    setup.options.inputs.push_back({.model = InputModel::integrated});
  } else {
    parts_.inputs.push_back({point, InputKind::force, point, {}, interface.location});
    setup.input_sources.emplace_back("");
    setup.options.inputs.push_back(
        {.model = InputModel::latent, .process = process_of(std::get<InterfaceForce>(motion))});
  }
}

/// Adds a moving ground to its substructure; a dropped one returns without degrees of freedom, only with this point.
void LocalModel::add_moving_point(const std::string& substructure, const std::string& point) {
  for (auto& part : parts_.substructures)
    if (part.name == substructure) {
      if (std::ranges::find(part.grounds, point) == part.grounds.end()) part.grounds.push_back(point);
      return;
    }
  LumpedSubstructure frame;
  frame.name = substructure;
  frame.grounds = {point};
  parts_.substructures.push_back(frame);
}

}  // namespace kalfem
