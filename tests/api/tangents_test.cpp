// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "cantilever.hpp"
#include "kalfem/api/filter_problem.hpp"
#include "kalfem/identification/runs_beside.hpp"

// Derivatives of a record by every number that an estimation holds fixed, carried as tangents in one run of the mean
// with the filter's gains, against central differences of whole such runs.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// A structure, what is measured and unknown of it, and how finely the filter divides a sample interval.
struct Case {
  Structure structure;
  EstimateOptions options;
  double sample_rate = 500.0, duration = 1.0;
  double step = 1e-5;        ///< of the differences of whole runs, in a number's scale
  double tolerance = 1e-6;   ///< of the largest value
  double delay_step = 3e-6;  ///< of the differences by a delay [s]
};

Samples two_tones(double amplitude) {
  Eigen::VectorXd values(2001);
  for (Index k = 0; k < values.size(); ++k) {
    const double t = static_cast<double>(k) / 1000.0;
    values[k] = amplitude * (std::sin(23.0 * t) + 0.7 * std::sin(61.0 * t));
  }
  return {values, 1000.0};
}

/// The laws' forces jump in their second derivative where deformation or rate are zero: runs beside each other pass
/// these jumps at other instants, so that a difference of runs has an error of the order of its step.
Case chain_with_kinks() {
  return {.structure = driven_chain(),
          .options = {.sensors = chain_sensors(), .unknowns = {{"suspension.mu_k1", {.initial = 15.0, .std = 5.0}}}},
          .step = 1e-6,
          .tolerance = 1e-5};
}

Case quarter_car() {
  Structure s;
  s.add(lumped("car").mass("wheel", 40.0).mass("body", 300.0).spring("tyre", "ground", "wheel", 2e5, 50.0));
  s.connect("strut", "car.wheel", "car.body",
            expression("k*x + k3*x^3 + c*v/sqrt(1 + (v/v0)^2)", {{"k", 2e4}, {"k3", 4e6}, {"c", 1500.0}, {"v0", 0.2}}));
  s.base_displacement("road", "car.ground", two_tones(0.01));
  return {.structure = s,
          .options = {.sensors = {{"wheel", acceleration("car.wheel"), 0.5}, {"body", acceleration("car.body"), 0.1}},
                      .unknowns = {{"strut.k3", {.initial = 3e6, .std = 1e6}},
                                   {"car.tyre.stiffness", {.initial = 1.9e5, .std = 2e4}}}}};
}

/// Its internal state is integrated with |v|, which has a kink where the motion turns.
Case hysteresis() {
  Structure s;
  s.add(lumped("s").mass("1", 1.0).mass("2", 0.7).spring("k", "1", "2", 800.0, 1.0).modal_damping(0.01));
  s.connect("mount", "s.1", "ground",
            law("bouc_wen", {{"k", 900.0}, {"alpha", 0.4}, {"A", 1.0}, {"beta", 120.0}, {"gamma", 80.0}, {"n", 1.3}}));
  s.force("shaker", "s.2", two_tones(3.0));
  return {.structure = s,
          .options = {.sensors = {{"a1", acceleration("s.1"), 0.05}, {"d2", displacement("s.2"), 1e-4}},
                      .unknowns = {{"mount.alpha", {.initial = 0.5, .std = 0.1}}}},
          .step = 1e-6,
          .tolerance = 1e-4};
}

/// A law that depends on the acceleration, a mass among the unknowns, and a sensor with a filter and a delay.
Case inertance() {
  Structure s;
  s.add(lumped("s").mass("1", 1.0).mass("2", 0.7).spring("k0", "ground", "1", 2000.0, 2.0).rayleigh_damping(0.3, 1e-4));
  s.connect("inerter", "s.1", "s.2", expression("b*a + k*x + k3*x^3", {{"b", 0.2}, {"k", 800.0}, {"k3", 1e6}}));
  s.force("shaker", "s.2", two_tones(3.0));
  return {.structure = s,
          .options = {.sensors = {{"a1", acceleration("s.1"), 0.05}, {"v2", velocity("s.2"), 1e-3}},
                      .unknowns = {{"inerter.b", {.initial = 0.25, .std = 0.1}}}}};
}

Case beam() {
  Structure s;
  s.add(cantilever().modal_damping({0.01}, 500.0).reduce({.modes = {.count = 4}}));
  s.connect("stop", "beam.tip.z", "ground", law("polynomial", {{"k1", 1e3}, {"k3", 1e9}}));
  s.force("push", "beam.tip.z", two_tones(5.0));
  return {.structure = s,
          .options = {.sensors = {{"tip", acceleration("beam.tip.z"), 0.05}},
                      .unknowns = {{"stop.k3", {.initial = 8e8, .std = 3e8}}}},
          .delay_step = 5e-7};  // modes up to 500 Hz
}

