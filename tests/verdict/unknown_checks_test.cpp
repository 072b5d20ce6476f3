// SPDX-License-Identifier: Apache-2.0
#include "kalfem/verdict/checks.hpp"

#include <gtest/gtest.h>

namespace kalfem {
namespace {

using Eigen::MatrixXd;
using Codes = std::vector<std::string>;

EstimatedUnknown sound(const std::string& name) {
  return {.name = name,
          .unit = "N/m",
          .initial = 1000.0,
          .estimate = 1200.0,
          .moved = 1.0,
          .shrinkage = 0.05,
          .deviation = 10.0,
          .widening = 1.1};
}

Codes codes(const std::vector<EstimatedUnknown>& unknowns, const MatrixXd& correlation, double nis_ratio = 1.0) {
  Codes found;
  for (const auto& reason : unknown_reasons(unknowns, correlation, 4.0 * nis_ratio, 4.0))
    found.push_back(reason.subject + " " + reason.code);
  return found;
}

Codes codes(const EstimatedUnknown& unknown, double nis_ratio = 1.0) {
  return codes(std::vector{unknown}, MatrixXd::Ones(1, 1), nis_ratio);
}

TEST(UnknownChecks, AccuseNoSoundEstimate) { EXPECT_EQ(codes(sound("k")), Codes{}); }

TEST(UnknownChecks, NoticeAnEstimateFarFromItsPrior) {
  auto unknown = sound("k");
  unknown.moved = 4.5;
  EXPECT_EQ(codes(unknown), Codes{"k far_from_prior"});
  const MatrixXd alone = MatrixXd::Ones(1, 1);
  EXPECT_EQ(unknown_reasons({unknown}, alone, 4.4, 4.0).front().state, VerdictState::suspicious);
  EXPECT_EQ(unknown_reasons({unknown}, alone, 5.2, 4.0).front().state, VerdictState::unusable);
  unknown.drifts = true;
  EXPECT_EQ(codes(unknown), Codes{});
}

TEST(UnknownChecks, NoticeTheOtherSignWhereItIsCertain) {
  auto unknown = sound("k");
  unknown.estimate = -30.0;  // three deviations
  EXPECT_EQ(codes(unknown), Codes{});
  unknown.estimate = -60.0;
  EXPECT_EQ(codes(unknown), Codes{"k sign_changed"});
}

TEST(UnknownChecks, NoticeWhatTheRecordDoesNotTell) {
  auto unknown = sound("k");
  unknown.shrinkage = 0.95;
  EXPECT_EQ(codes(unknown), Codes{"k not_identified"});
  MatrixXd correlation(2, 2);
  correlation << 1.0, -0.995, -0.995, 1.0;
  EXPECT_EQ(codes({sound("k"), sound("c")}, correlation), Codes{"k, c correlated"});
  auto one = sound("k"), other = sound("c");
  one.shrinkage = other.shrinkage = 0.04;  // each is known to a part of its prior, so they are told apart
  EXPECT_EQ(codes({one, other}, correlation), Codes{});
  other.shrinkage = 0.2;
  EXPECT_EQ(codes({one, other}, correlation), Codes{"k, c correlated"});
  correlation << 1.0, 0.9, 0.9, 1.0;
  EXPECT_EQ(codes({sound("k"), sound("c")}, correlation), Codes{});
}

TEST(UnknownChecks, NoticeDeviationsThatAreTooSmall) {
  auto unknown = sound("k");
  unknown.widening = 3.0;
  EXPECT_EQ(codes(unknown), Codes{"k deviation_too_small"});
}

}  // namespace
}  // namespace kalfem
