// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "identification/information_records.hpp"
#include "kalfem/identification/expected_record.hpp"

namespace kalfem::test {
namespace {

TEST(FisherInformationSeeds, IsTheMeanCurvatureOfAHundredRecords) {
  const InformedChain chain;
  const MeanOverSeeds hessian(100, [&](std::uint64_t seed) {
    return negative_hessian(chain.likelihood(chain.record(seed)), chain.truth, chain.steps);
  });
  const double chance = largest_error(hessian.mean + hessian.deviation, hessian.mean);
  const auto expected = expected_record(shared(chain.problem), chain.clean, chain.names, chain.truth);
  ASSERT_TRUE(expected);
  const auto before = fisher_information(chain.likelihood(*expected), chain.truth);
  const auto after = fisher_information(chain.likelihood(chain.record(101)), chain.truth);
  ASSERT_TRUE(before && after);
  std::printf("largest error: %.4f of the record's information, %.4f of the expected one; deviation of the mean %.4f\n",
              largest_error(*after, hessian.mean), largest_error(*before, hessian.mean), chance);
  EXPECT_LT(chance, 0.02);
  EXPECT_LT(largest_error(*after, hessian.mean), 0.05);
  EXPECT_LT(largest_error(*before, hessian.mean), 0.05);
}

}  // namespace
}  // namespace kalfem::test
