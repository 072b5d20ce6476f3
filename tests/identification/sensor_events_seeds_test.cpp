// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "identification/chain_structure.hpp"
#include "identification/spoilt_record.hpp"
#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {
namespace {

RecordEstimate estimate_of(const EstimationProblem& given, const Record& record) {
  const auto problem = test::shared(given);
  IssueList issues;
  const auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  return estimate_record(problem, setup, record);
}

/// What the seeds of one kind of record gave.
struct Seeds {
  double largest_error = 0.0, largest_distance = 0.0;  ///< relative; in robust deviations
  int wrong_events = 0;                                ///< records whose events are not those that were put in
};

bool has_the_events(const std::vector<SensorEvent>& events, test::Spoilt spoilt) {
  int dead = 0, dropouts = 0, outliers = 0, others = 0;
  for (const auto& event : events) {
    const double tolerance = spoilt == test::Spoilt::holds_zero ? 0.006 : 0.1;
    if (event.kind == EventKind::dead && event.channel == "a6")
      dead += std::abs(event.from - 8.0) < tolerance ? 1 : 0;
    else if (event.kind == EventKind::dropout && event.channel.empty())
      dropouts += std::abs(event.from - 5.0) < 1e-9 && std::abs(event.to - 5.999) < 1e-9 ? 1 : 0;
    else if (event.kind == EventKind::outliers)
      ++outliers;
    else if (event.kind != EventKind::missing)
      ++others;
  }
  return dead == 1 && dropouts == 1 && outliers == 4 && others == 0;
}

Seeds run_seeds(double noise, test::Spoilt spoilt) {
  Seeds seeds;
  auto problem = test::spoilt_problem();
  for (auto& sensor : problem.sensors) sensor.noise = noise;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto estimate = estimate_of(problem, test::spoilt_chain_record(problem, 12.0, seed, spoilt));
    EXPECT_FALSE(estimate.result.failure);
    const double truth[] = {test::true_mu_k1, test::true_mu_c1};
    for (Eigen::Index i = 0; i < 2; ++i) {
      const double error =
          std::abs(estimate.result.unknowns.mean.col(estimate.result.unknowns.mean.cols() - 1)[i] - truth[i]);
      seeds.largest_error = std::max(seeds.largest_error, error / truth[i]);
      seeds.largest_distance = std::max(seeds.largest_distance, error / estimate.robust_deviation[i]);
    }
    if (!has_the_events(estimate.events, spoilt)) ++seeds.wrong_events;
  }
  return seeds;
}

class SpoiltSeeds : public testing::TestWithParam<std::pair<double, test::Spoilt>> {};

TEST_P(SpoiltSeeds, StayWithinTwoPerCentAndThreeDeviations) {
  const auto [noise, spoilt] = GetParam();
  const auto seeds = run_seeds(noise, spoilt);
  RecordProperty("largest_error", std::to_string(seeds.largest_error));
  std::printf("noise %.2f: largest error %.2f %%, %.2f robust deviations; other events than put in: %d of 20\n", noise,
              100.0 * seeds.largest_error, seeds.largest_distance, seeds.wrong_events);
  EXPECT_LT(seeds.largest_error, 0.02);
  EXPECT_LT(seeds.largest_distance, 3.0);
  EXPECT_EQ(seeds.wrong_events, 0);
}

INSTANTIATE_TEST_SUITE_P(NoiseAndDeath, SpoiltSeeds,
                         testing::Values(std::pair{0.05, test::Spoilt::holds_zero},
                                         std::pair{0.05, test::Spoilt::noise_only},
                                         std::pair{0.15, test::Spoilt::holds_zero},
                                         std::pair{0.15, test::Spoilt::noise_only}));

}  // namespace
}  // namespace kalfem
