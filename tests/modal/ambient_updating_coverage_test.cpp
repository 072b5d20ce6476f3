// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>

#include "modal/ambient_updating.hpp"
#include "modal/modal_runs.hpp"

namespace kalfem::test {
namespace {

int number(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text ? std::atoi(text) : otherwise;
}

/// KALFEM_FIRST and KALFEM_COUNT choose the seeds; all are 40.
TEST(AmbientUpdatingCoverage, OfStiffnessesFromARecordAlone) {
  const auto tally = update_from_records(number("KALFEM_FIRST", 1), number("KALFEM_COUNT", 40));
  std::cout << fmt::format(
                   "{} records: {} of {} intervals hold the stiffness, {} updates consistent, deviations up to "
                   "{:.2f} %, root mean square of errors {:.2f} deviations",
                   tally.records, tally.held, tally.intervals, tally.consistent, 100.0 * tally.largest_std,
                   std::sqrt(tally.mean_square))
            << std::endl;
  EXPECT_TRUE(is_binomial(tally.held, tally.intervals)) << tally.held;
}

}  // namespace
}  // namespace kalfem::test
