// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kalfem/base/random.hpp"
#include "kalfem/verdict/checks.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Codes = std::vector<std::string>;

/// White innovations of three sensors with unit deviations; NIS by this inverse of their covariance.
InnovationRecord innovations(std::uint64_t seed, Index samples = 8000) {
  RandomStream random(seed, "nis checks");
  InnovationRecord record{.sensors = {"a", "b", "c"},
                          .units = {"", "", ""},
                          .noise = VectorXd::Ones(3),
                          .innovation = MatrixXd::NullaryExpr(3, samples, [&] { return random.normal(); }),
                          .deviation = MatrixXd::Ones(3, samples),
                          .sample_rate = 1000.0};
  record.measured = Eigen::VectorXi::Constant(samples, 3);
  return record;
}

void set_nis(InnovationRecord& record, const Eigen::Matrix3d& covariance = Eigen::Matrix3d::Identity()) {
  const Eigen::Matrix3d inverse = covariance.inverse();
  record.nis = (record.innovation.cwiseProduct(inverse * record.innovation)).colwise().sum().transpose();
}

Codes codes(const InnovationRecord& record) {
  Codes found;
  for (const auto& reason : innovation_reasons(record)) found.push_back(reason.subject + " " + reason.code);
  return found;
}

TEST(NisChecks, AccuseNoConsistentFilter) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    auto record = innovations(seed, seed % 2 == 0 ? 8000 : 700);
    set_nis(record);
    EXPECT_EQ(codes(record), Codes{}) << seed;
  }
}

/// The filter expects sensors that move together, and they do not: each is as large as expected.
TEST(NisChecks, NoticeSensorsThatAreWrongTogetherOnly) {
  auto record = innovations(1);
  set_nis(record, (Eigen::Matrix3d() << 1.0, 0.95, 0.0, 0.95, 1.0, 0.0, 0.0, 0.0, 1.0).finished());
  ASSERT_EQ(codes(record), Codes{"all sensors nis_large"});
  const auto reason = innovation_reasons(record).front();
  EXPECT_EQ(reason.state, VerdictState::suspicious);
  EXPECT_NE(reason.text.find("expected 3)"), std::string::npos) << reason.text;
}

TEST(NisChecks, LetNoQuietPartAverageALoudOneAway) {
  auto record = innovations(2);
  set_nis(record);
  record.nis.segment(4000, 400) *= 4.0;
  ASSERT_EQ(codes(record), Codes{"all sensors nis_large_in_part"});
  EXPECT_NE(innovation_reasons(record).front().text.find("from 4 to 4.4 s"), std::string::npos)
      << innovation_reasons(record).front().text;
}

TEST(NisChecks, LeaveItToTheSensorThatIsWrongByItself) {
  auto record = innovations(3);
  record.innovation.row(1) *= 3.0;
  set_nis(record);
  EXPECT_EQ(codes(record), Codes{"b innovation_large"});
}

TEST(NisChecks, CountTheChannelsOfEachSample) {
  auto record = innovations(4);
  const double missing = std::numeric_limits<double>::quiet_NaN();
  set_nis(record);
  for (Index k = 0; k < record.nis.size(); k += 2) {
    record.nis[k] = record.innovation(0, k) * record.innovation(0, k);
    record.innovation.col(k).tail(2).setConstant(missing);
    record.measured[k] = 1;
  }
  record.nis[7] = missing;
  record.measured[7] = 0;
  const auto found = nis_consistency(record);
  EXPECT_NEAR(found.ratio, 1.0, 0.05);
  EXPECT_NEAR(found.mean_degrees, 2.0, 1e-3);
  EXPECT_LT(found.beyond_half_gate, 0.002);
  EXPECT_EQ(codes(record), Codes{});
  record.nis.setConstant(missing);
  EXPECT_EQ(nis_consistency(record).samples, 0);
  EXPECT_EQ(codes(record), Codes{});
}

