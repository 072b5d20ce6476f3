// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <cmath>
#include <iostream>
#include <map>

#include <fmt/format.h>

#include "calibration_runs.hpp"

namespace kalfem::calibration {
namespace {

/// A stiffness that the estimation holds fixed; empty where there is none.
std::string fixed_stiffness(const RandomRecord& given, std::uint64_t seed) {
  std::vector<std::string> names;
  for (const auto& name : given.structure.parameters()) {
    const auto& unknowns = given.options.unknowns;
    const bool unknown = std::ranges::any_of(unknowns, [&](const auto& each) { return each.name == name; });
    if (name.ends_with(".stiffness") && !unknown) names.push_back(name);
  }
  return names.empty() ? "" : names[seed % names.size()];
}

Eigen::Index judged_values(const EstimateResult& found) {
  const Eigen::Index samples = found.nis.size() - found.settled;
  return found.used.rightCols(samples).sum();
}

// One to twenty periods of the slowest mode, from rest.
TEST(ShortRecords, AreJudgedByEverySampleThatTheyHave) {
  const int first = number("KALFEM_FIRST", 1), count = number("KALFEM_COUNT", 200);
  int right_consistent = 0, right_judged = 0, right_unusable = 0, wrong_consistent = 0, wrong = 0;
  for (int seed = first; seed < first + count; ++seed) {
    const double periods = 1.0 + 19.0 * (seed % 20) / 19.0;
    const auto given = random_record(static_cast<std::uint64_t>(seed), {.periods = periods, .lumped = true});
    const auto right = estimate(given.structure, given.record, given.options);
    const bool enough = judged_values(right) >= 50;
    right_judged += enough;
    right_consistent += enough && right.verdict.state() == VerdictState::consistent;
    right_unusable += right.verdict.state() == VerdictState::unusable;
    if (right.verdict.state() != VerdictState::consistent &&
        (enough || right.verdict.state() == VerdictState::unusable))
      std::cout << seed << " right: " << given.kind << ": " << to_string(right.verdict.state())
                << codes_of(right.verdict) << std::endl;
    const auto name = fixed_stiffness(given, static_cast<std::uint64_t>(seed));
    if (name.empty()) continue;
    const auto model = given.structure.at({{name, 1.3 * given.structure.value(name)}});
    const auto found = estimate(model, given.record, given.options);
    ++wrong;
    if (found.verdict.state() != VerdictState::consistent) continue;
    ++wrong_consistent;
    std::cout << seed << " wrong: " << name << ": " << given.kind
              << fmt::format(": log-likelihood of the right model {:+.1f}", right.log_likelihood - found.log_likelihood)
              << std::endl;
    for (std::size_t i = 0; i < given.truth.size(); ++i)
      std::cout << fmt::format("    {} off by {:+.1f} deviations\n", found.parameters[i].name,
                               (found.parameters[i].mean - given.truth[i]) / found.parameters[i].std);
  }
  std::cout << fmt::format("right: {} of {} with 50 values consistent, {} unusable; wrong: {} of {} consistent\n",
                           right_consistent, right_judged, right_unusable, wrong_consistent, wrong);
  EXPECT_EQ(right_unusable, 0);
  EXPECT_GE(right_consistent, 0.9 * right_judged);
}

}  // namespace
}  // namespace kalfem::calibration
