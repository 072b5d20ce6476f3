// SPDX-License-Identifier: Apache-2.0
#include "kalfem/information/identifiability.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(Identifiability, OnlyTheRatioOfStiffnessAndMassIsDetermined) {
  // omega^2 = k / m measured to 1 %: the gradient of ln(k / m) is (1/k, -1/m).
  const Vector2d gradient(1 / 5000.0, -1 / 2.0);
  const MatrixXd information = gradient * gradient.transpose() / 1e-4;
  const auto judged = identifiability(information, {{"k", 5000, infinity}, {"m", 2, infinity}});
  EXPECT_TRUE(std::isinf(judged.cramer_rao[0]));
  ASSERT_EQ(judged.combinations.size(), 2U);
  EXPECT_TRUE(judged.combinations[0].determined);
  EXPECT_FALSE(judged.combinations[1].determined);
  EXPECT_EQ(judged.text,
            "Only k / m is determined: the record does not change when both are multiplied by the same factor.");
  EXPECT_TRUE(judged.combinations[0].words == "The record determines k / m." ||
              judged.combinations[0].words == "The record determines m / k.")
      << judged.combinations[0].words;
}

TEST(Identifiability, ProductsAreRecognisedUnderPriorsOfAnySize) {
  // omega^2 = k / m again; a factor moves k by 5 and m by 2 prior deviations.
  const Vector2d gradient(1 / 5000.0, -1 / 2.0);
  const auto judged = identifiability(gradient * gradient.transpose() / 1e-8, {{"k", 5000, 1000.0}, {"m", 2, 1.0}});
  EXPECT_EQ(judged.text,
            "Only k / m is determined: the record does not change when both are multiplied by the same factor.");
}

TEST(Identifiability, CramerRaoBoundAndPosteriorHaveTheirClosedForm) {
  MatrixXd information(2, 2);
  information << 4, 1, 1, 2;
  const auto judged = identifiability(information, {{"a", 1, 1.0}, {"b", 1, 1.0}});
  EXPECT_NEAR(judged.cramer_rao[0], std::sqrt(2.0 / 7), 1e-12);  // det 7
  EXPECT_NEAR(judged.cramer_rao[1], std::sqrt(4.0 / 7), 1e-12);
  EXPECT_NEAR(judged.posterior_deviation[0], std::sqrt(3.0 / 14), 1e-12);  // det 5 * 3 - 1
  EXPECT_NEAR(judged.posterior_deviation[1], std::sqrt(5.0 / 14), 1e-12);
  EXPECT_NEAR(judged.posterior_correlation(0, 1), -1 / std::sqrt(15.0), 1e-12);
}

TEST(Identifiability, SaysHowFarTwoParametersMoveTogether) {
  const Vector2d seen = Vector2d(1, 1).normalized(), unseen = Vector2d(1, -1).normalized();
  const MatrixXd information = 1e4 * seen * seen.transpose() + unseen * unseen.transpose() / (40.0 * 40.0);
  const auto judged = identifiability(information, {{"E", 0, 1.0}, {"thickness", 0, 1.0}});
  EXPECT_EQ(judged.text, "E and thickness cannot be told apart: they may move together by 40 prior deviations.");
  EXPECT_NEAR(judged.combinations[0].deviation, 0.01, 1e-10);
  EXPECT_NEAR(judged.combinations[1].posterior_deviation, 1 / std::sqrt(1 + 1 / 1600.0), 1e-10);
}

TEST(Identifiability, SaysWhatTheRecordTellsNothingOf) {
  const MatrixXd information = Vector2d(100, 0).asDiagonal();
  const auto judged = identifiability(information, {{"x", 3, 1.0}, {"y", 3, 1.0}});
  EXPECT_NE(judged.text.find("The record says nothing of y: its deviation stays 100 % of the prior's"),
            std::string::npos)
      << judged.text;
  EXPECT_NEAR(judged.cramer_rao[0], 0.1, 1e-12);
  EXPECT_TRUE(std::isinf(judged.cramer_rao[1]));
  EXPECT_NEAR(judged.posterior_deviation[1], 1.0, 1e-12);
  const auto both = identifiability(Vector2d(100, 100).asDiagonal(), {{"x", 3, 1.0}, {"y", 3, 1.0}});
  EXPECT_EQ(both.text, "The record determines every parameter.");
}

TEST(Identifiability, SaysWhatTheRecordTellsLittleOf) {
  // 1 / sqrt(1 + 0.156) = 0.930
  const auto judged = identifiability(Vector2d(100, 0.156).asDiagonal(), {{"x", 3, 1.0}, {"y", 3, 1.0}});
  EXPECT_EQ(
      judged.text,
      "The record says little of y: its deviation stays 93 % of the prior's; the excitation is too weak for it, no "
      "sensor sees it, or another parameter acts alike.");
}

TEST(Identifiability, RefusesWhatIsNoInformation) {
  EXPECT_THROW(identifiability(MatrixXd::Identity(2, 2), {{"x", 1, 1.0}}), InvalidInput);
  EXPECT_THROW(identifiability(MatrixXd::Identity(1, 1), {{"x", 0, infinity}}), InvalidInput);
  EXPECT_THROW(identifiability(MatrixXd::Identity(1, 1), {{"x", 1, 0.0}}), InvalidInput);
  MatrixXd indefinite(2, 2);
  indefinite << 1, 2, 2, 1;
  EXPECT_THROW(identifiability(indefinite, {{"x", 1, 1.0}, {"y", 1, 1.0}}), InvalidInput);
}

}  // namespace
}  // namespace kalfem
