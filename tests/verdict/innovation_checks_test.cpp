// SPDX-License-Identifier: Apache-2.0
#include "kalfem/verdict/checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Innovations of a consistent filter: white, as large as expected. Sensors "a" and "b".
InnovationRecord consistent(std::uint64_t seed, Index samples = 20000) {
  InnovationRecord record{{"a", "b"}, {"m/s^2", "m/s^2"}, Eigen::Vector2d(0.3, 0.1), {}, {}};
  RandomStream random(seed, "innovations");
  record.deviation = MatrixXd::Constant(2, samples, 0.3);
  record.deviation.row(1).setConstant(0.1);
  record.innovation =
      MatrixXd::NullaryExpr(2, samples, [&](Index i, Index) { return record.noise[i] * random.normal(); });
  record.sample_rate = 1000.0;
  record.first = 500;
  return record;
}

/// Innovations of sensor "b" with this correlation at lag one, as large as before.
void correlate(double rho, InnovationRecord& record) {
  for (Index k = 1; k < record.innovation.cols(); ++k)
    record.innovation(1, k) = rho * record.innovation(1, k - 1) + std::sqrt(1.0 - rho * rho) * record.innovation(1, k);
}

std::vector<std::string> codes(const InnovationRecord& record) {
  std::vector<std::string> found;
  for (const auto& reason : innovation_reasons(record)) found.push_back(reason.subject + " " + reason.code);
  return found;
}

using Codes = std::vector<std::string>;

TEST(InnovationChecks, AccuseNoConsistentFilter) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) EXPECT_EQ(codes(consistent(seed)), Codes{}) << seed;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) EXPECT_EQ(codes(consistent(seed, 800)), Codes{}) << seed;
}

// Significant at once with 20,000 samples, but too small to matter.
TEST(InnovationChecks, LetSmallDifferencesPass) {
  auto record = consistent(1);
  record.innovation *= 1.2;
  correlate(0.17, record);
  EXPECT_EQ(codes(record), Codes{});
}

// Large in the numbers, but no more than chance gives in so few samples.
TEST(InnovationChecks, LetChancePass) {
  auto record = consistent(1, 6);
  record.first = 0;
  record.innovation *= 1.6;
  EXPECT_EQ(codes(record), Codes{});
}

TEST(InnovationChecks, NameTheSensorWhoseInnovationsAreTooLarge) {
  auto record = consistent(2);
  record.innovation.row(1) *= 2.0;
  ASSERT_EQ(codes(record), Codes{"b innovation_large"});
  const auto reason = innovation_reasons(record).front();
  EXPECT_EQ(reason.state, VerdictState::suspicious);
  EXPECT_NEAR(reason.weight, 2.0, 0.05);
  EXPECT_NE(reason.remedy.find("its noise is about 0.2 m/s^2, not 0.1 m/s^2"), std::string::npos) << reason.remedy;
  record.innovation.row(1) *= 3.0;
  EXPECT_EQ(innovation_reasons(record).front().state, VerdictState::unusable);
}

TEST(InnovationChecks, NoticeNoiseThatIsStatedTooLarge) {
  auto record = consistent(3);
  record.innovation.row(0) /= 2.7;
  ASSERT_EQ(codes(record), Codes{"a noise_too_large"});
  EXPECT_NE(innovation_reasons(record).front().text.find("2.7"), std::string::npos);
}

// Where the size is right only the correlation tells a wrong model.
TEST(InnovationChecks, NoticeCorrelation) {
  auto record = consistent(4);
  correlate(0.66, record);
  ASSERT_EQ(codes(record), Codes{"b innovation_correlated"});
  EXPECT_EQ(innovation_reasons(record).front().state, VerdictState::suspicious);
  EXPECT_NEAR(innovation_reasons(record).front().weight, 2.2, 0.1);  // sqrt(1.66 / 0.34)
  record = consistent(4);
  correlate(0.96, record);
  ASSERT_EQ(codes(record), Codes{"b innovation_correlated"});
  EXPECT_EQ(innovation_reasons(record).front().state, VerdictState::suspicious);
  record.innovation.row(1) *= 2.0;
  ASSERT_EQ(codes(record), (Codes{"b innovation_large", "b innovation_correlated"}));
  EXPECT_EQ(innovation_reasons(record).back().state, VerdictState::unusable);
}

// Noise that is stated too large to make up for what the model misses: the deviations are honest, the noise is not.
TEST(InnovationChecks, WeighCorrelationAgainstNoiseThatIsStatedTooLarge) {
  auto record = consistent(4);
  correlate(0.96, record);
  record.innovation.row(1) /= 10.0;
  EXPECT_EQ(codes(record), Codes{"b noise_too_large"});
}

// Wrong by three where it is loud, and right where it is quiet, which is most of the time.
TEST(InnovationChecks, LetNoQuietPartAverageALoudOneAway) {
  auto record = consistent(5);
  record.innovation.block(0, 8000, 1, 2000) *= 3.0;
  ASSERT_EQ(codes(record), Codes{"a innovation_large_in_part"});
  const auto reason = innovation_reasons(record).front();
  EXPECT_NEAR(reason.weight, 3.0, 0.2);
  EXPECT_NE(reason.text.find(" s the innovations of 'a'"), std::string::npos) << reason.text;
}

TEST(InnovationChecks, TellOutliersWithTheirTime) {
  auto record = consistent(6);
  record.innovation(0, 12345) = 9.0;
  ASSERT_EQ(codes(record), Codes{"a outliers"});
  EXPECT_NE(innovation_reasons(record).front().text.find("12.35 s"), std::string::npos)
      << innovation_reasons(record).front().text;
}

TEST(InnovationChecks, LeaveSettlingAndMissingSamplesOut) {
  auto record = consistent(7);
  record.innovation.leftCols(500) *= 100.0;
  for (Index k = 0; k < record.innovation.cols(); k += 3)
    record.innovation(1, k) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(codes(record), Codes{});
  record.innovation.row(0).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(codes(record), Codes{});
  for (const auto& sensor : sensor_consistency(record)) EXPECT_TRUE(std::isfinite(sensor.ratio));
}

// The mistakes that public programs make: each must show as a wrong size on innovations that are right.
TEST(InnovationChecks, WouldFailWithACovarianceForItsRoot) {
  auto record = consistent(8);
  record.deviation = record.deviation.cwiseAbs2();  // S where its root belongs
  EXPECT_NE(codes(record), Codes{});
  record = consistent(8);
  record.deviation = record.deviation.cwiseInverse();  // S^-1 where S belongs
  EXPECT_NE(codes(record), Codes{});
}

TEST(Verdict, IsThatOfItsWorstReasonWhichComesFirst) {
  Verdict verdict;
  EXPECT_EQ(verdict.state(), VerdictState::consistent);
  verdict.add({"one", "", "", "", VerdictState::suspicious, 3.0});
  verdict.add({"two", "", "", "", VerdictState::unusable, 1.0});
  verdict.add({"three", "", "", "", VerdictState::suspicious, 4.0});
  EXPECT_EQ(verdict.state(), VerdictState::unusable);
  const auto reasons = verdict.reasons();
  EXPECT_EQ(reasons[0].code, "two");
  EXPECT_EQ(reasons[1].code, "three");
  EXPECT_EQ(reasons[2].code, "one");
}

}  // namespace
}  // namespace kalfem
