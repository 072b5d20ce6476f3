// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <iostream>
#include <random>

#include <fmt/format.h>

#include "calibration_runs.hpp"
#include "kalfem/api/infer.hpp"
#include "kalfem/api/simulate.hpp"
#include "kalfem/api/update.hpp"
#include "kalfem/api/vibration.hpp"

// Every number of a model is off by what is stated of it: masses 1 %, stiffnesses 3 %, damping 20 %, gains 2 %.

namespace kalfem::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double of_masses = 0.01, of_stiffnesses = 0.03, of_damping = 0.2, of_gains = 0.02;

std::vector<KnownTo> what_is_stated() {
  return {{.name = "masses", .deviation = of_masses},
          {.name = "stiffnesses", .deviation = of_stiffnesses},
          {.name = "damping", .deviation = of_damping},
          {.name = "gains", .deviation = of_gains},
          {.name = "excitations", .deviation = of_gains}};
}

/// A chain that hangs on the ground with a further spring to it, of which two stiffnesses are sought.
class Problem {
public:
  explicit Problem(int seed) : random_(static_cast<std::uint64_t>(seed) + 4711) {
    count_ = 3 + static_cast<int>(3.0 * uniform(0.0, 1.0));
    for (int i = 0; i < count_; ++i) {
      mass.push_back(uniform(0.5, 2.0));
      stiffness.push_back(uniform(2e3, 2e4));
      damping.push_back(2.0 * uniform(0.02, 0.05) * std::sqrt(stiffness.back() * mass.back()));
    }
    stiffness.push_back(uniform(2e3, 8e3));
    damping.push_back(2.0);
    sought = {static_cast<std::size_t>(uniform(0.0, 1.0) * count_), 0};
    sought[1] = (sought[0] + 1) % static_cast<std::size_t>(count_);
  }

  double uniform(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(random_); }
  double normal() { return normal_(random_); }
  double drawn(double value, double deviation) { return value * (1.0 + deviation * normal()); }

  [[nodiscard]] std::string point(int i) const { return fmt::format("s.m{}", i); }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] std::string name(std::size_t j) const { return fmt::format("s.k{}.stiffness", sought[j]); }
  [[nodiscard]] double truth(std::size_t j) const { return stiffness[sought[j]]; }

  [[nodiscard]] Structure structure() const {
    LumpedPart part = lumped("s");
    for (int i = 0; i < count_; ++i) part.mass(fmt::format("m{}", i), mass[static_cast<std::size_t>(i)]);
    for (std::size_t i = 0; i < stiffness.size(); ++i) {
      const bool last = i + 1 == stiffness.size();
      const std::string from = i == 0 || last ? "ground" : fmt::format("m{}", i - 1),
                        to = fmt::format("m{}", last ? i - 1 : i);
      part.spring(fmt::format("k{}", i), from, to, stiffness[i], damping[i]);
    }
    Structure made;
    made.add(part);
    return made;
  }

  /// As somebody else has it: what is sought is guessed, the rest is off by what is stated of it.
  [[nodiscard]] Problem believed() {
    Problem other = *this;
    for (auto& each : other.mass) each = drawn(each, of_masses);
    for (std::size_t i = 0; i < stiffness.size(); ++i) {
      const bool is_sought = i == sought[0] || i == sought[1];
      other.stiffness[i] = is_sought ? stiffness[i] * uniform(0.9, 1.1) : drawn(stiffness[i], of_stiffnesses);
      other.damping[i] = std::max(0.1 * damping[i], drawn(damping[i], of_damping));
    }
    return other;
  }

  std::vector<double> mass, stiffness, damping;
  std::array<std::size_t, 2> sought;

private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  int count_ = 0;
};

/// Counts an interval, and prints one that misses its truth.
void count_interval(Coverage& coverage, const std::string& problem, const std::string& name, double lower, double upper,
                    double truth, const std::string& more) {
  const bool in = lower <= truth && truth <= upper;
  coverage.add(in);
  if (!in)
    std::cout << fmt::format("{} {}: {:.5g} to {:.5g} for {:.5g}{}\n", problem, name, lower, upper, truth, more)
              << std::flush;
}

