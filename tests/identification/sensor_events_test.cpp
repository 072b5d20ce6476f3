// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/sensor_events.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identification/chain_structure.hpp"
#include "identification/spoilt_record.hpp"
#include "kalfem/diagnosis/judge_estimation.hpp"
#include "kalfem/diagnosis/look_for_cause.hpp"

namespace kalfem {
namespace {

using test::Spoilt;
using test::spoilt_chain_record;
using test::spoilt_problem;

const SensorEvent* find(const std::vector<SensorEvent>& events, EventKind kind, const std::string& channel) {
  for (const auto& event : events)
    if (event.kind == kind && event.channel == channel) return &event;
  return nullptr;
}

RecordEstimate estimate_of(const EstimationProblem& given, const Record& record) {
  const auto problem = test::shared(given);
  IssueList issues;
  const auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  return estimate_record(problem, setup, record);
}

void expect_parameters(const RecordEstimate& estimate, double relative) {
  const Eigen::VectorXd estimates = estimate.result.unknowns.mean.rightCols(1);
  const double truth[] = {test::true_mu_k1, test::true_mu_c1};
  for (Eigen::Index i = 0; i < 2; ++i) {
    const double error = std::abs(estimates[i] - truth[i]);
    EXPECT_LE(error, relative * truth[i]) << i;
    EXPECT_LE(error, 3.0 * estimate.robust_deviation[i]) << i;
  }
}

class SpoiltRecords : public testing::TestWithParam<Spoilt> {};

TEST_P(SpoiltRecords, GiveTheParametersAndNameTheirEvents) {
  const auto problem = spoilt_problem();
  const Record record = spoilt_chain_record(problem, 12.0, 1, GetParam());
  auto estimate = estimate_of(problem, record);
  ASSERT_FALSE(estimate.result.failure);
  expect_parameters(estimate, 0.02);

  const auto* dropout = find(estimate.events, EventKind::dropout, "");
  ASSERT_TRUE(dropout);
  EXPECT_NEAR(dropout->from, 5.0, 1e-9);
  EXPECT_NEAR(dropout->to, 5.999, 1e-9);
  const auto* dead = find(estimate.events, EventKind::dead, "a6");
  ASSERT_TRUE(dead);
  EXPECT_NEAR(dead->from, 8.0, GetParam() == Spoilt::noise_only ? 0.05 : 0.005);
  for (const std::string sensor : {"a2", "a4", "a10"}) {
    const auto* outliers = find(estimate.events, EventKind::outliers, sensor);
    ASSERT_TRUE(outliers) << sensor;
    EXPECT_NEAR(static_cast<double>(outliers->count), 88.0, 40.0) << sensor;
    const auto* missing = find(estimate.events, EventKind::missing, sensor);
    ASSERT_TRUE(missing) << sensor;
    EXPECT_NEAR(static_cast<double>(missing->count), 2200.0, 200.0) << sensor;
  }
  const auto verdict = verdict_of(estimate);
  EXPECT_EQ(verdict.state(), VerdictState::suspicious);
  EXPECT_TRUE(std::ranges::any_of(
      verdict.reasons(), [](const Reason& reason) { return reason.code == "sensor_dead" && reason.subject == "a6"; }));
  // What the events explain is not searched for again.
  EXPECT_FALSE(look_for_cause(problem, problem.structure->parts, record, estimate));
}

INSTANTIATE_TEST_SUITE_P(SensorThatDies, SpoiltRecords, testing::Values(Spoilt::holds_zero, Spoilt::noise_only));

TEST(SensorEvents, ACleanRecordIsRunAsWithoutTheSearch) {
  auto problem = spoilt_problem();
  const Record record = test::chain_record(problem, 3.0);
  const auto searched = estimate_of(problem, record);
  problem.settings.outliers = OutlierTreatment::keep;
  const auto kept = estimate_of(problem, record);
  EXPECT_TRUE(searched.events.empty());
  EXPECT_EQ(searched.result.unknowns.mean, kept.result.unknowns.mean);
  EXPECT_EQ(searched.result.nis, kept.result.nis);
}

TEST(SensorEvents, ASensorThatSticksForAWhileIsLeftOutThere) {
  const auto problem = spoilt_problem();
  Record record = test::chain_record(problem, 4.0);
  record.values.row(1).segment(2000, 300).setConstant(record.values(1, 2000));
  const auto estimate = estimate_of(problem, record);
  ASSERT_EQ(estimate.events.size(), 1u);
  EXPECT_EQ(estimate.events[0].kind, EventKind::stuck);
  EXPECT_EQ(estimate.events[0].channel, "a4");
  EXPECT_NEAR(estimate.events[0].from, 2.0, 1e-9);
  EXPECT_NEAR(estimate.events[0].to, 2.299, 1e-9);
}

TEST(SensorEvents, ASensorThatClipsIsLeftOutAtItsLimits) {
  const auto problem = spoilt_problem();
  Record record = test::chain_record(problem, 4.0, false);
  const double limit = 0.6 * record.values.row(2).cwiseAbs().maxCoeff();
  const auto clipped = (record.values.row(2).array().abs() >= limit).count();
  record.values.row(2) = record.values.row(2).cwiseMax(-limit).cwiseMin(limit).eval();
  const auto estimate = estimate_of(problem, record);
  const auto* event = find(estimate.events, EventKind::saturated, "a6");
  ASSERT_TRUE(event);
  EXPECT_NEAR(static_cast<double>(event->count), static_cast<double>(clipped), 0.1 * static_cast<double>(clipped));
}

// A structure that came to rest under a coarse converter: a constant value that its prediction agrees with.
TEST(SensorEvents, AConstantValueAtRestIsNoFault) {
  Record record{.sample_rate = 100.0, .channels = {{"a"}, {"b"}}, .values = Eigen::MatrixXd::Zero(2, 1000)};
  for (Eigen::Index k = 0; k < 500; ++k) {
    record.values(0, k) = std::sin(0.3 * static_cast<double>(k));
    record.values(1, k) = std::cos(0.3 * static_cast<double>(k));
  }
  for (Eigen::Index k = 500; k < 1000; ++k) record.values(1, k) = 1e-3 * (k % 2 == 0 ? 1.0 : -1.0);
  EXPECT_TRUE(constant_stretches(record).empty());
  record.values.row(1).tail(500) = record.values.row(1).head(500).eval();
  const auto found = constant_stretches(record);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].channel, 0);
  EXPECT_EQ(found[0].end, 1000);
}

TEST(SensorEvents, ASlowerChannelLacksOnlyWhatItsOwnRateWouldGive) {
  Record record{.sample_rate = 1000.0, .channels = {{"a"}, {"b"}}, .values = Eigen::MatrixXd::Ones(2, 4000)};
  for (Eigen::Index k = 0; k < 4000; ++k)
    if (k % 40 != 0) record.values(1, k) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(missing_samples(record).empty());
  record.values(1, 400) = record.values(1, 440) = record.values(1, 2000) = std::numeric_limits<double>::quiet_NaN();
  const auto events = missing_samples(record);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::missing);
  EXPECT_EQ(events[0].count, 3);
}

}  // namespace
}  // namespace kalfem
