// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/study_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "kalfem/page/words.hpp"
#include "kalfem/steps/compared.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/steps/table.hpp"
#include "kalfem/steps/validation/outcome.hpp"

namespace kalfem {
namespace {

/// The first one that has an answer gives it; what was updated is said before it.
constexpr std::array<std::string_view, 8> answer_order{"update", "estimate", "infer",    "place",
                                                       "static", "frf",      "simulate", "modes"};

std::string doubts_in_words(const std::vector<Reason>& reasons) {
  return fmt::format("{} for doubt, the worst: {}.",
                     reasons.size() == 1 ? "One reason" : fmt::format("{} reasons", reasons.size()),
                     reasons.front().text);
}

/// What follows from the answer.
std::string next_step(const StudyResults& results) {
  if (const auto reasons = results.verdict.reasons(); !reasons.empty())
    return reasons.front().remedy.empty() ? "" : "Next: " + reasons.front().remedy + ".";
  if (results.has<EstimationOutcome>() && !results.has<ValidationOutcome>() && !results.has<SimulationOutcome>())
    return "Next: hold back a part of the record (`validate`) and see whether the values predict it.";
  if (results.identified) return "Next: run case.identified.yaml, which holds the values found.";
  return "";
}

}  // namespace

std::string answer(const Study& study, const StudyResults& results) {
  if (!results.complete()) return results.why_unusable();
  std::vector<std::string> sentences;
  const auto say = [&](const std::string& sentence) {
    if (!sentence.empty()) sentences.push_back(sentence);
    return !sentence.empty();
  };
  for (const auto* step : steps_that_ran(results, answer_order))
    if (step->answer && say(step->answer(study, results)) && step->name != "update") break;
  if (!has_verdict(results)) {
    std::string why = sentence(why_no_verdict(results));
    why.back() = '.';  // in the place of the line's end
    say(why);
  }
  if (const auto reasons = results.verdict.reasons(); !reasons.empty()) say(doubts_in_words(reasons));
  say(next_step(results));
  return fmt::format("{}", fmt::join(sentences, " "));
}

}  // namespace kalfem
