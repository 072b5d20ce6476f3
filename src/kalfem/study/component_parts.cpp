// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/component_parts.hpp"

#include <algorithm>

#include "kalfem/system/coupling.hpp"

namespace kalfem {
namespace {

namespace d = description;

void add_motion(const d::ImposedMotion& motion, const std::string& key, const Name& ground, d::Case& given) {
  given.excitation.emplace_back(component_name + "." + key, d::Excitation{.target = d::BaseDisplacement{ground},
                                                                          .signal = motion.signal,
                                                                          .scale = motion.scale,
                                                                          .velocity = motion.velocity,
                                                                          .drift = std::nullopt});
}

void add_component(d::Case& given, IssueList& issues) {
  const auto& [component, place, path] = *given.component;
  for (const auto& [key, present] : {std::pair{"substructures", !given.substructures.empty()},
                                     {"connectors", !given.connectors.empty()},
                                     {"excitation", !given.excitation.empty()}})
    if (present)
      issues.add(place, "the case has both `component` and `" + std::string(key) + "`",
                 "a component stands alone on its test machine",
                 "remove one of them; a connector of a structure goes under `connectors`");
  if (!issues.empty()) return;
  d::Connector connector = component.connector;
  d::Substructure ends;
  connector.to = {component_name + ".to", place, path};
  connector.from = {fixed_ground, place, path};
  ends.grounds = {"to"};
  add_motion(component.motion.value, "motion", connector.to, given);
  if (component.base_motion) {
    connector.from.value = component_name + ".from";
    ends.grounds.emplace_back("from");
    add_motion(component.base_motion->value, "base_motion", connector.from, given);
  }
  given.substructures.emplace_back(component_name, ends);
  given.connectors.emplace_back(component_name, connector);
}

}  // namespace

std::string signal_ground(const std::string& connector, const std::string& signal) {
  return signal_grounds + "." + connector + ":" + signal;
}

void expand_component(d::Case& given, IssueList& issues) {
  if (given.component) add_component(given, issues);
  d::Substructure grounds;
  for (const auto& [name, connector] : given.connectors)
    for (const auto& [signal, feed] : connector.signals) {
      const std::string ground = signal_ground(name, signal);
      grounds.grounds.push_back(ground.substr(signal_grounds.size() + 1));
      given.excitation.emplace_back(key_of_connector(name, given) + ".signals." + signal,
                                    d::Excitation{.target = d::SignalTarget{{ground, feed.location, feed.path}},
                                                  .signal = feed.value.signal,
                                                  .scale = feed.value.scale,
                                                  .drift = std::nullopt});
    }
  if (!grounds.grounds.empty()) given.substructures.emplace_back(signal_grounds, grounds);
}

bool consists_of_grounds(const std::string& name, const d::Case& given) {
  return name == signal_grounds || (given.component && name == component_name);
}

std::string key_of_connector(const std::string& name, const d::Case& given) {
  return given.component && name == component_name ? name : "connectors." + name;
}

}  // namespace kalfem
