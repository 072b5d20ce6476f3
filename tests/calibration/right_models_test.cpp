// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <iostream>

#include <fmt/format.h>

#include "calibration_runs.hpp"

namespace kalfem::calibration {
namespace {

// KALFEM_FIRST and KALFEM_COUNT: other seeds, or fewer. A line for each run that is not consistent or misses a truth.
TEST(RightModels, AreConsistentAndHoldTheTruth) {
  const int first = number("KALFEM_FIRST", 1), count = number("KALFEM_COUNT", 400);
  int consistent = 0, too_small = 0, blamed = 0, doubted = 0;
  Coverage parameters, unmeasured;
  for (int seed = first; seed < first + count; ++seed) {
    auto given = random_record(static_cast<std::uint64_t>(seed));
    for (const auto& each : given.unmeasured) given.options.outputs.push_back(each.output);
    const auto found = estimate(given.structure, given.record, given.options);
    const bool right = found.verdict.state() == VerdictState::consistent;
    consistent += right ? 1 : 0;
    const auto reasons = found.verdict.reasons();
    too_small += std::ranges::any_of(reasons, [](const auto& each) { return each.code == "deviation_too_small"; });
    blamed += std::ranges::any_of(reasons, [](const auto& each) { return each.code == "fixed_parameter"; });
    doubted += std::ranges::any_of(reasons, [](const auto& each) { return each.code == "band_too_narrow"; });
    std::string missed = add_unmeasured(found, given, seed, unmeasured);
    for (std::size_t i = 0; i < given.truth.size(); ++i) {
      const auto& each = found.parameters[i];
      const bool holds_it = holds(each, given.truth[i]);
      parameters.add(holds_it);
      if (!holds_it || !right)
        missed += fmt::format("; {} {:.4g} (std {:.2g}, robust {:.2g}) for {:.4g}", each.name, each.mean, each.std,
                              each.std_robust, given.truth[i]);
    }
    if (!missed.empty())
      std::cout << seed << " " << given.kind << ": " << to_string(found.verdict.state()) << codes_of(found.verdict)
                << missed << (right ? "" : "; " + reasons.front().text) << std::endl;
  }
  std::cout << fmt::format(
      "{} of {} consistent, {} of {} intervals true, {} of {} of what no sensor shows, a deviation too small in {}, a "
      "fixed number blamed in {}, a sensor's band doubted in {}\n",
      consistent, count, parameters.held, parameters.intervals, unmeasured.held, unmeasured.intervals, too_small,
      blamed, doubted);
  EXPECT_GE(consistent, 0.94 * count);
  EXPECT_LE(too_small, 0.01 * count);
  EXPECT_LE(blamed, 0.02 * count);
  EXPECT_LE(doubted, 0.05 * count);
  EXPECT_TRUE(parameters.is_binomial());
  EXPECT_TRUE(unmeasured.is_binomial());
}

}  // namespace
}  // namespace kalfem::calibration
