// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/stepper.hpp"

#include <gtest/gtest.h>

#include "dynamics/closed_forms.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Uncoupled oscillators of mass 1 with these omega^2 and c, each under a force of its own.
LocallyNonlinearSystem oscillators(const std::vector<double>& stiffness, const std::vector<double>& damping) {
  LinearModel model;
  const auto n = static_cast<Index>(stiffness.size());
  model.mass = model.stiffness = model.damping = SparseMatrix(n, n);
  std::vector<InputDescription> inputs;
  for (Index i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    model.dofs.push_back("q" + std::to_string(i));
    model.mass.insert(i, i) = 1.0;
    model.stiffness.insert(i, i) = stiffness[at];
    model.damping.insert(i, i) = damping[at];
    inputs.push_back({"F" + std::to_string(i), InputKind::force, "body." + model.dofs.back(), {}});
  }
  return CoupledModel({{"body", model}}, {}, inputs).system();
}

Trajectory simulated(const LocallyNonlinearSystem& system, const InitialState& start, double force, Index steps,
                     Integrator integrator = Integrator::newmark) {
  const std::vector<SignalPtr> signals(static_cast<std::size_t>(system.input_count()),
                                       straight_lines(VectorXd::Constant(2, force), 1.0));
  return simulate(system, signals, start,
                  {.integrator = integrator, .step = 1e-3, .duration = 1e-3 * static_cast<double>(steps)})
      .trajectory;
}

/// Largest departure from q_k+2 - 2 e^(-a h) cos(w h) q_k+1 + e^(-2 a h) q_k = 0, which free vibration with the poles
/// -a +- i w obeys from any start.
double departure(const VectorXd& q, double omega, double ratio, double step) {
  const double decay = std::exp(-ratio * omega * step),
               turn = 2.0 * decay * std::cos(omega * std::sqrt(1.0 - ratio * ratio) * step);
  const Index n = q.size() - 2;
  return (q.tail(n) - turn * q.segment(1, n) + decay * decay * q.head(n)).cwiseAbs().maxCoeff() /
         q.cwiseAbs().maxCoeff();
}

TEST(PeriodCorrection, FreeVibrationKeepsPeriodAndDecayAtAnyStep) {
  const std::vector<double> omega{20.0, 300.0, 1900.0};  // times the step of 1 ms: up to three steps a period
  const std::vector<double> ratio{0.3, 0.01, 0.002};
  std::vector<double> stiffness, damping;
  for (std::size_t i = 0; i < 3; ++i) {
    stiffness.push_back(omega[i] * omega[i]);
    damping.push_back(2.0 * ratio[i] * omega[i]);
  }
  auto system = oscillators(stiffness, damping);
  auto start = at_rest(3, 0);
  start.displacement.setConstant(1e-3);
  start.velocity.setConstant(0.05);
  const auto plain = simulated(system, start, 0.0, 200);
  correct_periods(system, 0, 1e-3);
  const auto matched = simulated(system, start, 0.0, 200);
  for (Index i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    // rounding of three terms over 200 steps
    EXPECT_LT(departure(matched.displacement.row(i), omega[at], ratio[at], 1e-3), 2e-14);
    EXPECT_GT(departure(plain.displacement.row(i), omega[at], ratio[at], 1e-3), 1e-8);
  }
}

/// Schemes with numerical damping too. A third root of theirs, z = -0.42 at the spectral radius of 0.8, dies out first.
TEST(PeriodCorrection, HoldsForTheWholeFamily) {
  const double omega = 300.0, ratio = 0.01;
  auto start = at_rest(1, 0);
  start.displacement[0] = 1e-3;
  for (const auto& [integrator, scheme] :
       {std::pair{Integrator::hht_alpha, hht_parameters(-0.05)},
        std::pair{Integrator::generalized_alpha, generalized_alpha_parameters(0.8)}}) {
    auto system = oscillators({omega * omega}, {2.0 * ratio * omega});
    correct_periods(system, 0, 1e-3, scheme);
    const Eigen::MatrixXd q = simulated(system, start, 0.0, 400, integrator).displacement.rightCols(300);
    EXPECT_LT(departure(q.row(0), omega, ratio, 1e-3), 1e-14);  // rounding
  }
}

TEST(PeriodCorrection, AnOverdampedOscillatorCreepsBackAtItsOwnRates) {
  auto system = oscillators({100.0 * 900.0}, {100.0 + 900.0});  // poles -100 and -900 1/s
  correct_periods(system, 0, 1e-3);
  auto start = at_rest(1, 0);
  start.displacement[0] = 1.0;
  const VectorXd q = simulated(system, start, 0.0, 100).displacement.row(0);
  const double slow = std::exp(-0.1), fast = std::exp(-0.9);
  // rounding
  EXPECT_LT((q.tail(99) - (slow + fast) * q.segment(1, 99) + slow * fast * q.head(99)).cwiseAbs().maxCoeff(), 5e-15);
}

TEST(PeriodCorrection, StaticDeflectionStays) {
  auto system = oscillators({400.0}, {20.0});
  correct_periods(system, 0, 1e-3);
  // found 4e-14: 5000 roundings of .02 m
  EXPECT_NEAR(simulated(system, at_rest(1, 0), 8.0, 5000).displacement(0, 5000), 8.0 / 400.0, 5e-13);
}

TEST(PeriodCorrection, WhatHasNoPeriodOrTooShortAOneIsLeft) {
  auto system = oscillators({0.0, 2100.0 * 2100.0, 100.0}, {3.0, 4.0, 5.0});
  correct_periods(system, 0, 1e-3);
  for (Index i : {Index{0}, Index{1}}) EXPECT_EQ(system.mass.coeff(i, i), 1.0);
  EXPECT_EQ(system.damping.coeff(0, 0), 3.0);
  EXPECT_EQ(system.damping.coeff(1, 1), 4.0);
  EXPECT_NE(system.mass.coeff(2, 2), 1.0);
  auto unchanged = oscillators({50.0, 100.0}, {1.0, 1.0});
  correct_periods(unchanged, 1, 1e-3);
  EXPECT_EQ(unchanged.mass.coeff(0, 0), 1.0);
}

TEST(PeriodCorrection, AForcedAnswerConvergesWithOrderTwo) {
  const DampedOscillator body{1.0, 2.0, 1e4};
  const auto error = [&](double step) {
    auto system = oscillators({body.k}, {body.c});
    correct_periods(system, 0, step);
    const auto ramp = straight_lines(Eigen::Vector2d(0.0, 50.0), 1.0);
    const auto steps = static_cast<Index>(std::llround(0.9 / step));
    const auto q =
        simulate(system, {ramp}, at_rest(1, 0), {.integrator = Integrator::newmark, .step = step, .duration = 0.9})
            .trajectory.displacement;
    return std::abs(q(0, steps) - body.ramp(50.0, 0.9)[0]);
  };
  EXPECT_NEAR(std::log2(error(2e-3) / error(1e-3)), 2.0, 0.002);  // found .0006: the next term in omega h
}

}  // namespace
}  // namespace kalfem
