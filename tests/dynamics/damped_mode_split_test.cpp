// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/modal_coordinates.hpp"

#include <gtest/gtest.h>

#include "dynamics/closed_forms.hpp"
#include "kalfem/system/signals/random_signal.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

enum class Damping { dense, low_rank };

/// A chain of twenty masses held at one end and joined to a wheel by a saturating suspension; its lowest modes damped.
LocallyNonlinearSystem damped_chain(Damping kind, double dashpot, const std::vector<InputDescription>& inputs,
                                    Index count = 4) {
  LumpedSubstructure body;
  body.name = "body";
  for (int i = 1; i <= 20; ++i) {
    body.masses.push_back({std::to_string(i), 1.0 + 0.05 * i});
    const std::string below = i == 1 ? "ground" : std::to_string(i - 1);
    body.springs.push_back({"s" + std::to_string(i), below, std::to_string(i), 3e4, 0.0});
  }
  body.rayleigh = {0.3, 1e-5};
  LinearModel model = assemble(body);
  if (dashpot > 0.0) model.damping.coeffRef(7, 7) += dashpot;
  const auto modes = normal_modes(model.mass, model.stiffness);
  model.modal_damping = {{modes.frequencies.head(count), modes.shapes.leftCols(count)},
                         VectorXd::LinSpaced(count, 1.0, 5.0)};
  LumpedSubstructure wheel;
  wheel.masses = {{"w", 1.5}};
  wheel.springs = {{"tyre", "ground", "w", 2e4, 5.0}};
  auto system =
      CoupledModel({{"wheel", assemble(wheel)}, {"body", model}},
                   {{"suspension", "wheel.w", "body.20", make_law("saturating"), saturating_parameters()}}, inputs)
          .system();
  if (kind == Damping::dense) {
    system.damping = SparseMatrix(system.full_damping().sparseView());
    system.modal_damping = {};
  }
  return system;
}

const std::vector<InputDescription> road{{"road", InputKind::base_displacement, "wheel.ground"},
                                         {"F", InputKind::force, "body.6"}};

InitialState start_of(const LocallyNonlinearSystem& system) {
  auto start = at_rest(system.size(), 0);
  start.displacement.setLinSpaced(1e-3, 3e-3);
  start.velocity.setLinSpaced(-0.02, 0.02);
  return start;
}

Trajectory simulated(const LocallyNonlinearSystem& system, const InitialState& start, Integrator integrator) {
  const std::vector<SignalPtr> signals{
      make_random({.rms = 3e-3, .lower = 0.5, .upper = 30.0, .duration = 2.0, .fade_in = 0.1, .seed = 7}),
      make_random({.rms = 2.0, .lower = 1.0, .upper = 20.0, .duration = 2.0, .fade_in = 0.1, .seed = 8})};
  return simulate(system, signals, start, {.integrator = integrator, .step = 5e-4, .duration = 1.0}).trajectory;
}

Trajectory simulated(const LocallyNonlinearSystem& system, Integrator integrator) {
  return simulated(system, start_of(system), integrator);
}

double difference(const Trajectory& a, const Trajectory& b) {
  return std::max({(a.displacement - b.displacement).norm() / b.displacement.norm(),
                   (a.velocity - b.velocity).norm() / b.velocity.norm(),
                   (a.acceleration - b.acceleration).norm() / b.acceleration.norm()});
}

/// The split system itself, its modes with the scheme's periods as all else.
TEST(DampedModeSplit, StepsAsTheDenseDampingMatrixDoes) {
  const auto dense = damped_chain(Damping::dense, 0.0, road);
  const auto split = split_damped_modes(damped_chain(Damping::low_rank, 0.0, road));
  ASSERT_TRUE(split.has_value());
  for (const auto integrator : {Integrator::newmark, Integrator::hht_alpha, Integrator::generalized_alpha}) {
    auto start = start_of(dense);
    const auto whole = simulated(dense, start, integrator);
    for (auto* motion : {&start.displacement, &start.velocity}) *motion = split->split(*motion);
    auto parts = simulated(split->system, start, integrator);
    for (auto* motion : {&parts.displacement, &parts.velocity, &parts.acceleration})
      *motion = motion->topRows(21) + split->shapes * motion->bottomRows(4);
    // found 4e-11: rounding of 2000 steps
    EXPECT_LT(difference(parts, whole), 4e-10);
  }
  auto undamped = damped_chain(Damping::low_rank, 0.0, road);
  undamped.modal_damping = {};
  EXPECT_GT(difference(simulated(undamped, Integrator::newmark), simulated(dense, Integrator::newmark)), 1e-2);
}

