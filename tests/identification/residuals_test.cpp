// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identification/chain_structure.hpp"
#include "kalfem/identification/record_residual.hpp"
#include "kalfem/identification/simulation_residual.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// theta = [stiffness of every spring of the body]
UpdatingSetup body_stiffness_of(const StructureData& structure, double initial) {
  UpdatingSetup setup;
  setup.parameters = {{.name = "stiffness", .unit = "N/m", .initial = initial}};
  setup.true_parameters = {body_stiffness};
  for (const auto& spring : structure.parts.substructures[1].springs)
    setup.bindings.push_back({0, parameter(structure, "body." + spring.name + ".stiffness")});
  return setup;
}

std::shared_ptr<const ParameterisedStructure> parameterised(const StructurePtr& structure, const UpdatingSetup& setup) {
  return std::make_shared<const ParameterisedStructure>(structure, setup.bindings, 1);
}

VectorXd theta(double stiffness) { return VectorXd::Constant(1, stiffness); }

double mean_square(const Residual& residual, double stiffness) {
  const auto value = residual.evaluate(theta(stiffness), false);
  return value ? value->values.squaredNorm() / static_cast<double>(residual.size())
               : std::numeric_limits<double>::infinity();
}

/// The point to which a step of Gauss and Newton leads.
double after_a_step(const Residual& residual, double stiffness) {
  const auto value = residual.evaluate(theta(stiffness), true);
  if (!value) return std::numeric_limits<double>::quiet_NaN();
  const VectorXd column = value->jacobian.col(0);
  return stiffness - column.dot(value->values) / column.squaredNorm();
}

SimulationResidual simulation_residual(const EstimationProblem& problem, const Record& record,
                                       const SimulationResidual::Options& options = {.name = "record", .settle = 0.1}) {
  const auto setup = body_stiffness_of(*problem.structure, 0.99 * body_stiffness);
  return {problem.structure, problem.sensors, record, parameterised(problem.structure, setup),
          setup.parameters,  options};
}

TEST(SimulationResidual, IsNothingAtTheStructureThatMadeTheRecord) {
  const auto problem = chain_problem();
  const auto residual = simulation_residual(problem, chain_record(problem, 0.5, false));
  EXPECT_EQ(residual.size(), 401 * 4);
  EXPECT_LT(mean_square(residual, body_stiffness), 1e-16);
  EXPECT_GT(mean_square(residual, 0.99 * body_stiffness), 1e-3);
}

TEST(SimulationResidual, IsOfTheSizeOfTheNoise) {
  const auto problem = chain_problem();
  const auto residual = simulation_residual(problem, chain_record(problem, 1.0));
  EXPECT_NEAR(mean_square(residual, body_stiffness), 1.0, 0.1);  // of 3,604 samples: 2.4 % is one deviation
}

TEST(SimulationResidual, LeadsToTheStructureThatMadeTheRecord) {
  const auto problem = chain_problem();
  const auto residual = simulation_residual(problem, chain_record(problem, 0.5, false));
  EXPECT_NEAR(after_a_step(residual, 0.99 * body_stiffness), body_stiffness, 1e-3 * body_stiffness);
}

TEST(SimulationResidual, StartsAsItIsToldTo) {
  const auto problem = chain_problem();
  auto record = chain_record(problem, 0.2, false);
  const InitialMotion start = {{"body.10", {{0.002, 0.1}}}};
  std::vector<OutputDescription> outputs;
  for (const auto& sensor : problem.sensors) outputs.push_back(sensor.output);
  record.values = simulate_chain(*problem.structure, outputs, 0.2, start).every_sample;
  const auto at_rest = simulation_residual(problem, record);
  const auto started = simulation_residual(problem, record, {.name = "record", .initial = start});
  EXPECT_GT(mean_square(at_rest, body_stiffness), 1.0);
  EXPECT_LT(mean_square(started, body_stiffness), 1e-16);
}