void expect_95(const Coverage& coverage, const std::string& what) {
  std::cout << fmt::format("{}: {} of {} intervals true\n", what, coverage.held, coverage.intervals) << std::flush;
  EXPECT_TRUE(coverage.is_binomial());
}

/// Updates what somebody else believes by a measurement of the truth.
template <class Measure>
Coverage updated(int count, const Measure& measure) {
  Coverage coverage;
  const int first = number("KALFEM_FIRST", 1);
  int consistent = 0, exact = 0;
  for (int seed = first; seed < first + count; ++seed) {
    Problem truth(seed), belief = truth.believed();
    const auto [structure, comparison] = measure(truth, belief);
    UpdateOptions options{
        .parameters = {{truth.name(0)}, {truth.name(1)}}, .comparisons = {comparison}, .known_to = what_is_stated()};
    const auto found = update(structure, options);
    consistent += found.verdict.state() == VerdictState::consistent ? 1 : 0;
    for (std::size_t j = 0; j < 2; ++j) {
      const auto& each = found.parameters[j];
      exact += std::abs(each.value - truth.truth(j)) < 1.96 * each.std ? 1 : 0;
      count_interval(coverage, std::to_string(seed), each.name, each.interval_95.lower, each.interval_95.upper,
                     truth.truth(j),
                     fmt::format(" (std {:.2g}, robust {:.2g}, considered {:.2g}; {}{})", each.std, each.std_robust,
                                 each.std_considered, found.reason, codes_of(found.verdict)));
    }
  }
  std::cout << fmt::format("{} of {} consistent; {} intervals true without what is stated\n", consistent, count, exact);
  return coverage;
}

TEST(StatedInUpdating, ByModes) {
  const auto coverage = updated(number("KALFEM_COUNT", 150), [](Problem& truth, Problem& belief) {
    const auto found = modes(truth.structure());
    MeasuredModes measured{.substructure = "s", .shapes = found.shapes, .shape_std = 0.01};
    for (int i = 0; i < truth.count(); ++i) measured.points.push_back(truth.point(i));
    for (Index k = 0; k < found.frequencies.size(); ++k) {
      const double f = found.frequencies[k];
      measured.frequencies.push_back({truth.drawn(f, 1e-3), 1e-3 * f});
      const double largest = found.shapes.col(k).cwiseAbs().maxCoeff();
      for (Index i = 0; i < found.shapes.rows(); ++i) measured.shapes(i, k) += 0.01 * largest * truth.normal();
    }
    return std::pair{belief.structure(), UpdateComparison{.name = "modes", .what = measured}};
  });
  expect_95(coverage, "modes");
}

TEST(StatedInUpdating, ByFrequencyResponses) {
  const auto coverage = updated(number("KALFEM_COUNT", 150), [](Problem& truth, Problem& belief) {
    const auto frequencies = modes(truth.structure()).frequencies;
    MeasuredResponses measured{.input = truth.point(truth.count() - 1), .relative_std = 1e-6};
    measured.frequencies = VectorXd::LinSpaced(200, 0.5 * frequencies.minCoeff(), 1.2 * frequencies.maxCoeff());
    for (int i = 0; i < truth.count(); ++i) measured.outputs.push_back(acceleration(truth.point(i)));
    measured.values = frequency_responses(truth.structure(), measured.frequencies, measured.input, measured.outputs);
    const Eigen::RowVectorXd rms = measured.values.cwiseAbs2().colwise().mean().cwiseSqrt();
    measured.std = 0.02 * measured.values.cwiseAbs() + 0.01 * MatrixXd::Ones(measured.values.rows(), 1) * rms;
    for (Index j = 0; j < measured.values.cols(); ++j) {
      for (Index k = 0; k < measured.values.rows(); ++k)
        measured.values(k, j) += measured.std(k, j) * std::complex<double>(truth.normal(), truth.normal());
      measured.values.col(j) *= truth.drawn(1.0, of_gains);
    }
    measured.values *= truth.drawn(1.0, of_gains);
    return std::pair{belief.structure(), UpdateComparison{.name = "taps", .what = measured}};
  });
  expect_95(coverage, "frequency responses");
}

constexpr double rate = 400.0;

