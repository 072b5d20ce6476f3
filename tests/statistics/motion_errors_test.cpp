// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/motion_errors.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <numbers>
#include <random>

#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index samples = 1215;  // 3^5 5, odd: no line at half the sampling rate

VectorXd white(std::mt19937_64& generator, Index count) {
  std::normal_distribution<double> normal;
  return VectorXd::NullaryExpr(count, [&] { return normal(generator); });
}

/// Two resonances at a tenth and a fifth of the sampling rate.
VectorXd motion(std::mt19937_64& generator) {
  const VectorXd push = white(generator, samples);
  VectorXd sum = VectorXd::Zero(samples);
  for (const double frequency : {0.1, 0.2}) {
    const double a = 2.0 * 0.98 * std::cos(2.0 * std::numbers::pi * frequency), b = -0.98 * 0.98;
    double last = 0.0, before = 0.0;
    for (Index k = 0; k < samples; ++k) {
      const double now = push[k] + a * last + b * before;
      sum[k] += now;
      before = std::exchange(last, now);
    }
  }
  return sum;
}

// By Parseval, of an error g x all energy g^2 |x|^2 follows the prediction, and 99 % of it lie in the band.
TEST(MotionErrors, OfAGainAreItsEnergy) {
  std::mt19937_64 generator(3);
  const VectorXd x = motion(generator);
  const double gain = 0.03, energy = gain * gain * (x.array() - x.mean()).square().sum();
  const MotionErrors found = motion_errors(gain * x, x);
  EXPECT_NEAR(found.followed, energy, 1e-9 * energy);
  EXPECT_GE(found.in_band, 0.99 * energy);
  EXPECT_LE(found.in_band, energy);
}

TEST(MotionErrors, OfWhiteNoiseAreChiSquared) {
  constexpr int draws = 400;
  constexpr double chance = 0.05;
  int followed = 0, in_band = 0;
  for (int seed = 1; seed <= draws; ++seed) {
    std::mt19937_64 generator(static_cast<std::uint64_t>(seed));
    const VectorXd x = motion(generator);
    const MotionErrors found = motion_errors(white(generator, samples), x);
    EXPECT_LT(found.in_band_freedom, samples / 2);  // noise elsewhere does not count
    followed += found.followed > chi_squared_quantile(1.0 - chance, found.followed_freedom) ? 1 : 0;
    in_band += found.in_band > chi_squared_quantile(1.0 - chance, found.in_band_freedom) ? 1 : 0;
  }
  const double spread = 3.3 * std::sqrt(draws * chance * (1.0 - chance));  // one run in a thousand lies beyond
  EXPECT_NEAR(followed, draws * chance, spread);
  EXPECT_NEAR(in_band, draws * chance, spread);
}

// A prime number of samples, of which the first do not count.
TEST(MotionErrors, OfAnyLengthAreThoseOfItsEnd) {
  std::mt19937_64 generator(5);
  const VectorXd x = motion(generator).tail(1201), e = white(generator, 1201);
  const MotionErrors all = motion_errors(e, x), end = motion_errors(e.tail(1200), x.tail(1200));
  EXPECT_EQ(all.followed, end.followed);
  EXPECT_EQ(all.in_band, end.in_band);
}

TEST(MotionErrors, WithoutMotionSayNothing) {
  const MotionErrors found = motion_errors(VectorXd::Ones(100), VectorXd::Zero(100));
  EXPECT_EQ(found.followed_freedom, 0.0);
  EXPECT_EQ(found.in_band_freedom, 0.0);
}

}  // namespace
}  // namespace kalfem
