// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/spectrum_pair.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double rate = 200.0;

VectorXd white(const char* name, Index count) {
  RandomStream stream(1, name);
  VectorXd values(count);
  for (double& value : values) value = stream.normal();
  return values;
}

TEST(SpectrumPair, DensitiesOfWhiteNoiseAreLevelAndAddUpToTheVariance) {
  const VectorXd x = white("x", 40000), y = 0.5 * white("y", 40000);
  const auto pair = spectrum_pair(x, y, rate, 400);
  const double spacing = rate / 400.0;
  EXPECT_EQ(pair.lines.size(), 199);
  EXPECT_NEAR(pair.lines[0], spacing, 1e-12);
  EXPECT_EQ(pair.segments, 199);
  // 199 overlapping segments are worth about 190: the mean of all lines scatters by half a per cent.
  EXPECT_NEAR(pair.first.mean(), 2.0 / rate, 0.02 * 2.0 / rate);
  EXPECT_NEAR(pair.first.sum() * spacing, 1.0, 0.02);
  EXPECT_NEAR(pair.second.sum() * spacing, 0.25, 0.005);
  EXPECT_NEAR(pair.difference.sum() * spacing, 1.25, 0.03);
}

TEST(SpectrumPair, CoherenceIsTheShareThatTheSignalsHaveInCommon) {
  const VectorXd x = white("x", 40000), y = 2.0 * x + white("n", 40000);
  const auto pair = spectrum_pair(x, y, rate, 400);
  EXPECT_NEAR(pair.coherence.mean(), 4.0 / 5.0, 0.01);
  EXPECT_LT(spectrum_pair(x, white("other", 40000), rate, 400).coherence.mean(), 0.02);
}

TEST(SpectrumPair, ASineStandsAtItsLine) {
  VectorXd sine(4000);
  for (Index k = 0; k < sine.size(); ++k)
    sine[k] = std::sin(2.0 * std::numbers::pi * 25.0 * static_cast<double>(k) / rate);
  const auto pair = spectrum_pair(sine, sine, rate, 400);
  Index peak = 0;
  pair.first.maxCoeff(&peak);
  EXPECT_NEAR(pair.lines[peak], 25.0, 1e-9);
  EXPECT_NEAR(pair.first.sum() * rate / 400.0, 0.5, 1e-3);
  EXPECT_NEAR(pair.difference.maxCoeff(), 0.0, 1e-20);
}

TEST(SpectrumPair, SegmentsWithAMissingSampleAreLeftOut) {
  VectorXd x = white("x", 4000);
  const VectorXd y = white("y", 4000);
  x[1000] = std::nan("");
  const auto pair = spectrum_pair(x, y, rate, 400);
  EXPECT_EQ(pair.segments, 17);  // of 19: two hold the sample
  EXPECT_TRUE(pair.first.allFinite());
}

TEST(SpectrumPair, IsEmptyWithoutAnySegment) {
  EXPECT_EQ(spectrum_pair(white("x", 100), white("y", 100), rate, 400).segments, 0);
  const VectorXd missing = VectorXd::Constant(4000, std::nan(""));
  EXPECT_EQ(spectrum_pair(missing, missing, rate, 400).lines.size(), 0);
}

}  // namespace
}  // namespace kalfem
