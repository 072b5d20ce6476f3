// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "dynamics/closed_forms.hpp"
#include "kalfem/system/signals/deterministic.hpp"

namespace kalfem {
namespace {

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
const SignalPtr rest_signal = make_constant(0.0);

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

}  // namespace
}  // namespace kalfem