TEST(SimulationResidual, LeavesOutSamplesThatAreMissing) {
  const auto problem = chain_problem();
  auto record = chain_record(problem, 0.5, false);
  record.values.block(1, 200, 1, 50).setConstant(std::numeric_limits<double>::quiet_NaN());
  const auto residual = simulation_residual(problem, record);
  const auto value = residual.evaluate(theta(0.99 * body_stiffness), true);
  ASSERT_TRUE(value);
  EXPECT_TRUE(value->values.allFinite());
  EXPECT_TRUE(value->values.segment(401 + 100, 50).isZero(0.0));
  EXPECT_TRUE(value->jacobian.col(0).segment(401 + 100, 50).isZero(0.0));
  EXPECT_GT(value->values.segment(401, 100).norm(), 0.0);
}

TEST(SimulationResidual, NeedsNoiseAndAResponse) {
  const auto problem = chain_problem();
  auto record = chain_record(problem, 0.2);
  const auto residual = simulation_residual(problem, record);
  EXPECT_FALSE(residual.evaluate(theta(-body_stiffness), false));
  record.channels[2].noise = 0.0;
  const std::string text = refusal([&] { simulation_residual(problem, record); });
  EXPECT_NE(text.find("'a6' has no noise"), std::string::npos) << text;
}

RecordResidual record_residual(const EstimationProblemPtr& problem, const Record& record,
                               double initial = 0.97 * body_stiffness) {
  const auto setup = body_stiffness_of(*problem->structure, initial);
  return {problem,
          record,
          parameterised(problem->structure, setup),
          setup,
          {.name = "record", .substructure = "body", .sensors = {"a4", "a10"}}};
}

EstimationProblemPtr settled_problem() {
  auto problem = chain_problem();
  problem.settings.settle = 0.5;
  return shared(problem);
}

TEST(RecordResidual, IsOfTheSizeOfTheInnovationsAtTheTruth) {
  const auto problem = settled_problem();
  const auto residual = record_residual(problem, chain_record(*problem, 2.0), body_stiffness);
  EXPECT_EQ(residual.size(), 1501 * 2);
  // The prediction does not see the samples that it is compared with, so that it is somewhat above one.
  const double at_truth = mean_square(residual, body_stiffness);
  EXPECT_NEAR(at_truth, 1.0, 0.25);
  EXPECT_GT(mean_square(residual, 0.97 * body_stiffness), at_truth);
  EXPECT_GT(mean_square(residual, 1.03 * body_stiffness), at_truth);
}

TEST(RecordResidual, LeadsToTheTruthBesideUnknownsOfTheFilter) {
  const auto problem = settled_problem();
  const auto residual = record_residual(problem, chain_record(*problem, 2.0));
  EXPECT_NEAR(after_a_step(residual, 0.97 * body_stiffness), body_stiffness, 0.01 * body_stiffness);
}

TEST(RecordResidual, SharesTheProblem) {
  auto problem = settled_problem();
  const auto residual = record_residual(problem, chain_record(*problem, 1.0));
  const std::weak_ptr<const EstimationProblem> watched = problem;
  problem.reset();
  EXPECT_FALSE(watched.expired());
  EXPECT_TRUE(std::isfinite(mean_square(residual, body_stiffness)));
}

TEST(RecordResidual, NeedsSamplesAfterSettlingAndASubstructureThatCanBeDriven) {
  auto given = chain_problem();
  given.settings.settle = 0.2;
  const auto problem = shared(given);
  const auto record = chain_record(*problem, 0.2);
  EXPECT_NE(refusal([&] { record_residual(problem, record); }).find("covers the whole record"), std::string::npos);
  const auto settled = settled_problem();
  const auto setup = body_stiffness_of(*settled->structure, body_stiffness);
  EXPECT_NE(refusal([&] {
              RecordResidual(settled, chain_record(*settled, 1.0), parameterised(settled->structure, setup), setup,
                             {.name = "record", .substructure = "wheel", .sensors = {"a4"}});
            }),
            "");
}

TEST(UpdatingSetup, GivesItsValuesByTheNamesOfAllThatTheyApplyTo) {
  const auto setup = body_stiffness_of(*chain_structure(), body_stiffness);
  const auto present = present_values(setup, theta(2.5e4));
  EXPECT_EQ(present.size(), 9u);
  EXPECT_EQ(present.at("body.9-10.stiffness"), 2.5e4);
}

}  // namespace
}  // namespace kalfem::test
