// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "identification/chain_structure.hpp"
#include "kalfem/identification/simulation_residual.hpp"
#include "kalfem/identification/updating_setup.hpp"
#include "kalfem/updating/gauss_newton.hpp"
#include "kalfem/updating/sensitivity_check.hpp"

// Searches by a simulation whose model is not the structure that was recorded.

namespace kalfem::test {
namespace {

using Eigen::Index;

/// theta = [stiffness of body.3-4; stiffness of body.7-8; modal damping], 10 to 30 % off.
UpdatingSetup three_parameters(const StructureData& structure, double first_stiffness) {
  UpdatingSetup setup;
  for (const auto& [name, start] : {std::pair{"body.3-4.stiffness", first_stiffness},
                                    std::pair{"body.7-8.stiffness", 27e3}, std::pair{"body.damping.modal", 0.0013}}) {
    setup.bindings.push_back({std::ssize(setup.parameters), parameter(structure, name)});
    setup.parameters.push_back({.name = name, .initial = start, .lower = 0.0});
  }
  return setup;
}

/// The record of a chain with 0.1 % of damping against a chain whose wheel is softer: no theta explains it.
class OfAnotherWheel {
public:
  OfAnotherWheel(double wheel_factor, double first_stiffness) {
    auto problem = chain_problem();
    problem.structure = lightly_damped(wheel_stiffness);
    const auto structure = lightly_damped(wheel_factor * wheel_stiffness);
    const auto setup = three_parameters(*structure, first_stiffness);
    parameters = setup.parameters;
    residual = std::make_shared<SimulationResidual>(
        structure, problem.sensors, chain_record(problem, 3.0),
        std::make_shared<const ParameterisedStructure>(structure, setup.bindings, 3), parameters,
        SimulationResidual::Options{.name = "record", .settle = 0.1});
  }

  std::vector<UpdatingParameter> parameters;
  ResidualPtr residual;

private:
  static StructurePtr lightly_damped(double stiffness) {
    auto parts = chain_parts();
    parts.substructures[0].springs[0].stiffness = stiffness;
    parts.substructures[1].modal_damping = {0.001};
    return chain_structure(parts);
  }
};

TEST(SimulationSearch, ConvergesWhereTheModelIsWrong) {
  const OfAnotherWheel chain(0.7, 36e3);
  // 21 evaluations; 37 where J^T J alone stands for the curvature although the residual is large.
  const auto outcome = minimise(*chain.residual, chain.parameters, {.search = {.max_evaluations = 28}});
  EXPECT_TRUE(outcome.usable()) << outcome.reason();
  EXPECT_GT(outcome.residual.values.norm(), 2.0 * std::sqrt(static_cast<double>(chain.residual->size())));
}

TEST(SimulationSearch, DerivativesAreRightWhereTheResponseRings) {
  const OfAnotherWheel chain(0.9, 33e3);
  for (const auto& each : check_sensitivities(*chain.residual, chain.parameters, initial_values(chain.parameters))) {
    EXPECT_EQ(each.verdict, SensitivityComparison::Verdict::agrees) << each.parameter;
    EXPECT_LT(each.deviation, 0.1 * SimulationResidual::derivative_error) << each.parameter;
  }
}

}  // namespace
}  // namespace kalfem::test
