// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <cmath>
#include <iostream>
#include <numbers>

#include <fmt/format.h>

#include "calibration_runs.hpp"
#include "kalfem/base/random.hpp"
#include "true_system.hpp"

// A chain of five masses on a strut that stiffens, each with an accelerometer, over a minute. The clock of one of them,
// or of a rack of two, runs 50 ppm fast or slow: 3 ms after a minute.

namespace kalfem::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double pi = std::numbers::pi, rate = 200.0, duration = 60.0, drift = 50e-6;
constexpr Index masses = 5, samples = static_cast<Index>(rate * duration) + 1, finer = 4;

struct Case {
  Structure structure;
  Record record;
  EstimateOptions options;
  double signed_drift = 0.0;
};

/// A channel between samples that are `finer` times as close, by the cubic through four of them.
double between(const Eigen::Ref<const VectorXd>& values, double place) {
  const Index i = std::clamp<Index>(static_cast<Index>(place), 1, values.size() - 3);
  const double s = place - static_cast<double>(i);
  return values[i - 1] * -s * (s - 1.0) * (s - 2.0) / 6.0 + values[i] * (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0 -
         values[i + 1] * (s + 1.0) * s * (s - 2.0) / 2.0 + values[i + 2] * (s + 1.0) * s * (s - 1.0) / 6.0;
}

/// `off`: sensors whose clock drifts.
Case make(std::uint64_t seed, const std::vector<Index>& off) {
  RandomStream stream(seed, "clocks");
  const auto within = [&](double lower, double upper) { return lower + (upper - lower) * stream.uniform(); };
  TrueSystem system;
  system.mass = system.damping = system.stiffness = MatrixXd::Zero(masses, masses);
  VectorXd m(masses), k(masses), c(masses);
  for (Index i = 0; i < masses; ++i) {
    m[i] = within(1.0, 3.0);
    k[i] = within(8e3, 2.5e4);
    c[i] = 2.0 * within(0.02, 0.05) * std::sqrt(k[i] * m[i]);
    VectorXd b = VectorXd::Unit(masses, i);
    if (i > 0) b[i - 1] = -1.0;
    system.mass(i, i) = m[i];
    system.stiffness += k[i] * b * b.transpose();
    system.damping += c[i] * b * b.transpose();
  }
  const double k3 = within(0.2, 0.6) * k[0] / 1e-6;
  system.local.push_back({VectorXd::Unit(masses, 0), [=](double d, double, double) { return k3 * d * d * d; }});
  std::vector<std::pair<double, double>> sines;
  for (int i = 0; i < 60; ++i) sines.emplace_back(2.0 * pi * within(1.0, 25.0), 2.0 * pi * stream.uniform());
  const Index place = static_cast<Index>(stream.uniform() * masses);
  const auto force = [=](double t) {
    double sum = 0.0;
    for (const auto& [omega, phase] : sines) sum += std::sin(omega * t + phase);
    return 2.0 * std::min(1.0, t) * sum;
  };
  system.load = [=](double t) { return VectorXd(VectorXd::Unit(masses, place) * force(t)); };
  const TrueMotion motion = integrate(system, finer * rate, finer * (samples - 1) + 9, 1);

  Case made;
  made.signed_drift = stream.uniform() < 0.5 ? -drift : drift;
  LumpedPart part = lumped("s");
  const auto name = [](Index i) { return fmt::format("m{}", i); };
  for (Index i = 0; i < masses; ++i) part.mass(name(i), m[i]);
  for (Index i = 1; i < masses; ++i) part.spring(fmt::format("k{}", i), name(i - 1), name(i), k[i], c[i]);
  made.structure.add(part);
  made.structure.connect("strut", "ground", "s.m0", law("cubic", {{"k", k[0]}, {"k3", k3}, {"c", c[0]}, {"c3", 0.0}}));
  Samples given{VectorXd(samples), rate, 0.0};
  for (Index j = 0; j < samples; ++j) given.values[j] = force(static_cast<double>(j) / rate);
  made.structure.force("u", "s." + name(place), given);
  made.record.sample_rate = rate;
  made.record.values.resize(masses, samples);
  for (Index i = 0; i < masses; ++i) {
    const VectorXd fine = motion.acceleration.row(i).transpose();
    const bool drifts = std::ranges::find(off, i) != off.end();
    VectorXd values(samples);
    for (Index j = 0; j < samples; ++j) {
      const double at = static_cast<double>(finer * j);
      values[j] = drifts ? between(fine, at / (1.0 + made.signed_drift)) : fine[finer * j];
    }
    const double noise = 0.02 * values.norm() / std::sqrt(static_cast<double>(samples));
    for (double& value : values) value += noise * stream.normal();
    made.record.values.row(i) = values.transpose();
    made.record.channels.push_back({"a" + name(i), "m/s^2"});
    made.options.sensors.push_back({"a" + name(i), acceleration("s." + name(i)), noise});
  }
  for (const auto& [unknown, value] : {std::pair{"strut.k", k[0]}, {"strut.k3", k3}})
    made.options.unknowns.push_back(
        {unknown, {.initial = value * std::exp(0.1 * stream.normal()), .std = 0.15 * value}});
  return made;
}

std::string words_of(const Verdict& verdict) {
  return verdict.reasons().empty() ? "no reason"
                                   : verdict.reasons().front().code + ": " + verdict.reasons().front().text;
}

/// The first reason names the channel's drift.
TEST(Clocks, ADriftIsNamedFirst) {
  const int first = number("KALFEM_FIRST", 1), runs = number("KALFEM_COUNT", 4);
  int named = 0;
  for (int seed = first; seed < first + runs; ++seed) {
    const Index off = seed % masses;
    const auto given = make(static_cast<std::uint64_t>(seed), {off});
    const auto found = estimate(given.structure, given.record, given.options);
    const std::string sensor = fmt::format("am{}", off);
    const auto reasons = found.verdict.reasons();
    const bool is_named = !reasons.empty() &&
                          ((reasons.front().code == "sensor_drift" && reasons.front().subject == sensor) ||
                           (reasons.front().code == "fixed_parameter" && reasons.front().subject == sensor + ".drift"));
    named += is_named ? 1 : 0;
    if (!is_named || seed == first)
      std::cout << fmt::format("{} {} {:+.0f} ppm: {}{}\n", seed, sensor, 1e6 * given.signed_drift,
                               words_of(found.verdict), codes_of(found.verdict))
                << std::flush;
  }
  std::cout << fmt::format("the drift of a clock is named first in {} of {}\n", named, runs);
  EXPECT_GE(named, 0.95 * runs);
}

TEST(Clocks, ADriftIsFoundAsAnUnknown) {
  const int first = number("KALFEM_FIRST", 1), runs = number("KALFEM_COUNT", 3);
  int near = 0, held = 0;
  for (int seed = first; seed < first + runs; ++seed) {
    const Index off = seed % masses;
    auto given = make(static_cast<std::uint64_t>(seed), {off});
    given.options.diagnose = false;
    given.options.unknowns.push_back({fmt::format("sensors.am{}.drift", off), {.initial = 0.0, .std = 100e-6}});
    const auto found = estimate(given.structure, given.record, given.options);
    const auto& clock = found.parameter(given.options.unknowns.back().name);
    const double deviation = (clock.interval_95.upper - clock.interval_95.lower) / (2.0 * 1.96),
                 error = (clock.mean - given.signed_drift) / deviation;
    near += std::abs(error) < 3.0 ? 1 : 0;
    held += holds(clock, given.signed_drift) ? 1 : 0;
    std::cout << fmt::format("{}: {:+.3g} ppm +- {:.2g}, {:.2f} deviations\n", seed, 1e6 * clock.mean, 1e6 * deviation,
                             error)
              << std::flush;
  }
  std::cout << fmt::format("{} of {} drifts within 3 deviations, {} intervals hold\n", near, runs, held);
  EXPECT_GE(near, runs - runs / 100);
  EXPECT_TRUE(is_binomial(held, runs));
}

/// Two channels of one rack are named together.
TEST(Clocks, ARackIsNamed) {
  const auto given = make(7, {1, 3});
  const auto found = estimate(given.structure, given.record, given.options);
  ASSERT_FALSE(found.verdict.reasons().empty());
  EXPECT_EQ(found.verdict.reasons().front().code, "sensor_drift") << words_of(found.verdict);
  EXPECT_EQ(found.verdict.reasons().front().subject, "am1, am3");
}

TEST(Clocks, TrueOnesAreNotDoubted) {
  const int first = number("KALFEM_FIRST", 1), runs = number("KALFEM_COUNT", 2);
  int doubted = 0;
  for (int seed = first; seed < first + runs; ++seed) {
    const auto given = make(static_cast<std::uint64_t>(seed), {});
    const auto found = estimate(given.structure, given.record, given.options);
    const bool doubts = std::ranges::any_of(found.verdict.reasons(), [](const auto& each) {
      return each.code == "sensor_drift" || each.subject.ends_with(".drift");
    });
    doubted += doubts ? 1 : 0;
    if (doubts) std::cout << seed << " " << words_of(found.verdict) << "\n" << std::flush;
  }
  std::cout << fmt::format("{} of {} true clocks doubted\n", doubted, runs);
  EXPECT_LE(doubted, 0.02 * runs);
}

}  // namespace
}  // namespace kalfem::calibration
