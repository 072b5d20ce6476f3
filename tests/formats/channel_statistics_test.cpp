// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/channel_statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double rate = 200.0, nan = std::numeric_limits<double>::quiet_NaN();

/// 3 sin(2 pi 7.3 t) + noise about an offset of 0.5.
MeasuredChannel sine(Index samples = 4000, double noise = 0.01) {
  RandomStream random(1, "noise");
  MeasuredChannel channel{.name = "a", .interval = 1.0 / rate};
  channel.values.resize(samples);
  for (Index k = 0; k < samples; ++k)
    channel.values[k] = 0.5 + 3.0 * std::sin(2.0 * std::numbers::pi * 7.3 * double(k) / rate) + noise * random.normal();
  return channel;
}

void expect_nothing_odd(const ChannelStatistics& found) {
  EXPECT_EQ(found.dead, DeadReason::none);
  EXPECT_FALSE(found.clipped_above);
  EXPECT_FALSE(found.clipped_below);
  EXPECT_FALSE(found.hold);
  EXPECT_FALSE(found.drifts());
  EXPECT_EQ(found.missing, 0);
}

TEST(ChannelStatistics, HoldSizeOffsetAndFrequencyOfASine) {
  const auto found = statistics_of(sine());
  expect_nothing_odd(found);
  EXPECT_EQ(found.samples, 4000);
  EXPECT_DOUBLE_EQ(found.time.rate, rate);
  EXPECT_NEAR(found.time.duration, 3999.0 / rate, 1e-9);
  EXPECT_NEAR(found.offset, 0.5, 1e-3);
  EXPECT_NEAR(found.rms, 3.0 / std::sqrt(2.0), 1e-2);
  EXPECT_NEAR(found.peak, 3.0, 0.06);
  ASSERT_EQ(found.frequencies.size(), 1u);
  EXPECT_NEAR(found.frequencies[0].frequency, 7.3, 0.01);
  EXPECT_NEAR(found.frequencies[0].share, 1.0, 0.05);
}

TEST(ChannelStatistics, NameTheStrongestFrequencyFirst) {
  auto channel = sine();
  for (Index k = 0; k < channel.values.size(); ++k)
    channel.values[k] += 4.0 * std::sin(2.0 * std::numbers::pi * 21.0 * double(k) / rate);
  const auto found = statistics_of(channel);
  ASSERT_EQ(found.frequencies.size(), 2u);
  EXPECT_NEAR(found.frequencies[0].frequency, 21.0, 0.01);
  EXPECT_NEAR(found.frequencies[1].frequency, 7.3, 0.01);
}

TEST(ChannelStatistics, TellTheFrequencyOfAShortSquareWave) {
  MeasuredChannel channel{.name = "f", .interval = 1.0 / rate, .values = VectorXd(2800)};
  for (Index k = 0; k < 2800; ++k)
    channel.values[k] =
        (std::sin(2.0 * std::numbers::pi * 0.5 * double(k) / rate) > 0.0 ? 1.0 : -1.0) + 1e-3 * double(k % 7);
  const auto found = statistics_of(channel);
  ASSERT_FALSE(found.frequencies.empty());
  EXPECT_NEAR(found.frequencies[0].frequency, 0.5, 0.02);
}

TEST(ChannelStatistics, SeeClippingOfFineAndOfCoarseNumbers) {
  for (const double step : {0.0, 3.0 / 128.0, 3.0 / 32768.0}) {
    auto whole = sine();
    if (step > 0.0) whole.values = (whole.values / step).array().round() * step;
    expect_nothing_odd(statistics_of(whole));
    auto clipped = whole;
    clipped.values = clipped.values.cwiseMin(2.8);
    const auto found = statistics_of(clipped);
    ASSERT_TRUE(found.clipped_above) << step;
    EXPECT_FALSE(found.clipped_below) << step;
    EXPECT_NEAR(found.clipped_above->level, 2.8, 1e-9);
    EXPECT_NEAR(double(found.clipped_above->times), 4000.0 / rate * 7.3, 1.0);
    EXPECT_EQ(found.clipped_above->samples, (whole.values.array() >= 2.8).count());
  }
}

TEST(ChannelStatistics, SeeClippingOfNoiseThatStaysForSingleSamples) {
  RandomStream random(2, "noise");
  MeasuredChannel channel{.name = "n", .interval = 0.01, .values = VectorXd(5000)};
  for (double& value : channel.values) value = random.normal();
  expect_nothing_odd(statistics_of(channel));
  channel.values = channel.values.cwiseMax(-2.0);
  const auto found = statistics_of(channel);
  EXPECT_TRUE(found.clipped_below);
  EXPECT_FALSE(found.clipped_above);
}

TEST(ChannelStatistics, TakeAHeldStructureAndPulsesFromZeroForWhole) {
  auto released = sine();
  released.values.head(500).setConstant(released.values.maxCoeff());
  EXPECT_FALSE(statistics_of(released).clipped_above);
  auto pulses = sine();
  pulses.values = pulses.values.cwiseMax(0.0);
  EXPECT_FALSE(statistics_of(pulses).clipped_below);
}

