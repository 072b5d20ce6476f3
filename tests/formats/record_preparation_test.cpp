// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/record_preparation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"

// What a filter is handed of a free response: from the release on, about the rest position, with the samples to learn
// from.
namespace kalfem {
namespace {

using Eigen::Index;

constexpr double rate = 500.0, released = 0.5, stopped = 2.5;

/// Held at 40 mm, let go at 0.5 s, swinging about 5 mm with an amplitude that falls linearly to zero at 2.5 s; the
/// second channel shows half of it.
Record free_response(double duration) {
  Record record{rate, 0.0, {{"x", "m", 1e-5}, {"y", "m", 2e-5}}, Eigen::MatrixXd(2, Index(duration * rate))};
  for (Index k = 0; k < record.samples(); ++k) {
    const double since = std::max(0.0, record.time(k) - released);
    record.values(0, k) =
        0.005 + 0.035 * std::max(0.0, 1.0 - since / (stopped - released)) * std::cos(3.0 * std::numbers::pi * since);
    record.values(1, k) = 0.5 * record.values(0, k);
  }
  return record;
}

TEST(FreeResponsePart, IsRelativeToTheRestAndEndsLearningAfterTheMotion) {
  PreparedRecord prepared{free_response(4.0)};
  take_free_response(prepared, {.delay = 0.1, .threshold = 0.01, .margin = 0.3});
  const auto& [record, preparation, found, began] = prepared;
  ASSERT_TRUE(found && found->rest);
  EXPECT_FALSE(found->rest_is_unknown());
  EXPECT_NEAR(found->position[0], 0.005, 1e-12);
  EXPECT_NEAR(found->position[1], 0.0025, 1e-12);
  EXPECT_NEAR(found->release, released, 0.03);  // 1 % of the excursion and five samples
  EXPECT_NEAR(record.start, found->release + 0.1, 1.0 / rate);
  EXPECT_NEAR(record.values(0, record.samples() - 1), 0.0, 1e-12);
  EXPECT_EQ(record.channels[1].noise, 2e-5);
  // 35 mm (1 - t / 2 s) is below 10 mm from 1.43 s after the release on; a swing of 1/3 s may pass before it is seen
  ASSERT_TRUE(record.used);
  EXPECT_NEAR(record.time(*record.used) - 0.3, released + 1.43, 0.17);
  EXPECT_LT(*record.used, record.samples());
  ASSERT_EQ(preparation.size(), 1u);
}

TEST(FreeResponsePart, WithoutARestIsAboutTheLastSwingOfUnknownRest) {
  PreparedRecord prepared{free_response(1.8)};
  take_free_response(prepared, {.rest_deviation = {0.002, std::nullopt}});
  const auto& found = prepared.free_response;
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->rest);
  EXPECT_TRUE(found->rest_is_unknown());
  EXPECT_EQ(found->deviation[0], 0.002);  // as it is given
  EXPECT_GT(found->deviation[1], 1e-3);   // half of the last swing
  EXPECT_LT(found->deviation[1], 0.0175);
  EXPECT_EQ(prepared.record.samples_used(), prepared.record.samples());
}

TEST(FreeResponsePart, NeedsARelease) {
  PreparedRecord moving{free_response(4.0)};
  moving.record = cut(moving.record, 0.6, 4.0);
  EXPECT_THROW(take_free_response(moving, {}), InvalidInput);
}

TEST(RepairSplice, LeavesARecordWithoutOneAsItIs) {
  PreparedRecord prepared{free_response(4.0)};
  prepared.record.values(1, 700) = std::numeric_limits<double>::quiet_NaN();
  repair_splice(prepared);
  EXPECT_EQ(prepared.record.samples(), 2000);
  EXPECT_EQ(prepared.record.values.array().isNaN().count(), 1);
  EXPECT_TRUE(prepared.preparation.empty());
}

}  // namespace
}  // namespace kalfem
