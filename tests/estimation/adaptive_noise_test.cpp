// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/adaptive_noise.hpp"

#include <gtest/gtest.h>

#include "estimation/adaptive_chain.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/estimation/smoother/smoother.hpp"

// Filters that find their noise along the record of the chain.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr AdaptiveNoiseOptions both{.sensors = true, .process = true}, sensors_only{.sensors = true};

const AdaptiveChain& setting() {
  static const AdaptiveChain one;
  return one;
}

const FilterInput& disturbed() {
  static const FilterInput one = setting().record(setting().disturbed, 1);
  return one;
}

FilterInput with_noise(FilterInput input, double factor) {
  input.noise *= factor * factor;
  return input;
}

void expect_right(const EstimationResult& result, const std::string& what) {
  ASSERT_FALSE(result.failure) << what;
  EXPECT_NEAR(relative_nis(result), 1.0, 0.1) << what;
  EXPECT_LT(worst_error(result), 3.0) << what;
  testing::Test::RecordProperty(what, std::to_string(relative_nis(result)) + " " + std::to_string(worst_error(result)));
}

class AdaptiveFilters : public testing::TestWithParam<FilterKind> {};

TEST_P(AdaptiveFilters, FindSensorNoiseThatIsStatedTenTimesTooSmallOrTooLarge) {
  const auto record = setting().record(setting().undisturbed, 1);
  for (const double factor : {0.1, 10.0}) {
    const auto result = setting().run(with_noise(record, factor), sensors_only, 0.01, GetParam());
    expect_right(result, to_string(GetParam()) + " noise x " + std::to_string(factor));
    const VectorXd found = result.noise->sensors.rightCols(1);
    for (Index i = 0; i < found.size(); ++i)
      EXPECT_NEAR(found[i] / std::sqrt(record.noise(i, i)), 1.0, 0.15) << factor << " sensor " << i;
  }
}

TEST_P(AdaptiveFilters, FindTheProcessNoiseThatForcesMakeWhichTheModelLeavesOut) {
  for (const double stated : {0.0, 0.01, 1.0}) {
    const auto result = setting().run(disturbed(), both, stated, GetParam());
    expect_right(result, to_string(GetParam()) + " process noise " + std::to_string(stated));
    const Index last = result.noise->process_factor.size() - 1;
    EXPECT_NEAR(std::log(result.noise->density_at(last) / AdaptiveChain::density), 0.0, std::log(2.0)) << stated;
    EXPECT_EQ(result.noise->density_is_stated, stated > 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Filters, AdaptiveFilters,
                         testing::Values(FilterKind::partially_linear, FilterKind::unscented,
                                         FilterKind::unscented_square_root, FilterKind::extended));

TEST(AdaptiveNoise, WithBothWrongFindsBoth) {
  for (const double factor : {0.1, 10.0})
    for (const double stated : {0.0, 1.0}) {
      const auto result = setting().run(with_noise(disturbed(), factor), both, stated);
      expect_right(result, "noise x " + std::to_string(factor) + ", process noise " + std::to_string(stated));
    }
}

TEST(AdaptiveNoise, WithoutAdaptationTheSameRecordsAreNotConsistent) {
  EXPECT_GT(relative_nis(setting().run(disturbed(), {}, 0.0)), 1.3);
  EXPECT_GT(relative_nis(setting().run(with_noise(disturbed(), 0.1), {}, 0.1)), 1.3);
}

TEST(AdaptiveNoise, IsScoredBeforeItLearns) {
  const auto record = with_noise(disturbed(), 10.0);
  const auto plain = setting().run(record, {}, 0.1), adaptive = setting().run(record, both, 0.1);
  EXPECT_EQ(adaptive.nis[0], plain.nis[0]);
  EXPECT_EQ(adaptive.noise->sensors(0, 0), std::sqrt(record.noise(0, 0)));
  EXPECT_EQ(adaptive.noise->process_factor[0], 1.0);
  EXPECT_NE(adaptive.nis[1], plain.nis[1]);
}

TEST(AdaptiveNoise, DoesNotDependOnTheSamplingRate) {
  const AdaptiveChain slow(500.0);
  const auto result = slow.run(with_noise(slow.record(slow.disturbed, 1), 0.1), both, 0.0);
  expect_right(result, "500 Hz");
  const Index last = result.noise->process_factor.size() - 1;
  EXPECT_NEAR(std::log(result.noise->density_at(last) / AdaptiveChain::density), 0.0, std::log(2.0));
}

TEST(AdaptiveNoise, TheSmootherTakesTheNoiseOfEachSample) {
  auto input = with_noise(disturbed(), 3.0);
  const Index samples = 1500;
  input.measured.values = input.measured.values.leftCols(samples).eval();
  input.inputs = input.inputs.leftCols(4 * (samples - 1) + 1).eval();
  auto options = setting().chain.options();
  options.substeps = 4;
  options.coordinates = StateCoordinates::modal;
  options.process_noise.acceleration.setConstant(0.01);
  const AugmentedModel model(setting().chain.model.system(), setting().chain.sensors, {}, options);
  const EstimationOptions of_filter{.filter = FilterKind::partially_linear, .adaptive_noise = both};
  const auto filtered = estimate(model, input, of_filter);
  ASSERT_FALSE(filtered.failure);
  ASSERT_GT(std::abs(std::log(filtered.noise->process_factor[samples - 1])), 0.5);
  const auto smoothed = smooth(model, input, of_filter, filtered);
  ASSERT_TRUE(smoothed);
  // The last smoothed estimate is the filter's, which only a replay with the same noise reproduces.
  const VectorXd end = filtered.state.mean.col(samples - 1);
  EXPECT_LT((smoothed->state.mean.col(samples - 1) - end).norm(), 1e-9 * end.norm());
  EXPECT_LT((smoothed->state.deviation.col(samples - 1) - filtered.state.deviation.col(samples - 1)).norm(),
            1e-7 * filtered.state.deviation.col(samples - 1).norm());
}

TEST(AdaptiveNoise, RefusesWhatItCannotDo) {
  const auto refused = [](const EstimationOptions& options) {
    auto own = setting().chain.options();
    own.keep_initial_state = true;
    return !validate(AugmentedModel(setting().chain.model.system(), setting().chain.sensors, {}, own), options).empty();
  };
  EXPECT_FALSE(refused({.adaptive_noise = both}));
  EXPECT_TRUE(refused({.passes = 2, .adaptive_noise = both}));
  EXPECT_TRUE(refused({.adaptive_noise = {.sensors = true, .memory = 0.0}}));
  EXPECT_TRUE(refused({.unscented = {.update_iterations = 0}}));
}

}  // namespace
}  // namespace kalfem