TEST(ChannelStatistics, CountMissingSamples) {
  auto channel = sine();
  channel.values[10] = nan;
  channel.values.segment(100, 25).setConstant(nan);
  const auto found = statistics_of(channel);
  EXPECT_EQ(found.missing, 26);
  EXPECT_EQ(found.missing_stretches, 2);
  EXPECT_EQ(found.longest_missing, 25);
  EXPECT_NEAR(found.rms, 3.0 / std::sqrt(2.0), 1e-2);
  ASSERT_FALSE(found.frequencies.empty());
  EXPECT_NEAR(found.frequencies[0].frequency, 7.3, 0.02);
}

TEST(ChannelStatistics, SayWhyAChannelIsDead) {
  const auto dead = [](VectorXd values) {
    return statistics_of({.name = "d", .interval = 0.01, .values = std::move(values)}).dead;
  };
  EXPECT_EQ(dead(VectorXd()), DeadReason::no_samples);
  EXPECT_EQ(dead(VectorXd::Constant(5, nan)), DeadReason::no_numbers);
  EXPECT_EQ(dead(VectorXd::Constant(5, 0.25)), DeadReason::constant);
  VectorXd flicker = VectorXd::Zero(2000);
  for (Index k = 0; k < 2000; k += 200) flicker[k] = 1e-3;
  EXPECT_EQ(dead(flicker), DeadReason::two_levels);
  VectorXd relay = VectorXd::Zero(2000);
  relay.tail(900).setOnes();
  EXPECT_EQ(dead(relay), DeadReason::none);
}

TEST(ChannelStatistics, SeeASensorThatSticks) {
  auto channel = sine();
  channel.values.segment(1500, 80).setConstant(channel.values[1499]);
  const auto found = statistics_of(channel);
  ASSERT_TRUE(found.hold);
  EXPECT_EQ(found.hold->first, 1499);
  EXPECT_EQ(found.hold->samples, 81);
}

TEST(ChannelStatistics, MeasureDrift) {
  auto channel = sine();
  channel.values += VectorXd::LinSpaced(4000, 0.0, 20.0);
  const auto found = statistics_of(channel);
  EXPECT_TRUE(found.drifts());
  EXPECT_NEAR(found.drift, 20.0, 0.2);
}

TEST(TimeBase, CountsGapsAndJitterAgainstTheTypicalInterval) {
  auto channel = sine(1000);
  RandomStream random(3, "jitter");
  channel.times.resize(1000);
  double time = 5.0;
  for (Index k = 0; k < 1000; ++k) {
    channel.times[k] = time + 0.02 / rate * random.normal();
    time += (k == 399 ? 5.0 : 1.0) / rate;
  }
  const auto found = time_base(channel);
  EXPECT_NEAR(found.rate, rate, 0.01 * rate);
  EXPECT_NEAR(found.start, 5.0, 1e-3);
  EXPECT_EQ(found.gaps, 1);
  EXPECT_EQ(found.missing, 4);
  EXPECT_NEAR(found.longest_gap, 5.0 / rate, 0.2 / rate);
  EXPECT_NEAR(found.jitter, 0.02 * std::sqrt(2.0), 0.004);
  EXPECT_EQ(found.not_increasing, 0);
}

TEST(TimeBase, CountsTimesThatGoBack) {
  auto channel = sine(100);
  channel.times = VectorXd::LinSpaced(100, 0.0, 0.99);
  std::swap(channel.times[50], channel.times[51]);
  EXPECT_EQ(time_base(channel).not_increasing, 1);
}

TEST(TimeBase, SaysNothingWhereNothingIsKnown) {
  const MeasuredChannel channel{.name = "x", .values = VectorXd::Random(50)};
  EXPECT_EQ(time_base(channel).rate, 0.0);
  EXPECT_TRUE(statistics_of(channel).frequencies.empty());
  EXPECT_EQ(time_base({.name = "y"}).duration, 0.0);
}

/// Jitter of 4 % moves the median of the intervals by 0.04 %, and a gap the phase of what is behind it.
TEST(ChannelStatistics, RateAndFrequenciesDoNotSufferFromJitterAndGaps) {
  RandomStream random(3, "jitter");
  auto channel = sine(20000, 0.0);
  channel.interval = 0.0;
  channel.times.resize(20000);
  for (Index k = 0; k < 20000; ++k) channel.times[k] = (double(k) + 0.03 * random.normal()) / rate;
  EXPECT_NEAR(statistics_of(channel).time.rate, rate, 1e-4 * rate);
  EXPECT_NEAR(statistics_of(channel).frequencies.at(0).frequency, 7.3, 1e-3);

  auto cut = sine(4000, 0.0);
  cut.interval = 0.0;
  cut.times.resize(3000);
  VectorXd values(3000);
  for (Index k = 0; k < 3000; ++k) {
    const Index place = k < 1500 ? k : k + 1000;
    cut.times[k] = double(place) / rate;
    values[k] = cut.values[place];
  }
  cut.values = values;
  EXPECT_EQ(statistics_of(cut).time.gaps, 1);
  EXPECT_NEAR(statistics_of(cut).frequencies.at(0).frequency, 7.3, 5e-3);
}

}  // namespace
}  // namespace kalfem
