#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "dynamics/closed_forms.hpp"
#include "kalfem/dynamics/converged_solution.hpp"
#include "kalfem/system/signals/deterministic.hpp"

namespace kalfem {
namespace {

using Eigen::ArrayXd;

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
const SignalPtr rest_signal = make_constant(0.0);

CoupledModel with_law(const ConnectorLawPtr& law) {
  return oscillator(1.0, 0.0, 1e3, {{"strut", "body.ground", "body.x", law, Eigen::VectorXd()}});
}

OutputMap displacement_of(const CoupledModel& model) {
  return make_outputs(model, {{"d", ObservedQuantity::displacement, {{"body.x", 1.0}}}});
}

TEST(Simulate, StoresTheSamplesAskedFor) {
  const auto model = oscillator(1.0, 0.0, 100.0);
  const auto result =
      simulate(model.system(), {rest_signal}, start_at(1.0, 0.0),
               {.step = 1e-3, .duration = 10.0, .keep_every = 10, .every_step = displacement_of(model)});
  EXPECT_EQ(result.trajectory.samples(), 1001);
  EXPECT_EQ(result.every_step.cols(), 10001);  // beyond the block in which inputs are sampled
  EXPECT_DOUBLE_EQ(result.trajectory.step, 1e-2);
  for (const Eigen::Index k : {0, 7, 500, 1000})
    EXPECT_EQ(result.every_step(0, 10 * k), result.trajectory.displacement(0, k));
  EXPECT_NEAR(result.trajectory.displacement(0, 1000), std::cos(100.0), 2e-12);  // found 1e-13: a thousand roundings
}

TEST(Simulate, InputsGoOnUnchangedOverTheirBlocks) {
  const auto model = oscillator(1.0, 1.0, 100.0);
  const auto sine = make_sine({.amplitude = 1.0, .frequency = 2.0});
  const auto inputs =
      simulate(model.system(), {sine}, at_rest(1, 0), {.step = 1e-3, .duration = 9.0}).trajectory.inputs;
  for (const Eigen::Index k : {4095, 4096, 4097, 8192, 8193, 9000})
    // rounding of the sine's argument
    EXPECT_NEAR(inputs(0, k), std::sin(4 * M_PI * 1e-3 * static_cast<double>(k)), 6e-14) << k;
}

TEST(Simulate, GrowthWithoutBoundIsAFailureWithItsTime) {
  const double k = 4e6;  // z'' = (k - 1e3) z grows as exp(2000 t): beyond 1e308 at 0.35 s
  const auto model = with_law(function_law([k](double d, double) { return FunctionLaw::Value{-k * d, -k, 0.0}; }));
  for (const auto integrator : {Integrator::exact, Integrator::newmark}) {
    const auto result =
        simulate(model.system(), {rest_signal}, start_at(1e-3, 0.0),
                 {.integrator = integrator, .step = 1e-4, .duration = 1.0, .every_step = displacement_of(model)});
    ASSERT_TRUE(result.failure);
    EXPECT_NEAR(result.failure->time, 0.355, 0.02);
    EXPECT_NE(result.failure->reason.find("finite"), std::string::npos);
    EXPECT_TRUE(result.trajectory.displacement.allFinite());
    EXPECT_TRUE(result.every_step.allFinite());
    EXPECT_EQ(result.trajectory.samples(), std::llround(result.failure->time / 1e-4));
    EXPECT_EQ(result.every_step.cols(), result.trajectory.samples());
  }
}

TEST(Simulate, AStepThatFailsGivesNoSnapshot) {
  const double k = 4e6;  // as above
  const auto model = with_law(function_law([k](double d, double) { return FunctionLaw::Value{-k * d, -k, 0.0}; }));
  Eigen::Index snapshots = 0;
  bool finite = true;
  SimulationOptions options{.step = 1e-4, .duration = 1.0};
  options.snapshot = [&](double, const Eigen::VectorXd& displacement) {
    ++snapshots;
    finite = finite && displacement.allFinite();
  };
  const auto result = simulate(model.system(), {rest_signal}, start_at(1e-3, 0.0), options);
  ASSERT_TRUE(result.failure);
  EXPECT_TRUE(finite);
  EXPECT_EQ(snapshots, result.trajectory.samples());
}

TEST(Simulate, LawThatGivesNoNumberIsAFailure) {
  const auto model = with_law(function_law([](double d, double) {
    return FunctionLaw::Value{d < 0.0 ? nan_value : 0.0, 0.0, 0.0};
  }));
  const auto result = simulate(model.system(), {rest_signal}, start_at(1e-3, 0.0), {.step = 1e-3, .duration = 1.0});
  ASSERT_TRUE(result.failure);
  EXPECT_NEAR(result.failure->time, M_PI / 2 / std::sqrt(1e3), 1e-3);  // a quarter period until d < 0
}

TEST(Simulate, StartThatIsNoNumberIsAFailureAtOnce) {
  const auto result = simulate(with_law(function_law([](double d, double) {
                                 return FunctionLaw::Value{d, 1.0, 0.0};
                               })).system(),
                               {rest_signal}, start_at(nan_value, 0.0), {});
  ASSERT_TRUE(result.failure);
  EXPECT_EQ(result.failure->time, 0.0);
  EXPECT_EQ(result.trajectory.samples(), 0);
}

TEST(Simulate, NonSmoothLawsRunThrough) {
  const std::vector<std::pair<std::string, Eigen::VectorXd>> laws{{"gap", values({1e6, 100.0, 1e-4, 1e-4, 0.0, 0.0})},
                                                                  {"coulomb", values({20.0, 1e-6, 0.0, 0.0})},
                                                                  {"jenkins", values({1e7, 20.0, 0.0, 0.0})},
                                                                  {"bilinear", values({1e6, 20.0, 0.01, 0.0})}};
  for (const auto& [name, parameters] : laws)
    for (const auto integrator : {Integrator::exact, Integrator::newmark, Integrator::hht_alpha}) {
      const auto model = oscillator(1.0, 1.0, 1e3, {{"strut", "body.ground", "body.x", make_law(name), parameters}});
      const auto result = simulate(model.system(), {make_sine({.amplitude = 60.0, .frequency = 5.0})},
                                   at_rest(1, model.system().connector_states()),
                                   {.integrator = integrator, .step = 1e-3, .duration = 2.0});
      EXPECT_FALSE(result.failure) << name << " " << (result.failure ? result.failure->reason : "");
    }
}

TEST(Simulate, UnsuitableOptionsAreRefusedTogether) {
  const auto model = oscillator(1.0, 0.0, 1e3);
  try {
    simulate(model.system(), {}, at_rest(2, 0), {.step = nan_value, .duration = -1.0, .keep_every = 0});
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.issues().size(), 5u) << error.what();
  }
  const auto refuses = [&](const SimulationOptions& options) {
    EXPECT_THROW(simulate(model.system(), {rest_signal}, at_rest(1, 0), options), InvalidInput);
  };
  refuses({.integrator = Integrator::hht_alpha, .hht_alpha = 0.1});
  refuses({.integrator = Integrator::generalized_alpha, .spectral_radius = nan_value});
  refuses({.step = 1e-3, .duration = 1e300});
  refuses({.step = 1e-3, .duration = 1e9});
  refuses({.step = 1e-3, .duration = std::numeric_limits<double>::infinity()});
}

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
  EXPECT_LT((reference.sensors.row(0).transpose().array() - exact).matrix().norm(), 1.5e-5 * exact.matrix().norm());
  // Plain halving errs in phase by omega^3 t h^2 / 12, which is below the tolerance at 1/128 ms only.
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
        {.sample_rate = 200.0, .first_substeps = first, .max_substeps = 8 * first, .tolerance = 1e-9});
    EXPECT_EQ(reference.substeps, 8 * first);
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
  const auto fine = simulate(model.system(), {rest_signal}, start_at(-1e-3, 0.0),
                             {.integrator = Integrator::exact, .step = 1e-6, .duration = 1.0, .keep_every = 1000});
  const Eigen::VectorXd exact = fine.trajectory.displacement.row(0);
  EXPECT_LT((reference.sensors.row(0).transpose() - exact).norm(), 6e-4 * exact.norm());
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
