// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <complex>
#include <random>

#include "chain.hpp"

// A force with content near half its sampling rate, which its samples determine only where others follow.

namespace kalfem {
namespace {

constexpr double mass = 1.0, stiffness = 35.53e3, damping = 8.0;  // 30 Hz, 2.1 %
constexpr double rate = 100.0;                                    // [Hz]
constexpr Eigen::Index samples = 1001;

/// Force and steady acceleration of the oscillator, in closed form.
Record oscillator_under_sines(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> frequency(3.0, 42.0), phase(0.0, 2.0 * EIGEN_PI);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(samples), motion = force;
  for (int i = 0; i < 60; ++i) {
    const double w = 2.0 * EIGEN_PI * frequency(random), p = phase(random);
    const std::complex<double> accelerance = -w * w / std::complex(stiffness - w * w * mass, w * damping);
    for (Eigen::Index k = 0; k < samples; ++k) {
      const auto turn = std::polar(10.0, w * static_cast<double>(k) / rate + p);
      force[k] += turn.imag();
      motion[k] += (accelerance * turn).imag();
    }
  }
  std::normal_distribution<double> noise(0.0, 0.5);
  for (double& value : motion) value += noise(random);
  return make_record(rate, {{"force", force}, {"a", motion}});
}

TEST(FastForce, IsNotLearnedFromWhereItIsNotDetermined) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Record record = oscillator_under_sines(seed);
    Structure s;
    s.add(lumped("o").mass("m", mass));
    s.connect("spring", "o.m", "o.ground", law("linear", {{"k", 33e3}, {"c", 10.0}}));
    s.force("shaker", "o.m", Samples{record.values.row(0).transpose(), rate, 0.0});
    EstimateOptions o;
    o.sensors = {{"a", acceleration("o.m"), 0.5}};
    o.unknowns = {{"spring.k", {.initial = 34e3, .std = 3e3}}, {"spring.c", {.initial = 10.0, .std = 5.0}}};
    const auto result = estimate(s, record, o);
    EXPECT_EQ(result.verdict.state(), VerdictState::consistent) << seed;
    EXPECT_NEAR(result.parameters[0].mean, stiffness, 4.0 * result.parameters[0].std);
    EXPECT_NEAR(result.parameters[1].mean, damping, 4.0 * result.parameters[1].std);
    EXPECT_EQ(result.used.rightCols(10).sum(), 0);
    EXPECT_EQ(result.used.leftCols(samples - 33).minCoeff(), 1);
  }
}

}  // namespace
}  // namespace kalfem
