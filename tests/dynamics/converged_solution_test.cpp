// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "dynamics/closed_forms.hpp"
#include "kalfem/dynamics/converged_solution.hpp"
#include "kalfem/system/signals/deterministic.hpp"

namespace kalfem {
namespace {

using Eigen::ArrayXd;

const SignalPtr rest_signal = make_constant(0.0);

class ReferenceOfAChain : public testing::Test {
protected:
  CoupledModel model =
      quarter_chain(3, {{"strut", "wheel.w", "body.1", make_law("saturating"), saturating_parameters()}},
                    {{"road", InputKind::base_displacement, "wheel.ground"}});
  OutputMap sensors = make_outputs(model, {{"a", ObservedQuantity::acceleration, {{"body.2", 1.0}}}});
  SignalPtr road = make_sine({.amplitude = 3e-3, .frequency = 8.0, .fade_in = 0.2});

  [[nodiscard]] ConvergedSolution run(const ConvergenceOptions& options,
                                      Integrator integrator = Integrator::newmark) const {
    return simulate_converged(model.system(), {road}, at_rest(4, 0), sensors, {},
                              {.integrator = integrator, .duration = 0.5}, options);
  }
};

TEST_F(ReferenceOfAChain, IsTheSameFromTwoThreads) {
  for (const double tolerance : {0.5, 1e-4}) {  // after two solutions, after more than were made ahead
    ConvergenceOptions options{.first_substeps = 1, .tolerance = tolerance};
    const auto alone = run(options);
    options.threads = 2;
    const auto together = run(options);
    ASSERT_TRUE(alone.converged);
    EXPECT_EQ(alone.substeps, together.substeps);
    EXPECT_EQ(alone.sensors, together.sensors);
    EXPECT_EQ(alone.simulation.trajectory.displacement, together.simulation.trajectory.displacement);
  }
}

TEST_F(ReferenceOfAChain, ConvergesAndSaysHowFine) {
  const auto rough = run({.tolerance = 1e-2}), fine = run({.tolerance = 1e-4});
  EXPECT_TRUE(rough.converged);
  EXPECT_TRUE(fine.converged);
  // what was asked for
  EXPECT_LE(fine.last_change, 1e-4);
  EXPECT_GT(fine.substeps, rough.substeps);
  EXPECT_EQ(fine.sensors.cols(), 501);
  EXPECT_EQ(fine.simulation.trajectory.samples(), 501);
  // the last change bounds the error: found a third of it
  EXPECT_LT((rough.sensors - fine.sensors).norm() / fine.sensors.norm(), rough.last_change);
}

double relative_error(const Eigen::MatrixXd& found, const Eigen::MatrixXd& exact) {
  return (found - exact).norm() / exact.norm();
}

/// Errors against a plain solution with far finer steps, whatever the scheme and the first step. Found: at most 0.44 of
/// the tolerance, where a third is aimed at.
TEST_F(ReferenceOfAChain, ErrsByAboutAThirdOfTheTolerance) {
  for (const auto integrator : {Integrator::newmark, Integrator::generalized_alpha, Integrator::exact}) {
    const auto fine = run({.first_substeps = 512, .max_substeps = 512, .refine = false}, integrator);
    for (const Eigen::Index first : {1, 2, 4})
      for (const double tolerance : {3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5}) {
        const auto found = run({.first_substeps = first, .tolerance = tolerance}, integrator);
        ASSERT_TRUE(found.converged);
        EXPECT_LE(found.last_change, tolerance);
        EXPECT_LT(relative_error(found.sensors, fine.sensors), 0.5 * tolerance)
            << "from " << first << " to " << found.substeps << " steps, to " << tolerance;
      }
  }
}

/// 1, 2, 3, 6, 12 ... times the first number of steps, none above the last one.
TEST_F(ReferenceOfAChain, TakesTheStepsOfItsSequence) {
  for (const Eigen::Index last : {4, 8, 11, 12, 23, 24, 47, 48}) {
    const auto reference = run({.first_substeps = 4, .max_substeps = last, .tolerance = 1e-14});
    const Eigen::Index finest = last < 8 ? 4 : last < 12 ? 8 : last < 24 ? 12 : last < 48 ? 24 : 48;
    EXPECT_EQ(reference.substeps, finest);
    EXPECT_EQ(reference.changes.size(), finest == 4    ? 0U
                                        : finest == 8  ? 1U
                                        : finest == 12 ? 2U
                                        : finest == 24 ? 3U
                                                       : 4U);
    EXPECT_FALSE(reference.converged);
    EXPECT_FALSE(reference.stagnates());
  }
  // The changes are those of the plain solutions, whose errors go with 1, 1/4, 1/9, 1/36.
  const auto changes = run({.first_substeps = 4, .max_substeps = 24, .tolerance = 1e-14}).changes;
  EXPECT_NEAR(changes[0] / changes[1], (1.0 - 1.0 / 4) / (1.0 / 4 - 1.0 / 9), 0.1);
  EXPECT_NEAR(changes[1] / changes[2], (1.0 / 4 - 1.0 / 9) / (1.0 / 9 - 1.0 / 36), 0.1);
}

/// Friction's reversals fall somewhere within a step, so that errors are no series in h^2: what is extrapolated must
/// show its order before it is trusted. Found: at most 1.3 of the tolerance; trusted always, four times it and more.
TEST(ConvergedSolution, FrictionDoesNotMisleadTheExtrapolation) {
  const std::vector<std::pair<std::string, Eigen::VectorXd>> laws{{"coulomb", values({20.0, 1e-3, 0.0, 0.0})},
                                                                  {"coulomb", values({20.0, 1e-5, 0.0, 0.0})},
                                                                  {"jenkins", values({1e5, 20.0, 0.0, 0.0})},
                                                                  {"bilinear", values({1e5, 20.0, 0.01, 0.0})}};
  for (const auto& [name, parameters] : laws) {
    const auto model = oscillator(1.0, 1.0, 1e3, {{"strut", "body.ground", "body.x", make_law(name), parameters}});
    const auto run = [&](const ConvergenceOptions& options) {
      return simulate_converged(model.system(), {make_sine({.amplitude = 60.0, .frequency = 5.0})},
                                at_rest(1, model.system().connector_states()), displacement_of(model), {},
                                {.integrator = Integrator::newmark, .duration = 1.0}, options);
    };
    for (const Eigen::Index first : {1, 2, 3})
      for (const double tolerance : {1e-3, 3e-4, 1e-4, 3e-5}) {
        const auto found = run({.first_substeps = first, .tolerance = tolerance});
        ASSERT_TRUE(found.converged);
        const Eigen::Index finer = 8 * found.substeps;
        const auto fine = run({.first_substeps = finer, .max_substeps = finer, .refine = false});
        EXPECT_LT(relative_error(found.sensors, fine.sensors), 1.5 * tolerance)
            << name << " from " << first << " to " << found.substeps << " steps, to " << tolerance;
      }
  }
}

/// A lightly damped oscillator far from rest: the phase error of Newmark's method grows with every cycle.
TEST(ConvergedSolution, StepsAreExtrapolatedToZero) {
  const double omega = 2.0 * std::numbers::pi * 20.0, zeta = 1e-3, damped = omega * std::sqrt(1.0 - zeta * zeta);
  const auto model = oscillator(1.0, 2.0 * zeta * omega, omega * omega);
  const auto reference = simulate_converged(model.system(), {rest_signal}, start_at(1e-3, 0.0), displacement_of(model),
                                            {}, {.integrator = Integrator::newmark, .duration = 5.0},
                                            {.first_substeps = 1, .tolerance = 1e-4});
  EXPECT_TRUE(reference.converged);
  EXPECT_GT(reference.extrapolations, 0);
  const ArrayXd time = ArrayXd::LinSpaced(5001, 0.0, 5.0);
  const ArrayXd exact = 1e-3 * (-zeta * omega * time).exp() *
                        ((damped * time).cos() + zeta / std::sqrt(1.0 - zeta * zeta) * (damped * time).sin());
  // A third of the tolerance; found 2.1e-5.
  EXPECT_LT((reference.sensors.row(0).transpose().array() - exact).matrix().norm(), 3.3e-5 * exact.matrix().norm());
  // Plain solutions err in phase by omega^3 t h^2 / 12, which is below the tolerance at 1/128 ms only.
  EXPECT_LE(reference.substeps, 16);
}

/// Two powers of the step are taken out, h^2 and h^4: after four solutions the error is of order
/// (omega h)^6.
TEST(ConvergedSolution, TakesTwoPowersOfTheStepOut) {
  const double omega = 2.0 * std::numbers::pi * 20.0;
  const auto model = oscillator(1.0, 0.0, omega * omega);
  const auto error_of = [&](Eigen::Index first) {
    const auto reference = simulate_converged(
        model.system(), {rest_signal}, start_at(1e-3, 0.0), displacement_of(model), {},
        {.integrator = Integrator::newmark, .duration = 0.5},
        {.sample_rate = 200.0, .first_substeps = first, .max_substeps = 6 * first, .tolerance = 1e-9});
    EXPECT_EQ(reference.substeps, 6 * first);
    EXPECT_EQ(reference.extrapolations, 2);
    const ArrayXd time = ArrayXd::LinSpaced(101, 0.0, 0.5);
    return (reference.simulation.trajectory.displacement.row(0).transpose().array() - 1e-3 * (omega * time).cos())
               .matrix()
               .norm() /
           (1e-3 * (omega * time).cos()).matrix().norm();
  };
  const double coarse = error_of(2), fine = error_of(4);
  std::printf("errors %.2e and %.2e, order %.2f\n", coarse, fine, std::log2(coarse / fine));
  EXPECT_GT(std::log2(coarse / fine), 5.0);
}

/// Impacts break the series in h^2: what counts as converged must be so all the same.
TEST(ConvergedSolution, ImpactsDoNotMisleadTheExtrapolation) {
  const Eigen::VectorXd stop{{1e5, 5.0, 2e-4, 1.0, 0.0, 0.0}};  // in contact for a quarter of a free period
  const auto model = oscillator(1.0, 1.0, 1e3, {{"stop", "body.ground", "body.x", make_law("gap"), stop}});
  const auto reference = simulate_converged(model.system(), {rest_signal}, start_at(-1e-3, 0.0), displacement_of(model),
                                            {}, {.integrator = Integrator::newmark, .duration = 1.0},
                                            {.first_substeps = 1, .tolerance = 1e-3});
  ASSERT_TRUE(reference.converged);
  EXPECT_EQ(reference.extrapolations, 0);
  const auto fine = simulate(model.system(), {rest_signal}, start_at(-1e-3, 0.0),
                             {.integrator = Integrator::exact, .step = 1e-6, .duration = 1.0, .keep_every = 1000});
  const Eigen::VectorXd exact = fine.trajectory.displacement.row(0);
  EXPECT_LT((reference.sensors.row(0).transpose() - exact).norm(), 1e-3 * exact.norm());  // found 0.8e-3
}

TEST(ConvergedSolution, FailureIsHandedOnEvenBehindAMeasurementChain) {
  const double k = 4e6;
  const auto model = with_law(function_law([k](double d, double) { return FunctionLaw::Value{-k * d, -k, 0.0}; }));
  const MeasurementChain low_pass({.sections = {FilterSection{.cutoff = 100.0}}});
  const auto reference = simulate_converged(model.system(), {rest_signal}, start_at(1e-3, 0.0), displacement_of(model),
                                            {low_pass}, {.duration = 1.0}, {.max_substeps = 8});
  EXPECT_TRUE(reference.simulation.failure);
  EXPECT_FALSE(reference.converged);
}

}  // namespace
}  // namespace kalfem
