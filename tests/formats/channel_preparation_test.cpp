// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/channel_preparation.hpp"
#include "kalfem/records/gap_bridge.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/records/resampling.hpp"
#include "kalfem/records/zero_phase_filter.hpp"

// Offsets, trends, filters and lower sampling rates of measured channels, against closed forms.
namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

double sine(double frequency, double time) { return std::sin(2.0 * std::numbers::pi * frequency * time + 0.3); }

VectorXd sines(Index samples, double rate, double frequency, double start = 0.0) {
  VectorXd values(samples);
  for (Index k = 0; k < samples; ++k) values[k] = sine(frequency, start + double(k) / rate);
  return values;
}

PreparedRecord prepared_of(double rate, const VectorXd& values, double start = 0.0) {
  PreparedRecord prepared{make_record(rate, {{"a", values}}, start)};
  prepared.record.channels[0].unit = "m/s^2";
  return prepared;
}

TEST(ChannelPreparation, SubtractsTheMeanOfAPart) {
  VectorXd values = VectorXd::Constant(100, 0.75);
  values.tail(50).array() += 4.0;
  values[3] = not_a_number;
  auto prepared = prepared_of(10.0, values, 5.0);
  prepare_channels(prepared, {.offset = RecordPart{.to = 8.0}});
  EXPECT_NEAR(prepared.record.values(0, 0), 0.0, 1e-15);
  EXPECT_NEAR(prepared.record.values(0, 99), 4.0, 1e-14);
  EXPECT_TRUE(std::isnan(prepared.record.values(0, 3)));
  ASSERT_EQ(prepared.preparation.size(), 1U);
  EXPECT_EQ(prepared.preparation[0], "offsets subtracted, means from 5 s to 8 s: a 0.75 m/s^2");
}

TEST(ChannelPreparation, SubtractsALineDespiteMissingSamples) {
  VectorXd values = VectorXd::LinSpaced(101, 2.0, 7.0);
  values.segment(20, 30).setConstant(not_a_number);
  auto prepared = prepared_of(10.0, values);
  prepare_channels(prepared, {.trend = true});
  EXPECT_EQ(prepared.record.values.array().isNaN().count(), 30);
  EXPECT_NEAR(prepared.record.values(0, 0), 0.0, 1e-14);
  EXPECT_NEAR(prepared.record.values(0, 100), 0.0, 1e-14);
  EXPECT_NE(prepared.preparation[0].find("a 5 m/s^2"), std::string::npos) << prepared.preparation[0];
}

// The gain is the formula's, and a sine is not shifted: what is left is the continuation beyond the ends, far away.
TEST(ZeroPhaseFilter, HasTheGainOfButterworthAndNoPhase) {
  const double rate = 200.0;
  for (const double frequency : {1.0, 5.0, 10.0, 20.0, 40.0}) {
    const VectorXd signal = sines(8000, rate, frequency);
    const VectorXd low = filtered(signal, rate, {.low_pass = 10.0}), high = filtered(signal, rate, {.high_pass = 10.0});
    const double ratio = std::pow(frequency / 10.0, 8);
    const auto middle = Eigen::seqN(3000, 2000);
    // found 2e-6: the jumps of slope at the ends of the continuation
    EXPECT_LT((low(middle) - signal(middle) / std::sqrt(1.0 + ratio)).cwiseAbs().maxCoeff(), 2e-5) << frequency;
    EXPECT_LT((high(middle) - signal(middle) / std::sqrt(1.0 + 1.0 / ratio)).cwiseAbs().maxCoeff(), 2e-5) << frequency;
  }
}

TEST(ZeroPhaseFilter, KeepsMissingSamplesMissing) {
  VectorXd signal = sines(1000, 100.0, 2.0);
  signal.segment(500, 5).setConstant(not_a_number);
  const VectorXd low = filtered(signal, 100.0, {.low_pass = 10.0});
  EXPECT_EQ(low.array().isNaN().count(), 5);
  // found 3e-3: five samples of a sine as a straight line
  EXPECT_LT((low - signal).head(490).cwiseAbs().maxCoeff(), 0.01);
}

TEST(Resampling, KeepsThePassBandAndStopsAliases) {
  const double rate = 1000.0;
  for (const double new_rate : {500.0, 333.0 + 1.0 / 3.0, 128.0}) {
    const auto at = [&](double frequency) {
      return resampled(prepared_of(rate, sines(8000, rate, frequency, 2.0), 2.0).record, new_rate);
    };
    const Record kept = at(0.39 * new_rate), stopped = at(0.51 * new_rate);
    EXPECT_EQ(kept.sample_rate, new_rate);
    EXPECT_EQ(kept.start, 2.0);
    EXPECT_EQ(kept.samples(), Index(std::floor(7999.0 / rate * new_rate + 1e-6)) + 1);
    double error = 0.0, rest = 0.0;
    for (Index k = 100; k < kept.samples() - 100; ++k) {
      error = std::max(error, std::abs(kept.values(0, k) - sine(0.39 * new_rate, kept.time(k))));
      rest = std::max(rest, std::abs(stopped.values(0, k)));
    }
    EXPECT_LT(error, 3e-5) << new_rate;  // 90 dB
    EXPECT_LT(rest, 3e-5) << new_rate;
  }
}