/// Seven per cent of the samples four deviations off, all over the record: no part is loud, the whole is not large.
TEST(NisChecks, NoticeASensorThatIsFarOffForMuchOfTheTime) {
  auto record = innovations(5);
  for (Index k = 0; k < record.innovation.cols(); k += 14) record.innovation(2, k) = k % 28 == 0 ? 4.0 : -4.0;
  set_nis(record);
  EXPECT_EQ(codes(record), Codes{"c innovation_large_often"});
  record = innovations(5);
  for (Index k = 0; k < record.innovation.cols(); k += 50) record.innovation(2, k) = k % 100 == 0 ? 4.0 : -4.0;
  set_nis(record);
  EXPECT_EQ(codes(record), Codes{});  // two per cent of it are no more than a rough sensor
}

EstimatedUnknown unknown(const std::string& name) {
  return {.name = name,
          .unit = "N/m",
          .initial = 1000.0,
          .estimate = 1200.0,
          .moved = 1.0,
          .shrinkage = 0.5,
          .deviation = 10.0,
          .widening = 1.0};
}

Codes codes(const std::vector<EstimatedUnknown>& unknowns, const MatrixXd& correlation) {
  Codes found;
  for (const auto& reason : unknown_reasons(unknowns, correlation, 4.0, 4.0))
    found.push_back(reason.subject + " " + reason.code);
  return found;
}

TEST(RangeChecks, NoticeWhatNatureForbidsWhateverTheFirstGuess) {
  for (const double initial : {1000.0, 0.0, -500.0}) {
    auto k = unknown("k");
    k.least = 0.0;
    k.initial = initial;
    k.estimate = -60.0;
    ASSERT_EQ(codes({k}, MatrixXd::Ones(1, 1)), Codes{"k out_of_range"}) << initial;
    EXPECT_EQ(unknown_reasons({k}, MatrixXd::Ones(1, 1), 4.0, 4.0).front().state, VerdictState::unusable);
    k.estimate = -30.0;  // three deviations: zero is possible
    EXPECT_EQ(codes({k}, MatrixXd::Ones(1, 1)), Codes{}) << initial;
  }
  auto k3 = unknown("k3");  // a softening spring may be negative
  k3.initial = k3.estimate = -60.0;
  EXPECT_EQ(codes({k3}, MatrixXd::Ones(1, 1)), Codes{});
}

TEST(RangeChecks, NoticeABoundThatTheEstimateRanInto) {
  auto k = unknown("k");
  k.lower_bound = 500.0;
  k.upper_bound = 1202.0;
  k.moved = 3.0;
  EXPECT_EQ(codes({k}, MatrixXd::Ones(1, 1)), Codes{"k at_bound"});
  k.moved = 0.5;  // it stood there from the start
  EXPECT_EQ(codes({k}, MatrixXd::Ones(1, 1)), Codes{});
  k.moved = 3.0;
  k.upper_bound = 2000.0;
  EXPECT_EQ(codes({k}, MatrixXd::Ones(1, 1)), Codes{});
}

/// c is a + b but for little: no two are highly correlated, and the three cannot be told apart.
TEST(CombinationChecks, NoticeThreeThatTheRecordKnowsOnlyTogether) {
  MatrixXd covariance(3, 3);
  covariance << 1.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0 + 1e-3;
  const VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  EXPECT_EQ(codes({unknown("a"), unknown("b"), unknown("c")}, correlation), Codes{"a, b, c combination"});
  auto known = unknown("a");
  known.shrinkage = 0.05;  // each is known well enough all the same
  EXPECT_EQ(codes({known, known, known}, correlation), Codes{});
  correlation(0, 2) = correlation(2, 0) = 0.5;
  EXPECT_EQ(codes({unknown("a"), unknown("b"), unknown("c")}, correlation), Codes{});
}

}  // namespace
}  // namespace kalfem
