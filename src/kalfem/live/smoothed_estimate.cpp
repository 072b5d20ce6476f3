// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/smoothed_estimate.hpp"

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

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
