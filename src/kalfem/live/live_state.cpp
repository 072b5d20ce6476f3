// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/live_state.hpp"

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

std::string to_string(FilterCondition condition) {
  switch (condition) {
    case FilterCondition::warming_up:
      return "warming up";
    case FilterCondition::consistent:
      return "consistent";
    case FilterCondition::suspicious:
      return "suspicious";
    case FilterCondition::unusable:
      return "unusable";
    case FilterCondition::silent:
      return "silent";
  }
  return {};
}

std::string to_string(FilterEventKind kind) {
  switch (kind) {
    case FilterEventKind::spike:
      return "spike";
    case FilterEventKind::stuck:
      return "stuck";
    case FilterEventKind::saturated:
      return "saturated";
    case FilterEventKind::dead:
      return "dead";
    case FilterEventKind::off:
      return "off";
    case FilterEventKind::missing:
      return "missing";
    case FilterEventKind::back:
      return "back";
    case FilterEventKind::inflated:
      return "inflated";
    case FilterEventKind::restarted:
      return "restarted";
  }
  return {};
}

std::string to_string(AlarmKind kind) {
  switch (kind) {
    case AlarmKind::raised:
      return "raised";
    case AlarmKind::changed:
      return "changed";
    case AlarmKind::ended:
      return "ended";
  }
  return {};
}

const PresentParameter& SmoothedEstimate::parameter(const std::string& name) const {
  std::vector<std::string> known;
  for (const auto& each : parameters) {
    if (each.name == name) return each;
    known.push_back(each.name);
  }
  throw InvalidInput("the filter has no parameter '" + name + "'" + did_you_mean(name, known), "", "");
}

const PresentEstimate& SmoothedEstimate::output(const std::string& name) const {
  std::vector<std::string> known;
  for (const auto& [each, estimate] : outputs) {
    if (each == name) return estimate;
    known.push_back(each);
  }
  throw InvalidInput("the filter has no state '" + name + "'" + did_you_mean(name, known), "", "");
}

}  // namespace kalfem
