// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "identification/chain_structure.hpp"

namespace kalfem::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

AugmentedModelSetup setup_of(const EstimationProblem& problem, const PresentValues& present = {}) {
  IssueList issues;
  auto setup = make_augmented_model_setup(problem, problem.structure->parts, present, issues);
  EXPECT_EQ(text_of(issues), "");
  return setup;
}

std::string issues_of(const EstimationProblem& problem) {
  IssueList issues;
  make_augmented_model_setup(problem, problem.structure->parts, {}, issues);
  return text_of(issues);
}

/// A problem with one unknown of this name, at 80 % of its value.
EstimationProblem problem_with(const std::string& name) {
  EstimationProblem problem = chain_problem();
  const double value = parameter(*problem.structure, name).value;
  problem.settings.unknowns = {unknown(*problem.structure, name, 0.8 * value, 0.2 * value)};
  return problem;
}

TEST(AugmentedModelSetup, HoldsTheChainAndWhatIsToBeFound) {
  const auto problem = chain_problem();
  const auto setup = setup_of(problem);
  EXPECT_EQ(setup.model->system().size(), 11);
  EXPECT_EQ(setup.sensors.size(), 4u);
  EXPECT_EQ(setup.input_sources, std::vector<std::string>{"road"});
  ASSERT_EQ(setup.options.unknowns.size(), 2u);
  EXPECT_EQ(setup.options.unknowns[0].initial, 10.0);
  EXPECT_EQ(setup.options.unknowns[0].unit, "N");
  EXPECT_EQ(setup.options.unknowns[0].targets[0].parameter, 1);
  EXPECT_EQ(setup.true_parameters[1], true_mu_c1);
  // The guesses stand in the model, not the given values.
  EXPECT_EQ(setup.model->system().connectors[0].parameters[1], 10.0);
  EXPECT_EQ(setup.model->system().connectors[0].parameters[4], 16.0);
  EXPECT_EQ(setup.options.step, 1.0 / chain_rate);
  EXPECT_TRUE(setup.linear_unknowns.empty());
}

TEST(AugmentedModelSetup, TakesPresentValuesForFirstGuesses) {
  const auto setup = setup_of(chain_problem(), {{"suspension.mu_k1", 18.0}, {"another", 1.0}});
  EXPECT_EQ(setup.options.unknowns[0].initial, 18.0);
  EXPECT_EQ(setup.options.unknowns[1].initial, 16.0);
}

TEST(AugmentedModelSetup, PriorsOfSinglePointsCountMoreThanThatOfAll) {
  auto problem = chain_problem();
  problem.settings.initial_state = {{"body.1", {{0.002, 0.0, 0.5, 0.6}}}, {"all", {{0.001, 0.0, 0.3, 0.4}}}};
  problem.settings.process_noise = {.acceleration = 0.1, .accelerations = {{"body.2", {0.7}}}};
  const auto& options = setup_of(problem).options;
  EXPECT_EQ(options.prior.mean.displacement[0], 0.001);
  EXPECT_EQ(options.prior.mean.displacement[1], 0.002);
  EXPECT_EQ(options.prior.displacement_deviation[1], 0.5);
  EXPECT_EQ(options.prior.velocity_deviation[2], 0.4);
  EXPECT_EQ(options.process_noise.acceleration[1], 0.1);
  EXPECT_EQ(options.process_noise.acceleration[2], 0.7);
}

TEST(AugmentedModelSetup, TellsEverythingThatTheModelDoesNotHave) {
  auto problem = chain_problem();
  problem.settings.initial_state.push_back({"body.11", {{}, {"chain.yaml", 3}, "initial_state"}});
  problem.settings.process_noise.accelerations = {{"wheel.v", {1.0, {"chain.yaml", 4}, "process_noise"}}};
  problem.settings.initial_connector_states = {{"suspension.z", {{}, {"chain.yaml", 5}, "states"}}};
  const std::string text = issues_of(problem);
  EXPECT_NE(text.find("chain.yaml:3"), std::string::npos) << text;
  EXPECT_NE(text.find("chain.yaml:4"), std::string::npos) << text;
  EXPECT_NE(text.find("chain.yaml:5"), std::string::npos) << text;
}

TEST(AugmentedModelSetup, NeedsASensor) {
  auto problem = chain_problem();
  problem.sensors.clear();
  EXPECT_NE(issues_of(problem).find("no sensor is attached to the modelled part"), std::string::npos);
  problem.sensors = {accelerometer("a", "body.11")};
  EXPECT_NE(issues_of(problem).find("body.11"), std::string::npos);
}

TEST(AugmentedModelSetup, CarriesASpringByAConnectorWhereNoDampingIsMadeOfIt) {
  const auto setup = setup_of(problem_with("wheel.k_w.stiffness"));
  EXPECT_TRUE(setup.linear_unknowns.empty());
  EXPECT_EQ(setup.model->system().connectors.size(), 2u);
  EXPECT_FALSE(setup.options.unknowns[0].in_linear_part);
}