double error_of(const MatrixXd& found, const MatrixXd& exact) {
  if (found.rows() != exact.rows() || found.cols() != exact.cols() || !found.allFinite() || !exact.allFinite())
    return std::numeric_limits<double>::infinity();
  const double largest = exact.size() > 0 ? exact.cwiseAbs().maxCoeff() : 0.0;
  return largest > 0.0      ? (found - exact).cwiseAbs().maxCoeff() / largest
         : found.size() > 0 ? found.cwiseAbs().maxCoeff()
                            : 0.0;
}

/// Runs over a simulated record in which two samples are missing.
RunsBeside made(const FilterProblem& filter, const Record& record, const RecordEstimate& start,
                const RecordEstimateOptions& monitored) {
  RunsBeside runs(filter.problem, filter.setup, record, start, monitored, {});
  const auto& run = runs.filter();
  const auto result =
      estimate(*run.choice.augmented_model, run.input, {.filter = run.choice.filter, .keep_gains = true});
  EXPECT_FALSE(result.failure) << result.failure->reason;
  EXPECT_TRUE(runs.run_base(result.gains));
  return runs;
}

void compare(Case given, int substeps, int order, std::vector<std::string> stated = {}) {
  SCOPED_TRACE(std::to_string(substeps) + " substeps of order " + std::to_string(order));
  auto& options = given.options;
  Record record =
      simulate(given.structure,
               {.sensors = options.sensors, .duration = given.duration, .sample_rate = given.sample_rate, .seed = 3})
          .record;
  record.values(0, 40) = std::numeric_limits<double>::quiet_NaN();
  record.values.col(90).setConstant(std::numeric_limits<double>::quiet_NaN());
  options.substeps = substeps;
  options.step_order = order;
  for (const auto& name : stated) options.known_to.push_back({.name = name, .deviation = 0.02});
  const FilterProblem filter = make_filter_problem(given.structure, given.sample_rate, options);
  const RecordEstimate start;
  const RecordEstimateOptions monitored{.monitored = filter.monitored};
  const RunsBeside runs = made(filter, record, start, monitored);
  std::size_t compared = 0;
  for (const auto& group : runs.groups()) {
    const auto derivatives = runs.derivatives(group);
    for (std::size_t n = 0; n < group.size(); ++n, ++compared) {
      const auto& number = runs.numbers()[group[n]];
      const auto& [means, by_run] = derivatives[n];
      EXPECT_FALSE(by_run) << number.name;
      const auto exact = runs.difference(group[n], number.is_of_clock() ? given.delay_step : given.step);
      ASSERT_TRUE(means && exact) << number.name;
      EXPECT_LT(error_of(means->innovation, exact->innovation), given.tolerance) << number.name;
      EXPECT_LT(error_of(means->unknowns, exact->unknowns), given.tolerance) << number.name;
      if (number.deviation == 0.0) continue;
      EXPECT_GT(means->monitored.rows(), 0) << number.name;
      EXPECT_LT(error_of(means->monitored, exact->monitored), given.tolerance) << number.name;
    }
  }
  EXPECT_EQ(compared, runs.numbers().size());
}

TEST(Tangents, OfAChain) {
  compare(chain_with_kinks(), 1, 2);
  compare(chain_with_kinks(), 4, 2, {"masses", "stiffnesses"});
  compare(chain_with_kinks(), 2, 4);
}

TEST(Tangents, OfAQuarterCarWithAFormula) {
  compare(quarter_car(), 1, 2);
  compare(quarter_car(), 4, 2, {"damping", "gains"});
  compare(quarter_car(), 1, 4);
  compare(quarter_car(), 2, 4, {"excitations"});
}

TEST(Tangents, OfHysteresis) {
  compare(hysteresis(), 1, 2);
  compare(hysteresis(), 4, 2, {"mount"});
  compare(hysteresis(), 2, 4);
}

TEST(Tangents, OfForcesByTheAcceleration) {
  compare(inertance(), 1, 2);
  compare(inertance(), 3, 2, {"s"});
  compare(inertance(), 2, 4);
}

TEST(Tangents, OfFiniteElements) {
  compare(beam(), 2, 2);
  compare(beam(), 1, 4, {"stiffnesses"});
}

/// Where the linear part has unknowns, runs beside each number take their place, and say so.
TEST(Tangents, AreReplacedByRunsWhereTheLinearPartHasUnknowns) {
  Case given = beam();
  given.options.unknowns = {{"beam.steel.youngs_modulus", {.initial = 209.9e9, .std = 1e8}}};
  given.options.substeps = 2;
  const Record record =
      simulate(given.structure, {.sensors = given.options.sensors, .duration = 0.4, .sample_rate = 500.0, .seed = 3})
          .record;
  const FilterProblem filter = make_filter_problem(given.structure, 500.0, given.options);
  const RecordEstimate start;
  const RunsBeside runs = made(filter, record, start, {});
  for (const auto& group : runs.groups())
    for (const auto& each : runs.derivatives(group)) {
      EXPECT_TRUE(each.by_run);
      EXPECT_TRUE(each.means && each.means->innovation.allFinite());
    }
}

}  // namespace
}  // namespace kalfem
