// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "identification/chain_structure.hpp"
#include "kalfem/identification/local_model.hpp"

namespace kalfem::test {
namespace {

Located<Interface> measured_by(const std::string& sensor) {
  return {{InterfaceAcceleration{{sensor}, 1e-5, 1e-3}}, {"chain.yaml", 9}, "interface"};
}

/// The body alone, driven by the wheel's measured acceleration.
EstimationProblem local_problem(double noise = 0.01) {
  EstimationProblem problem = chain_problem();
  problem.sensors.push_back(accelerometer("wheel", "wheel.w", noise));
  problem.settings.local = LocalModelOptions{{{"body"}}, {{"wheel.w", measured_by("wheel")}}};
  return problem;
}

AugmentedModelSetup setup_of(const EstimationProblem& problem, std::string& text) {
  IssueList issues;
  auto setup = make_augmented_model_setup(problem, problem.structure->parts, {}, issues);
  text = text_of(issues);
  return setup;
}

TEST(LocalModel, HoldsTheBodyAndItsConnectorToAPointThatMovesAsMeasured) {
  std::string text;
  const auto setup = setup_of(local_problem(), text);
  EXPECT_EQ(text, "");
  const auto& system = setup.model->system();
  EXPECT_EQ(system.size(), 10);
  EXPECT_EQ(system.dofs.front(), "body.1");
  ASSERT_EQ(system.connectors.size(), 1u);
  EXPECT_EQ(setup.input_sources, std::vector<std::string>{"@wheel"});
  EXPECT_EQ(setup.options.inputs[0].model, InputModel::integrated);
  EXPECT_EQ(setup.options.prior.input_deviation[0], 1e-5);
  EXPECT_EQ(setup.options.prior.input_rate_deviation[0], 1e-3);
  // The sensor that drives the model is none of its sensors.
  EXPECT_EQ(setup.sensors.size(), 4u);
}

TEST(LocalModel, TakesTheConnectorsPlaceByAnUnknownForce) {
  auto problem = local_problem();
  problem.settings.unknowns.clear();
  problem.settings.local->interface = {{"body.1", {{InterfaceForce{50.0, 0.2}}, {}, ""}}};
  std::string text;
  const auto setup = setup_of(problem, text);
  EXPECT_EQ(text, "");
  EXPECT_TRUE(setup.model->system().connectors.empty());
  EXPECT_EQ(setup.input_sources, std::vector<std::string>{""});
  EXPECT_EQ(setup.options.inputs[0].model, InputModel::latent);
  EXPECT_EQ(setup.options.prior.input_deviation[0], 50.0);
  // x' = -x/tau + w of variance s^2 has the density 2 s^2 / tau.
  EXPECT_NEAR(setup.options.process_noise.input[0], 50.0 * std::sqrt(2.0 / 0.2), 1e-12);
}

TEST(LocalModel, KeepsTheGroundOfWhatIsLeftOutWhereAConnectorEndsThere) {
  auto parts = chain_parts();
  parts.connectors[0].from = "wheel.ground";
  const auto structure = chain_structure(parts);
  const LocalModelOptions local{{{"body"}}, {}};
  IssueList issues;
  LocalModel model(local, parts, issues);
  AugmentedModelSetup setup;
  model.apply(setup);
  EXPECT_TRUE(issues.empty());
  EXPECT_EQ(parts.connectors.size(), 1u);
  EXPECT_EQ(setup.input_sources, std::vector<std::string>{"road"});  // still drives that ground
  EXPECT_EQ(couple(parts).system().size(), 10);
}

TEST(LocalModel, RefusesWhatItDoesNotKnowWithTheNearestName) {
  auto problem = local_problem();
  problem.settings.local->substructures.push_back({"bodi", {"chain.yaml", 8}, "estimate.local.substructures[2]"});
  std::string text;
  setup_of(problem, text);
  EXPECT_NE(text.find("chain.yaml:8"), std::string::npos) << text;
  EXPECT_NE(text.find("no substructure 'bodi' (did you mean 'body'?)"), std::string::npos) << text;
}

TEST(LocalModel, RefusesAnInterfaceInsideItself) {
  auto problem = local_problem();
  problem.settings.local->interface = {{"body.1", measured_by("a2")}};
  std::string text;
  setup_of(problem, text);
  EXPECT_NE(text.find("must lie outside the local substructures"), std::string::npos) << text;
}

TEST(LocalModel, FindsTheSuspensionWithoutKnowingTheRoad) {
  const auto problem = shared(local_problem());
  std::string text;
  const auto setup = setup_of(*problem, text);
  const auto result = run(make_filter_run(problem, setup, chain_record(*problem, 4.0)));
  ASSERT_FALSE(result.failure) << result.failure->reason;
  const Eigen::VectorXd mean = result.unknowns.mean.rightCols(1), deviation = result.unknowns.deviation.rightCols(1);
  EXPECT_NEAR(mean[0], true_mu_k1, 0.03 * true_mu_k1);
  EXPECT_NEAR(mean[1], true_mu_c1, 0.03 * true_mu_c1);
  EXPECT_LT(deviation[0], 0.05 * true_mu_k1);  // the first guess had 25 %
}

}  // namespace
}  // namespace kalfem::test
