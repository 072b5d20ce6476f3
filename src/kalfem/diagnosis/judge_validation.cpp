// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/judge_validation.hpp"

#include "kalfem/validation/validation.hpp"
#include "kalfem/verdict/validation_checks.hpp"

namespace kalfem {

std::vector<Reason> reasons_of(const Validation& validation) {
  const auto &held_back = validation.held_back, &own = validation.own;
  if (!held_back.failure.empty())
    return {{"validation_failed", "", "the validation gave no comparison: " + held_back.failure,
             "the estimates do not describe the structure by themselves: check the priors, the laws and the inputs",
             VerdictState::suspicious, unusable_widening}};
  std::vector<ValidatedSensor> sensors;
  for (std::size_t j = 0; j < held_back.nrmse.size(); ++j) {
    sensors.push_back(
        {.name = held_back.measured.channels[j].name, .error = held_back.nrmse[j], .noise = held_back.noise[j]});
    if (own.nrmse.empty()) continue;
    sensors.back().own_error = own.nrmse[j];
    sensors.back().own_noise = own.noise[j];
  }
  return validation_reasons(sensors);
}

}  // namespace kalfem