TEST(AugmentedModelSetup, LetsModalDampingFollowAReleasedSpring) {
  const auto setup = setup_of(problem_with("body.1-2.stiffness"));
  EXPECT_TRUE(setup.options.unknowns[0].in_linear_part);
  EXPECT_EQ(setup.linear_unknowns.names, std::vector<std::string>{"body.1-2.stiffness"});
  EXPECT_TRUE(setup.linear_unknowns.bindings.empty());  // its connector carries it
}

TEST(AugmentedModelSetup, RefusesANonPositiveGuessOfWhatDampingIsMadeOf) {
  auto problem = problem_with("body.1-2.stiffness");
  problem.settings.unknowns[0].transform = {};
  EXPECT_EQ(issues_of(problem), "");
  problem.settings.unknowns[0].initial = 0.0;
  EXPECT_NE(issues_of(problem).find("'body.1-2.stiffness' starts at 0 N/m"), std::string::npos);
}

TEST(AugmentedModelSetup, AddsARestPositionForTheSensorsThatAreUsed) {
  auto problem = chain_problem();
  problem.offsets = {rest_position("a6", 0.1), rest_position("elsewhere", 0.2)};
  const auto setup = setup_of(problem);
  ASSERT_EQ(setup.options.unknowns.size(), 3u);
  EXPECT_EQ(setup.options.unknowns[2].name, "rest.a6");
  EXPECT_EQ(setup.options.unknowns[2].sensors, std::vector<Eigen::Index>{2});
  EXPECT_FALSE(setup.true_parameters[2]);
}

class LinearUnknown : public testing::TestWithParam<const char*> {};

/// The filter's system at other values is the structure with these values in it: its connectors carry no departure. The
/// problem is gone by then.
TEST_P(LinearUnknown, MovesTheSystemThatOutlivesTheProblem) {
  auto problem = shared(problem_with(GetParam()));
  const Parameter moved = problem->settings.unknowns[0].targets[0];
  const VectorXd value = VectorXd::Constant(1, 1.2 * moved.value);
  auto expected_parts = problem->structure->parts;
  ASSERT_TRUE(set_parameter(expected_parts, moved, value[0]));
  const CoupledModel expected = couple(expected_parts);

  auto setup = std::make_unique<AugmentedModelSetup>(setup_of(*problem));
  const CoupledModel at_truth = couple(parts_at(*problem, setup->linear_unknowns, VectorXd::Constant(1, moved.value)));
  EXPECT_EQ(at_truth.system().size(), 11);
  const auto system_at = system_of_linear_unknowns(problem, *setup);
  const std::weak_ptr<const EstimationProblem> watched = problem;
  problem.reset();
  setup.reset();
  EXPECT_FALSE(watched.expired());  // the function shares it
  ASSERT_TRUE(system_at);
  const auto system = system_at(value);
  EXPECT_LT((MatrixXd(system.stiffness) - MatrixXd(expected.system().stiffness)).norm(), 1e-9);
  EXPECT_LT((MatrixXd(system.mass) - MatrixXd(expected.system().mass)).norm(), 1e-12);
  EXPECT_LT((MatrixXd(system.damping) - MatrixXd(expected.system().damping)).norm(), 1e-9);
}
INSTANTIATE_TEST_SUITE_P(Chain, LinearUnknown,
                         testing::Values("body.damping.modal.1", "body.4-5.stiffness", "body.7.mass"));

TEST(LinearUnknowns, OfNoneHaveNoSystem) {
  const auto problem = shared(chain_problem());
  EXPECT_FALSE(system_of_linear_unknowns(problem, setup_of(*problem)));
}

TEST(SetUnknowns, SetsTheElementsOfOneSubstructureThatAreNotRefined) {
  auto problem = chain_problem();
  const auto& structure = *problem.structure;
  problem.settings.unknowns = {unknown(structure, "wheel.k_w.stiffness", 1e4, 1e3),
                               unknown(structure, "body.1-2.stiffness", 1e4, 1e3),
                               unknown(structure, "body.2-3.stiffness", 1e4, 1e3)};
  auto parts = structure.parts;
  const VectorXd values = Eigen::Vector3d(1.1e4, 2.2e4, 3.3e4);
  EXPECT_TRUE(set_unknowns(problem, "body", values, {{"body.2-3.stiffness", 0.0}}, parts));
  EXPECT_EQ(parts.substructures[0].springs[0].stiffness, wheel_stiffness);
  EXPECT_EQ(parts.substructures[1].springs[0].stiffness, 2.2e4);
  EXPECT_EQ(parts.substructures[1].springs[1].stiffness, body_stiffness);
  EXPECT_FALSE(set_unknowns(problem, "elsewhere", values, {}, parts));
}

}  // namespace
}  // namespace kalfem::test
