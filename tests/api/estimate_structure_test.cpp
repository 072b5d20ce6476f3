// SPDX-License-Identifier: Apache-2.0
#include "chain.hpp"
#include "kalfem/identification/filter_run.hpp"

namespace kalfem {
namespace {

using testing::HasSubstr;

const std::vector<UnknownDescription> unknowns = {{"suspension.mu_k1", {.initial = 10.0, .std = 5.0}},
                                                  {"body.2-3.stiffness", {.initial = 2.5e4, .std = 5e3}}};

/// The problem of the chain as the library's own types have it.
EstimationProblemPtr chain_problem() {
  StructureModel model;
  LumpedSubstructure wheel{.name = "wheel", .masses = {{"w", 1.5}}, .springs = {{"k_w", "ground", "w", 2e4}}};
  LumpedSubstructure body{.name = "body",
                          .masses = {{"1", 1.0}, {"2", 1.0}, {"3", 1.0}, {"4", 1.0}},
                          .springs = {{"1-2", "1", "2", 3e4}, {"2-3", "2", "3", 3e4}, {"3-4", "3", "4", 3e4}},
                          .modal_damping = {0.01}};
  const Law law = suspension_law(20.0);
  model.parts.substructures = {wheel, body};
  model.parts.connectors = {{"suspension", "wheel.w", "body.1", law.law, law.values}};
  model.parts.inputs = {{"road", InputKind::base_displacement, "wheel.ground"}};
  model.signals = {road()};
  EstimationProblem problem;
  problem.structure = std::make_shared<const StructureModel>(model);
  for (const auto& given : chain_sensors()) {
    Sensor sensor{.name = given.name, .output = given.output};
    sensor.noise = given.noise;
    problem.sensors.push_back(sensor);
  }
  problem.sample_rate = chain_record().sample_rate;
  const ParameterSet all(*problem.structure);
  problem.settings.unknowns = {
      {.name = "suspension.mu_k1", .targets = {*all.find("suspension.mu_k1")}, .initial = 10.0, .deviation = 5.0},
      {.name = "body.2-3.stiffness",
       .targets = {*all.find("body.2-3.stiffness")},
       .transform = {TransformKind::log},
       .initial = 2.5e4,
       .deviation = 5e3}};
  return std::make_shared<const EstimationProblem>(problem);
}

TEST(EstimateStructure, GivesTheEstimatesOfTheSameProblemInTheLibrarysOwnTypes) {
  const auto problem = chain_problem();
  IssueList issues;
  auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  ASSERT_TRUE(issues.empty());
  setup.options.substeps = 4;
  const auto expected = run_filter(problem, setup, chain_record(), {.state_deviations = false}).result;

  const auto result = estimate(driven_chain(), chain_record(),
                               {.sensors = chain_sensors(), .unknowns = unknowns, .substeps = 4, .diagnose = false});

  ASSERT_TRUE(result.usable());
  for (Eigen::Index i = 0; i < 2; ++i) {
    const auto& parameter = result.parameters[static_cast<std::size_t>(i)];
    EXPECT_NEAR(parameter.mean / expected.unknowns.mean.rightCols(1)(i), 1.0, 1e-10);
    EXPECT_NEAR(parameter.std / expected.unknowns.deviation.rightCols(1)(i), 1.0, 1e-8);
  }
  EXPECT_NEAR(result.log_likelihood, expected.log_likelihood, 1e-6);
}

TEST(EstimateStructure, FindsTheParametersThatMadeTheRecord) {
  const auto result = estimate(driven_chain(), chain_record(), {.sensors = chain_sensors(), .unknowns = unknowns});
  EXPECT_EQ(result.parameters[0].name, "suspension.mu_k1");
  EXPECT_EQ(result.parameters[0].unit, "N");
  EXPECT_NEAR(result.parameter("suspension.mu_k1").mean, 20.0, 3.0 * result.parameters[0].std);
  EXPECT_LT(result.parameters[0].std, 2.0);
  EXPECT_NEAR(result.parameter("body.2-3.stiffness").mean, 3e4, 3.0 * result.parameters[1].std);
  EXPECT_NEAR(result.mean_nis(0.5), 2.0, 0.3);
}

TEST(EstimateStructure, GivesStatesAndVirtualSensorsByName) {
  const auto truth =
      simulate(driven_chain(), {.sensors = {{"x", displacement("body.1")}, {"f", connector_force("suspension")}},
                                .duration = 2.0,
                                .sample_rate = 500.0})
          .record;
  const auto result = estimate(driven_chain(), chain_record(),
                               {.sensors = chain_sensors(), .outputs = {{"force", connector_force("suspension")}}});
  EXPECT_LT(nrmse(result.state("body.1.displacement").mean, truth.values.row(0).transpose()), 0.05);
  EXPECT_LT(nrmse(result.output("force").mean, truth.values.row(1).transpose()), 0.1);
  EXPECT_EQ(result.state("body.1.displacement").unit, "m");
  EXPECT_EQ(result.output("force").unit, "N");
}

TEST(EstimateStructure, AFilterThatStopsIsAValue) {
  // A law whose force is no number at large rates: the filter's model cannot be evaluated from there on.
  Structure s = chain_structure();
  s.connect("bad", "wheel.w", "body.2", law("bad", {{"k", 1.0}}, [](double d, double v, std::span<const double> p) {
              return std::abs(v) > 0.05 ? std::nan("") : p[0] * d;
            }));
  s.base_displacement("road", "wheel.ground", road());
  const auto result = estimate(s, chain_record(), {.sensors = chain_sensors()});
  ASSERT_FALSE(result.usable());
  EXPECT_GT(result.failure->time, 0.0);
  EXPECT_THAT(result.failure->reason, HasSubstr("force"));
  EXPECT_EQ(result.verdict.state(), VerdictState::unusable);
  const auto reasons = result.verdict.reasons();
  ASSERT_TRUE(std::ranges::any_of(reasons, [](const Reason& each) { return each.code == "failed"; }));
}

TEST(EstimateArguments, AreNamedByTheirPlaceWhereTheyAreWrong) {
  EstimateOptions options{.sensors = chain_sensors(), .unknowns = unknowns};
  options.sensors.push_back({"a9", acceleration("body.9"), 0.3});
  options.sensors[0].noise = 0.0;
  options.unknowns.push_back({"suspension.mu_k9", {.initial = 1.0}});
  options.unknowns[1].prior.initial = -1.0;
  options.unknowns[1].prior.transform = ParameterTransform{TransformKind::log};
  options.outputs = {{"f", connector_force("suspention")}};
  Record record = chain_record();
  record.channels.push_back({"a9", "m/s^2"});
  record.values.conservativeResize(3, Eigen::NoChange);
  record.values.row(2).setZero();
  const auto message = refusal_of([&] { return estimate(driven_chain(), record, options); });
  EXPECT_THAT(message, HasSubstr("sensors[0].noise 'a3': it is 0"));
  EXPECT_THAT(message, HasSubstr("sensors[2] 'a9': "));
  EXPECT_THAT(message, HasSubstr("body.9"));
  EXPECT_THAT(message, HasSubstr("unknowns[1].initial 'body.2-3.stiffness': it is -1"));
  EXPECT_THAT(message, HasSubstr("unknowns[2] 'suspension.mu_k9': there is no parameter 'suspension.mu_k9' (did you "
                                 "mean 'suspension.mu_k1'?)"));
  EXPECT_THAT(message, HasSubstr("outputs[0] 'f': "));
}

TEST(EstimateArguments, ThatAreMissingAreRefused) {
  const auto refused = [](const EstimateOptions& options) {
    return refusal_of([&] { return estimate(driven_chain(), chain_record(), options); });
  };
  EXPECT_THAT(refused({.sensors = {}}), HasSubstr("sensors: the list is empty"));
  EXPECT_THAT(refused({.sensors = {{"a4", acceleration("body.2"), 0.3}}}),
              HasSubstr("sensors[0] 'a4': the record has no channel of that name (did you mean 'a"));
  EXPECT_THAT(refused({.sensors = {chain_sensors()[0], chain_sensors()[0]}}),
              HasSubstr("sensors[1] 'a3': sensors[0] has that name too"));
  EXPECT_THAT(refused({.sensors = chain_sensors(), .initial_state = {{"body.7", {}}}}),
              HasSubstr("initial_state[0]: 'body.7' is not a degree of freedom"));
  EXPECT_THAT(refused({.sensors = chain_sensors(), .substeps = 0}), HasSubstr("substeps: 0"));
  EXPECT_THAT(refused({.sensors = chain_sensors(), .unknowns = {{"suspension.k", {.initial = 0.0}}}}),
              HasSubstr("unknowns[0].std 'suspension.k': it is 0"));
  const ParameterTransform bounds{TransformKind::logit, 0.0, 1.0};
  EXPECT_THAT(
      refused({.sensors = chain_sensors(), .unknowns = {{"suspension.k", {.initial = 2.0, .transform = bounds}}}}),
      HasSubstr("unknowns[0].initial 'suspension.k': it is 2, outside its bounds 0 to 1"));
}

TEST(EstimateArguments, AnInputWithoutASignalIsNamed) {
  const Structure s = chain_structure().base_displacement("road", "wheel.ground");
  EXPECT_THAT(refusal_of([&] { return estimate(s, chain_record(), {.sensors = chain_sensors()}); }),
              HasSubstr("input 'road' has no signal"));
}

TEST(EstimatePrior, IsOfTheStructuresOwnValueWhereItIsNotGiven) {
  const auto given =
      estimate(driven_chain(), chain_record(),
               {.sensors = chain_sensors(), .unknowns = {{"suspension.k", {.initial = 5e3, .std = 2.5e3}}}});
  const auto left_out =
      estimate(driven_chain(), chain_record(), {.sensors = chain_sensors(), .unknowns = {{"suspension.k"}}});
  EXPECT_EQ(given.parameters[0].mean, left_out.parameters[0].mean);
}

TEST(EstimatePrior, SeveralParametersMayShareAValue) {
  const std::vector<std::string> springs = {"body.1-2.stiffness", "body.2-3.stiffness", "body.3-4.stiffness"};
  const auto result = estimate(
      driven_chain(), chain_record(),
      {.sensors = chain_sensors(), .unknowns = {{"springs", {.initial = 2.5e4, .std = 5e3, .applies_to = springs}}}});
  EXPECT_NEAR(result.parameter("springs").mean, 3e4, 3.0 * result.parameters[0].std);
}

}  // namespace
}  // namespace kalfem