TEST(DampedModeSplit, NewmarkHasThePeriodsOfTheDampedModes) {
  const auto low_rank = damped_chain(Damping::low_rank, 0.0, road, 20),
             dense = damped_chain(Damping::dense, 0.0, road, 20);
  const auto exact = simulated(dense, Integrator::exact);
  const auto error = [&](const LocallyNonlinearSystem& system) {
    const auto newmark = simulated(system, Integrator::newmark);
    return (newmark.displacement - exact.displacement).norm() / exact.displacement.norm();
  };
  std::printf("error %.2e with the modes' periods, %.2e with those of average acceleration\n", error(low_rank),
              error(dense));
  // found .56: wheel and suspension are no such modes
  EXPECT_LT(error(low_rank), 0.5 * error(dense));  // wheel and suspension are no such modes
}

TEST(DampedModeSplit, ADashpotThatJoinsTheModesFallsBackToWoodbury) {
  const auto low_rank = damped_chain(Damping::low_rank, 20.0, road), dense = damped_chain(Damping::dense, 20.0, road);
  EXPECT_FALSE(split_damped_modes(low_rank).has_value());
  for (const auto integrator : {Integrator::newmark, Integrator::hht_alpha, Integrator::generalized_alpha})
    // found 1.4e-11: rounding of 2000 steps
    EXPECT_LT(difference(simulated(low_rank, integrator), simulated(dense, integrator)), 2e-10);
}

TEST(DampedModeSplit, ExactSteppingSeesTheModalDamping) {
  const auto low_rank = damped_chain(Damping::low_rank, 20.0, road), dense = damped_chain(Damping::dense, 20.0, road);
  // the same matrices go into the exponential
  EXPECT_LT(difference(simulated(low_rank, Integrator::exact), simulated(dense, Integrator::exact)), 1e-13);
}

TEST(DampedModeSplit, CoordinatesGoThereAndBack) {
  const auto split = split_damped_modes(damped_chain(Damping::low_rank, 0.0, road));
  const VectorXd motion = VectorXd::LinSpaced(21, -1.0, 2.0);
  EXPECT_LT((split->merge(split->split(motion)) - motion).norm(), 1e-14);  // rounding of a product of 21 terms
  const VectorXd remainder = split->split(motion).head(21);
  // found 2e-15: rounding of the modes' orthogonality
  EXPECT_LT((split->mass_weighted_modes.transpose() * remainder).norm(), 2e-14);
}

TEST(DampedModeSplit, OutputsAreThoseOfTheWholeMotion) {
  const auto system = damped_chain(Damping::low_rank, 0.0, road);
  OutputMap map{{"y"},
                {"m"},
                SparseRows(1, 21),
                SparseRows(1, 21),
                SparseRows(1, 21),
                MatrixXd::Zero(1, 2),
                MatrixXd::Zero(1, 2),
                MatrixXd::Zero(1, 2),
                MatrixXd::Zero(1, 1)};
  map.displacement.insert(0, 5) = 2.0;
  map.displacement.insert(0, 9) = -1.0;
  const auto split = split_damped_modes(system);
  const VectorXd motion = VectorXd::LinSpaced(21, 3.0, 2.0);
  // rounding of a few terms of size 5
  EXPECT_NEAR((split->outputs(map).displacement * split->split(motion))[0], 2.0 * motion[5] - motion[9], 1e-14);
}

}  // namespace
}  // namespace kalfem
