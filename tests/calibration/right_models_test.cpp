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
  int consistent = 0, too_small = 0, blamed = 0, held = 0, intervals = 0;
  for (int seed = first; seed < first + count; ++seed) {
    const auto given = random_record(static_cast<std::uint64_t>(seed));
    const auto found = estimate(given.structure, given.record, given.options);
    const bool right = found.verdict.state() == VerdictState::consistent;
    consistent += right ? 1 : 0;
    const auto reasons = found.verdict.reasons();
    too_small += std::ranges::any_of(reasons, [](const auto& each) { return each.code == "deviation_too_small"; });
    blamed += std::ranges::any_of(reasons, [](const auto& each) { return each.code == "fixed_parameter"; });
    std::string missed;
    for (std::size_t i = 0; i < given.truth.size(); ++i) {
      const auto& each = found.parameters[i];
      const bool holds_it = holds(each, given.truth[i]);
      ++intervals;
      held += holds_it ? 1 : 0;
      if (!holds_it || !right)
        missed += fmt::format("; {} {:.4g} (std {:.2g}, robust {:.2g}) for {:.4g}", each.name, each.mean, each.std,
                              each.std_robust, given.truth[i]);
    }
    if (!missed.empty())
      std::cout << seed << " " << given.kind << ": " << to_string(found.verdict.state()) << codes_of(found.verdict)
                << missed << (right ? "" : "; " + reasons.front().text) << std::endl;
  }
  std::cout << fmt::format(
      "{} of {} consistent, {} of {} intervals true, a deviation too small in {}, a fixed number "
      "blamed in {}\n",
      consistent, count, held, intervals, too_small, blamed);
  EXPECT_GE(consistent, 0.94 * count);
  EXPECT_LE(too_small, 0.01 * count);
  EXPECT_LE(blamed, 0.02 * count);
  EXPECT_TRUE(is_binomial(held, intervals));
}

}  // namespace
}  // namespace kalfem::calibration
