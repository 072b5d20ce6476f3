// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/console_report.hpp"

#include <fmt/format.h>

#include <array>

#include "kalfem/steps/modes/report.hpp"
#include "kalfem/steps/table.hpp"

namespace kalfem {
namespace {

constexpr std::array<std::string_view, 12> order{"place",  "static",    "frf",      "modes", "simulate", "record",
                                                 "update", "correlate", "estimate", "infer", "validate", "predict"};

/// Sizes of the finite-element substructures, and the time that they took.
std::string elements_told(const Study& study) {
  std::string text;
  for (const auto& elements : study.structure->finite_elements) {
    text += fmt::format("'{}': {} degrees of freedom, {}", elements.part->name, elements.part->full.size(),
                        mass_text(*elements.part));
    if (elements.reduced)
      text += fmt::format("; reduced to {} ({} of the boundary, {})", elements.reduced->model.size(),
                          elements.reduced->boundary.size(), elements.reduced->error_indicators.reason);
    text += "\n";
  }
  return text.empty() ? "" : text + fmt::format("read, assembled and reduced in {:.1f} s\n\n", study.reduce_seconds);
}

}  // namespace

std::string console_report(const Study& study, const StudyResults& results) {
  std::string text = elements_told(study);
  for (const auto* step : steps_that_ran(results, order))
    if (step->tell) text += step->tell(study, results);
  return text;
}

}  // namespace kalfem
