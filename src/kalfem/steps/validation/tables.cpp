// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/validation/report.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "kalfem/page/words.hpp"
#include "kalfem/steps/validation/outcome.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

Table validation_table(const ValidationOutcome& outcome) {
  const auto &held_back = outcome.held_back, &own = outcome.own;
  Table table{"Open loop on the validation part",
              {"sensor", "NRMSE", "on the estimated part", "one step ahead", "noise / rms"},
              {},
              {}};
  for (std::size_t j = 0; j < held_back.nrmse.size(); ++j)
    table.rows.push_back({held_back.measured.channels[j].name, four_digits(held_back.nrmse[j]),
                          j < own.nrmse.size() ? four_digits(own.nrmse[j]) : "-",
                          j < held_back.one_step.size() ? four_digits(held_back.one_step[j]) : "-",
                          four_digits(held_back.noise[j])});
  return table;
}

std::string validation_part_words(const ValidationPlan& plan) {
  return fmt::format("Validation: {} s to {} s of {}", four_digits(plan.record.record.start),
                     four_digits(plan.record.record.end()), std::filesystem::path(plan.file).filename().string());
}

std::string validation_words(const Study& study, const ValidationOutcome& outcome) {
  const auto& held_back = outcome.held_back;
  const std::string part = validation_part_words(*study.validation);
  if (!held_back.failure.empty()) return part + "; no comparison: " + held_back.failure;
  if (study.validation->from_rest) return part + ", open loop from rest";
  return part +
         fmt::format(", open loop; the initial state is estimated from the samples before {} s, which do not count",
                     four_digits(held_back.measured.time(held_back.first)));
}

}  // namespace kalfem
