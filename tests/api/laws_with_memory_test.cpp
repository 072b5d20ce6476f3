// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <iostream>
#include <numbers>

#include "chain.hpp"
#include "kalfem/base/random.hpp"
#include "system/masing_branches.hpp"

// A mass on a strut with memory, whose parameters are found from one accelerometer. The record comes from equations of
// its own, integrated forty times finer than it is sampled.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double mass = 10.0, rate = 500.0;
constexpr Index samples = 2001;
constexpr int parts = 40;
constexpr double prior = 0.2;  ///< deviations of the unknowns, relative

/// Thirty sines of 20 N each, their frequencies random between two, as many in every octave [Hz]; faded in.
struct Load {
  double lowest, highest;
  std::uint64_t seed;
};

VectorXd sampled(const Load& load, Index count, double step) {
  RandomStream stream(load.seed, "load");
  VectorXd values = VectorXd::Zero(count);
  for (int i = 0; i < 30; ++i) {
    const double omega = 2.0 * std::numbers::pi * load.lowest * std::pow(load.highest / load.lowest, stream.uniform());
    const double phase = 2.0 * std::numbers::pi * stream.uniform();
    for (Index k = 0; k < count; ++k) values[k] += 20.0 * std::sin(omega * step * static_cast<double>(k) + phase);
  }
  const auto faded = std::min(count, static_cast<Index>(0.2 / step));
  for (Index k = 0; k < faded; ++k)
    values[k] *= 0.5 - 0.5 * std::cos(std::numbers::pi * static_cast<double>(k) / static_cast<double>(faded));
  return values;
}

/// Accelerations under the load by the leapfrog method; `strut(d, v, h)` moves the strut and answers its force.
template <class Strut>
VectorXd accelerations(const Load& load, Strut strut) {
  const double h = 1.0 / (rate * parts);
  const VectorXd driven = sampled(load, (samples - 1) * parts + 1, h);
  VectorXd found(samples);
  double d = 0.0, v = 0.0, a = 0.0;
  for (Index k = 0; k < driven.size(); ++k) {
    if (k > 0) {
      const double middle = v + 0.5 * h * a;
      d += h * middle;
      a = (driven[k] - strut(d, middle, h)) / mass;
      v = middle + 0.5 * h * a;
    }
    if (k % parts == 0) found[k / parts] = a;
  }
  return found;
}

struct Sought {
  std::string name;
  double truth, initial;
};

EstimateResult estimate_from(VectorXd measured, const Load& load, const Law& strut, const std::vector<Sought>& unknowns,
                             bool diagnose = false) {
  const double noise = 0.02 * measured.norm() / std::sqrt(static_cast<double>(samples));
  RandomStream stream(11, "noise");
  for (double& value : measured) value += noise * stream.normal();
  Structure structure;
  structure.add(lumped("s").mass("m", mass));
  structure.connect("strut", "ground", "s.m", strut);
  structure.force("u", "s.m", Samples{sampled(load, samples, 1.0 / rate), rate, 0.0});
  EstimateOptions options{.sensors = {{"a", acceleration("s.m"), noise}}, .substeps = 2, .diagnose = diagnose};
  for (const auto& each : unknowns)
    options.unknowns.push_back(
        {"strut." + each.name,
         {.initial = each.initial, .std = prior * each.initial, .transform = ParameterTransform{TransformKind::log}}});
  return estimate(structure, make_record(rate, {{"a", measured}}), options);
}

/// Each within three of its deviations, of which the record has left less than half of what the prior had.
void expect_found(const EstimateResult& result, const std::vector<Sought>& unknowns) {
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto& [mean, interval] = std::pair(result.parameters[i].mean, result.parameters[i].interval_95);
    const double deviation = (interval.upper - interval.lower) / (2.0 * 1.96);
    EXPECT_LT(std::abs(mean - unknowns[i].truth), 3.0 * deviation)
        << unknowns[i].name << " " << mean << " +- " << deviation << " for " << unknowns[i].truth;
    EXPECT_LT(deviation, 0.5 * prior * unknowns[i].initial) << unknowns[i].name << " " << mean;
  }
}

constexpr double k_inf = 4e4, k_1 = 3e4, tau_1 = 5e-3, k_2 = 2e4, tau_2 = 0.15;

/// Accelerations on a mount of two Maxwell branches.
VectorXd on_a_mount(const Load& load) {
  double z_1 = 0.0, z_2 = 0.0;
  return accelerations(load, [&](double d, double v, double h) {
    const auto relax = [&](double& z, double tau) {  // exact for a constant rate
      const double share = std::exp(-h / tau), from = d - h * v;
      z = d - v * tau + (z - from + v * tau) * share;
      return d - z;
    };
    return k_inf * d + k_1 * relax(z_1, tau_1) + k_2 * relax(z_2, tau_2);
  });
}

Law series() { return law("prony", {{"k_inf", k_inf}, {"k1", k_1}, {"tau1", tau_1}, {"k2", k_2}, {"tau2", tau_2}}); }

/// Beside a static test, which tells k_inf. The record tells k_1 tau_1 much better than each, hence the logarithms.
TEST(LawsWithMemory, APronySeriesIsFound) {
  const Load load{0.4, 30.0, 1};
  const std::vector<Sought> unknowns{
      {"k1", k_1, 3.5e4}, {"tau1", tau_1, 4.2e-3}, {"k2", k_2, 2.3e4}, {"tau2", tau_2, 0.13}};
  expect_found(estimate_from(on_a_mount(load), load, series(), unknowns), unknowns);
}

/// Without it the record tells k_inf + k_2, and hardly each. A filter takes the turning ridge for information.
TEST(LawsWithMemory, APronySeriesThatTheRecordHardlyTellsIsNotTakenForKnown) {
  int held = 0, intervals = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    const Load load{0.4, 30.0, seed};
    const std::vector<Sought> unknowns{{"k_inf", k_inf, 3.4e4},
                                       {"k1", k_1, 3.5e4},
                                       {"tau1", tau_1, 4.2e-3},
                                       {"k2", k_2, 2.3e4},
                                       {"tau2", tau_2, 0.13}};
    const auto result = estimate_from(on_a_mount(load), load, series(), unknowns, true);
    EXPECT_NE(result.verdict.state(), VerdictState::consistent) << "load " << seed;
    for (std::size_t i = 0; i < unknowns.size(); ++i, ++intervals) {
      const auto& [lower, upper] = result.parameters[i].interval_95;
      held += lower <= unknowns[i].truth && unknowns[i].truth <= upper;
    }
  }
  std::cout << held << " of " << intervals << " intervals hold\n";
  EXPECT_GE(held, 24);  // the linearised posterior of a bent one; the filter's own deviations: about a third
}

TEST(LawsWithMemory, TheYieldingOfRambergAndOsgoodIsFound) {
  const Load load{2.0, 20.0, 2};
  const double k = 8e4, f_y = 60.0, r = 5.0, c = 60.0;
  MasingBranches branches(k, f_y, 1.0, r);
  const auto joint = [&](double d, double v, double) { return branches.move_to(d) + c * v; };
  const std::vector<Sought> unknowns{{"k", k, 7e4}, {"f_y", f_y, 70.0}, {"r", r, 4.5}};
  const Law hysteresis = law("ramberg_osgood", {{"k", k}, {"f_y", f_y}, {"r", r}, {"c", c}});
  expect_found(estimate_from(accelerations(load, joint), load, hysteresis, unknowns), unknowns);
}

}  // namespace
}  // namespace kalfem
