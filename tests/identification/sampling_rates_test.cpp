// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "identification/chain_structure.hpp"
#include "kalfem/diagnosis/judge_estimation.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/records/common_grid.hpp"
#include "kalfem/system/signals/sampled.hpp"

// Sensors with sampling rates of their own, and samples at uneven times.
namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

RecordEstimate estimate_of(const EstimationProblem& given, const Record& record) {
  auto own = given;
  own.sample_rate = record.sample_rate;
  const auto problem = test::shared(own);
  IssueList issues;
  const auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  return estimate_record(problem, setup, record);
}

void expect_the_truth(const RecordEstimate& estimate) {
  ASSERT_FALSE(estimate.result.failure);
  const VectorXd estimates = estimate.result.unknowns.mean.rightCols(1);
  const double truth[] = {test::true_mu_k1, test::true_mu_c1};
  for (Index i = 0; i < 2; ++i) {
    EXPECT_NEAR(estimates[i], truth[i], 0.02 * truth[i]);
    EXPECT_NEAR(estimates[i], truth[i], 3.0 * estimate.robust_deviation[i]);
  }
  EXPECT_NEAR(estimate.consistency.mean_nis / estimate.consistency.expected_nis, 1.0, 0.1);
  EXPECT_TRUE(estimate.events.empty());
  const auto verdict = verdict_of(estimate);
  EXPECT_EQ(verdict.state(), VerdictState::consistent) << (verdict.reasons().empty() ? "" : verdict.reasons()[0].text);
}

TEST(SamplingRates, OfEachSensorGiveTheParameters) {
  auto problem = test::chain_problem();
  problem.settings.settle = 1.0;
  Record record = test::chain_record(problem, 8.0);
  for (const auto& [row, step] : {std::pair<Index, Index>{1, 2}, {2, 3}})
    for (Index k = 0; k < record.samples(); ++k)
      if (k % step != 0) record.values(row, k) = std::numeric_limits<double>::quiet_NaN();
  expect_the_truth(estimate_of(problem, record));
}

/// The record at times that jitter by at most a quarter of an interval, on the grid that they need.
Record at_uneven_times(const Record& clean) {
  RandomStream random(3, "jitter");
  SampleTimes times{.times = VectorXd(clean.samples()), .count = clean.samples()};
  for (Index k = 0; k < times.count; ++k)
    times.times[k] = std::clamp(clean.time(k) + (0.5 * random.uniform() - 0.25) / clean.sample_rate, 0.0, clean.end());
  const CommonGrid grid = common_grid({times});
  Record record{.sample_rate = grid.sample_rate, .start = grid.start, .channels = clean.channels};
  record.values.setConstant(clean.values.rows(), static_cast<Index>(grid.last) + 1,
                            std::numeric_limits<double>::quiet_NaN());
  const auto places = places_on(grid, times);
  for (Index i = 0; i < clean.values.rows(); ++i) {
    const auto signal = make_sampled(clean.values.row(i).transpose(), {.sample_rate = clean.sample_rate});
    const double noise = clean.channels[static_cast<std::size_t>(i)].noise;
    for (Index k = 0; k < times.count; ++k)
      record.values(i, places[static_cast<std::size_t>(k)]) =
          signal->sample(times.times[k], 1.0, 1)(0, 0) + noise * random.normal();
  }
  return record;
}

TEST(SamplingRates, SamplesAtUnevenTimesGiveTheParameters) {
  auto problem = test::chain_problem();
  problem.settings.settle = 1.0;
  expect_the_truth(estimate_of(problem, at_uneven_times(test::chain_record(problem, 8.0, false))));
}

}  // namespace
}  // namespace kalfem