TEST(Resampling, KeepsAConstantAndAnOldRate) {
  const auto record = prepared_of(100.0, VectorXd::Constant(500, 3.0)).record;
  EXPECT_LT((resampled(record, 37.0).values.array() - 3.0).abs().maxCoeff(), 1e-13);
  EXPECT_EQ(resampled(record, 100.0).values, record.values);
}

TEST(Resampling, LosesSamplesThatWereMissing) {
  VectorXd signal = sines(1000, 1000.0, 5.0);
  signal.segment(500, 40).setConstant(not_a_number);
  const Record lower = resampled(prepared_of(1000.0, signal).record, 100.0);
  const auto missing = lower.values.row(0).array().isNaN();
  EXPECT_TRUE(missing[50] && missing[51] && missing[52] && missing[53]);
  EXPECT_LT(missing.count(), 25);  // the kernel's side lobes
  EXPECT_FALSE(missing[20] || missing[80]);
}

// 40,000 samples: the variance is known to 2 % (three deviations), the correlation to 0.015.
TEST(Resampling, OfWhiteNoiseLeavesWhiteNoise) {
  RandomStream random(4, "resampling");
  VectorXd noise(200000);
  for (double& value : noise) value = random.normal();
  const VectorXd lower = resampled(prepared_of(1000.0, noise).record, 200.0).values.row(0).transpose();
  const double variance = lower.squaredNorm() / double(lower.size());
  EXPECT_NEAR(variance, 0.9 / 5.0, 0.02 * 0.18);
  const Index n = lower.size();
  EXPECT_NEAR(lower.head(n - 1).dot(lower.tail(n - 1)) / double(n) / variance, 0.12, 0.02);
}

TEST(ChannelPreparation, RefusesWhatCannotBe) {
  const auto refusal = [](const ChannelPreparation& asked) {
    auto prepared = prepared_of(100.0, sines(500, 100.0, 3.0));
    try {
      prepare_channels(prepared, asked);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal({.offset = RecordPart{.from = 7.0, .to = 8.0}}), "");
  EXPECT_NE(refusal({.high_pass = 50.0}).find("not below half of the sampling rate"), std::string::npos);
  EXPECT_NE(refusal({.high_pass = 20.0, .low_pass = 10.0}).find("nothing would be left"), std::string::npos);
  EXPECT_NE(refusal({.sample_rate = 200.0}).find("samples that were not measured"), std::string::npos);
  EXPECT_EQ(refusal({.offset = RecordPart{}, .trend = true, .high_pass = 1.0, .low_pass = 10.0, .sample_rate = 50.0}),
            "");
}

/// Samples between others lie on a spline through these; each other gap is told with its time and length.
TEST(GapBridge, FillsShortGapsAndNamesTheOthers) {
  PreparedRecord prepared{{.sample_rate = 100.0, .start = 2.0, .channels = {{"p", "N"}, {"q", "N"}}}};
  prepared.record.values.resize(2, 200);
  for (int k = 0; k < 200; ++k) prepared.record.values.col(k).setConstant(std::sin(0.1 * k));
  const PreparedRecord whole = prepared;
  for (const int k : {50, 51, 120}) prepared.record.values(0, k) = std::nan("");
  PreparedRecord bridged = prepared;
  bridge_gaps(bridged, 0.03);
  EXPECT_LT((bridged.record.values - whole.record.values).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_EQ(bridged.record.values.row(1), whole.record.values.row(1));
  EXPECT_EQ(bridged.preparation, std::vector<std::string>{"3 missing samples of 'p' bridged by a spline"});
  PreparedRecord ended = prepared;
  ended.record.values(1, 199) = std::nan("");
  try {
    bridge_gaps(ended, 0.02);
    FAIL();
  } catch (const InvalidInput& error) {
    ASSERT_EQ(error.issues().size(), 2u);
    EXPECT_NE(error.issues()[0].what.find("a gap of 0.03 s at 2.49 s"), std::string::npos) << error.what();
    EXPECT_NE(error.issues()[1].what.find("'q' has no value at its first or last sample"), std::string::npos);
  }
}

}  // namespace
}  // namespace kalfem