/// A force at the end of the chain: sines over its modes.
Samples push(Problem& truth, double duration, double gain) {
  const auto frequencies = modes(truth.structure()).frequencies;
  const auto samples = static_cast<Index>(duration * rate) + 1;
  VectorXd force = VectorXd::Zero(samples);
  for (int i = 0; i < 30; ++i) {
    const double f = truth.uniform(0.3 * frequencies.minCoeff(), 1.1 * frequencies.maxCoeff()),
                 phase = truth.uniform(0.0, 6.28);
    for (Index k = 0; k < samples; ++k) {
      const double t = static_cast<double>(k) / rate;
      force[k] += gain * std::min(1.0, t) * std::sin(6.283185307 * f * t + phase);
    }
  }
  return {force, rate, 0.0};
}

struct DrivenProblem {
  Structure believed;
  std::vector<SensorDescription> sensors;
  Record record;
};

/// A record of the truth at each mass, or at each second one, whose channels and force are off by their gains.
DrivenProblem driven(Problem& truth, Problem& belief, double duration, int every = 1) {
  const Samples force = push(truth, duration, 1.0);
  Structure real = truth.structure();
  Samples off = force;
  off.values *= truth.drawn(1.0, of_gains);
  real.force("shaker", truth.point(truth.count() - 1), off);
  DrivenProblem made{.believed = belief.structure()};
  made.believed.force("shaker", truth.point(truth.count() - 1), force);
  for (int i = 0; i < truth.count(); i += every)
    made.sensors.push_back({fmt::format("a{}", i), acceleration(truth.point(i)), 1.0});
  const SimulateOptions options{.sensors = made.sensors, .duration = duration, .sample_rate = rate, .seed = 1};
  const auto clean = simulate(real, options).record;
  for (std::size_t i = 0; i < made.sensors.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const double size = std::sqrt(clean.values.row(row).squaredNorm() / static_cast<double>(clean.samples()));
    made.sensors[i].noise = 0.05 * std::max(size, 1.0);
  }
  made.record = simulate(real, {.sensors = made.sensors,
                                .duration = duration,
                                .sample_rate = rate,
                                .seed = static_cast<std::uint64_t>(truth.uniform(1.0, 1e9))})
                    .record;
  for (Index row = 0; row < made.record.values.rows(); ++row) made.record.values.row(row) *= truth.drawn(1.0, of_gains);
  return made;
}

TEST(StatedInUpdating, ByRecords) {
  const auto coverage = updated(number("KALFEM_COUNT", 150), [](Problem& truth, Problem& belief) {
    auto made = driven(truth, belief, 4.0);
    return std::pair{
        made.believed,
        UpdateComparison{.name = "ride", .what = MeasuredRecord{.record = made.record, .sensors = made.sensors}}};
  });
  expect_95(coverage, "records");
}

/// The filter integrates masses, stiffnesses and dashpots out, samples the gains of the sensors.
TEST(StatedInPosteriors, ByRecords) {
  Coverage coverage;
  const int first = number("KALFEM_FIRST", 1), count = number("KALFEM_COUNT", 100);
  for (int seed = first; seed < first + count; ++seed) {
    Problem truth(seed), belief = truth.believed();
    const auto made = driven(truth, belief, 2.0, 3);
    auto known_to = what_is_stated();
    known_to.pop_back();  // the gain of the force acts like those of all sensors together
    InferOptions options{.sensors = made.sensors,
                         .unknowns = {},
                         .method = PosteriorMethod::importance,
                         .samples = 200,
                         .seed = static_cast<std::uint64_t>(seed),
                         .predictions = 0,
                         .known_to = known_to,
                         .substeps = 1};
    for (std::size_t j = 0; j < 2; ++j) options.unknowns.push_back({truth.name(j), {.std = 0.2 * truth.truth(j)}});
    const auto found = infer(made.believed, made.record, options);
    for (std::size_t j = 0; j < 2; ++j) {
      const auto& each = found.parameters[j];
      count_interval(coverage, std::to_string(seed), each.name, each.interval_95.lower, each.interval_95.upper,
                     truth.truth(j), fmt::format(" (mean {:.5g}, std {:.2g})", each.mean, each.std));
    }
  }
  expect_95(coverage, "posteriors");
}

}  // namespace
}  // namespace kalfem::calibration
