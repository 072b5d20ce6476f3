// SPDX-License-Identifier: Apache-2.0
#include "kalfem/verdict/validation_checks.hpp"

#include <gtest/gtest.h>

namespace kalfem {
namespace {

std::vector<std::string> codes(const ValidatedSensor& sensor) {
  std::vector<std::string> found;
  for (const auto& reason : validation_reasons({sensor})) {
    EXPECT_EQ(reason.subject, sensor.name);
    found.push_back(reason.code);
  }
  return found;
}

using Codes = std::vector<std::string>;

TEST(ValidationChecks, FindNothingInAPredictionAsGoodAsTheEstimation) {
  EXPECT_EQ(codes({"a", 0.05, 0.01, 0.04, 0.01}), Codes{});
  EXPECT_EQ(codes({"a", 0.3, 0.01, 0.25, 0.01}), Codes{});
  EXPECT_EQ(codes({"a", 0.15, 0.01, 0.01, 0.01}), Codes{});  // fifteen times worse, but still small
}

TEST(ValidationChecks, FindAPredictionThatIsHardlyBetterThanNoMotion) {
  const auto reasons = validation_reasons({{"a", 0.95, 0.0, 0.9, 0.0}});
  ASSERT_EQ(reasons.size(), 1U);
  EXPECT_EQ(reasons[0].code, "validation_error");
  EXPECT_EQ(reasons[0].state, VerdictState::suspicious);
  EXPECT_EQ(validation_reasons({{"a", 1.42, 0.0, 1.3, 0.0}})[0].state, VerdictState::suspicious);  // phases lost
  EXPECT_EQ(validation_reasons({{"a", 1.6, 0.0, 1.5, 0.0}})[0].state, VerdictState::unusable);
}

TEST(ValidationChecks, FindAPredictionMuchWorseThanOnTheOwnPart) {
  EXPECT_EQ(codes({"a", 0.5, 0.02, 0.1, 0.02}), Codes{"validation_worse"});
  EXPECT_EQ(codes({"a", 1.2, 0.02, 0.1, 0.02}), (Codes{"validation_error", "validation_worse"}));
  EXPECT_EQ(codes({"a", 0.5, 0.02}), Codes{});  // nothing to compare with
}

/// No simulation predicts noise: with 60 % of it an error of 0.62 is nearly perfect.
TEST(ValidationChecks, TakeOffTheNoise) {
  EXPECT_DOUBLE_EQ(*motion_error(0.5, 0.3), 0.4 / std::sqrt(0.91));
  EXPECT_DOUBLE_EQ(*motion_error(0.2, 0.3), 0.0);
  EXPECT_EQ(codes({"a", 0.62, 0.6, 0.15, 0.1}), Codes{});
  EXPECT_EQ(codes({"a", 1.0, 0.9, 0.2, 0.1}), Codes{});  // a channel that is mostly noise says nothing
  EXPECT_FALSE(motion_error(1.0, 0.9).has_value());
}

}  // namespace
}  // namespace kalfem
