// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/candidate_information.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identification/chain_structure.hpp"
#include "kalfem/information/identifiability.hpp"
#include "kalfem/system/signals/sampled.hpp"

// What candidate sensors would tell, from the sensitivities of their noise-free outputs.

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const std::vector<std::string> suspension = {"suspension.mu_k1", "suspension.mu_c1"};
const VectorXd truth = Eigen::Vector2d(true_mu_k1, true_mu_c1);

Record time_of(double duration, double rate = chain_rate) {
  Record drive{.sample_rate = rate};
  drive.values.resize(0, static_cast<Index>(std::llround(duration * rate)) + 1);
  return drive;
}

CandidateSensor candidate(const Sensor& sensor) { return {sensor.name, {sensor}}; }

std::vector<CandidateSensor> accelerometers() {
  return {candidate(accelerometer("a1", "wheel.w")), candidate(accelerometer("a5", "body.4")),
          candidate(accelerometer("a11", "body.10"))};
}

TEST(CandidateInformation, OfAnOscillatorHasItsClosedForm) {
  // m z'' + k z = f from rest: z = f / k (1 - cos(w t)), w^2 = k / m, dw/dk = w / (2 k).
  auto structure = std::make_shared<StructureData>();
  LumpedSubstructure oscillator;
  oscillator.name = "oscillator";
  oscillator.masses = {{"m", 2.0}};
  oscillator.springs = {{"k", "ground", "m", 200.0}};
  structure->parts.substructures = {oscillator};
  structure->parts.inputs = {{"push", InputKind::force, "oscillator.m"}};
  structure->signals = {make_sampled(VectorXd::Constant(3001, 200.0), {.sample_rate = 1000.0})};
  EstimationProblem problem{.structure = structure, .sample_rate = 1000.0};
  problem.settings.unknowns = {unknown(*structure, "oscillator.k.stiffness", 200.0, 20.0)};
  const Sensor sensor{
      .name = "z", .output = {"z", ObservedQuantity::displacement, {{"oscillator.m", 1.0}}}, .noise = 0.01};
  const auto found = candidate_information(shared(problem), time_of(3.0), {candidate(sensor)},
                                           {"oscillator.k.stiffness"}, VectorXd::Constant(1, 200.0));
  ASSERT_TRUE(found);
  double expected = 0.0;
  for (int k = 0; k <= 3000; ++k) {
    const double t = 1e-3 * k, w = 10.0;
    const double slope = -(1 - std::cos(w * t)) / 200.0 + std::sin(w * t) * t * w / 400.0;
    expected += slope * slope / 1e-4;
  }
  // an exact solution; the central difference over 1e-3 of k errs by (w t step)^2 / 24 of a column
  EXPECT_NEAR((*found)[0](0, 0), expected, 1e-4 * expected);
}

TEST(CandidateInformation, IsThatOfDifferencesOfTheRecord) {
  const auto problem = shared(chain_problem());
  const auto found = candidate_information(problem, time_of(2.0), accelerometers(), suspension, truth);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), 3U);
  const auto record = [&](double mu_k1) {
    StructureParts parts = chain_parts();
    parts.connectors[0].parameters[1] = mu_k1;
    return simulate_chain(*chain_structure(parts), {accelerometers()[1].channels[0].output}, 2.0).every_sample;
  };
  const double sigma = 0.05 * rms(record(true_mu_k1).row(0).transpose());
  const MatrixXd slope = (record(1.01 * true_mu_k1) - record(0.99 * true_mu_k1)) / (0.02 * true_mu_k1);
  // another step of the difference, of the second order
  EXPECT_NEAR((*found)[1](0, 0), slope.squaredNorm() / (sigma * sigma), 1e-2 * (*found)[1](0, 0));
}

// With a known road and start and no process noise nothing is integrated out, so the filter knows as much as the sum.
// They differ by their simulations: exact steps of the filter's model, Newmark's of the other.
TEST(CandidateInformation, IsThatOfTheFilterWhereNothingIsIntegratedOut) {
  auto given = chain_problem();
  given.settings.initial_state = {{"all", {{0.0, 0.0, 1e-9, 1e-9}}}};
  const auto problem = shared(given);
  const auto alone = candidate_information(problem, time_of(2.0), accelerometers(), suspension, truth);
  const auto set = set_information(problem, time_of(2.0), accelerometers(), suspension, truth);
  ASSERT_TRUE(alone && set);
  const MatrixXd sum = (*alone)[0] + (*alone)[1] + (*alone)[2];
  EXPECT_LT((*set - sum).norm(), 0.02 * sum.norm()) << *set << "\n" << sum;

  given.settings.process_noise.acceleration = 1.0;
  const auto less = set_information(shared(given), time_of(2.0), accelerometers(), suspension, truth);
  ASSERT_TRUE(less);
  EXPECT_LT(less->trace(), 0.9 * sum.trace());
  EXPECT_THROW(set_information(problem, time_of(2.0), {}, suspension, truth), InvalidInput);
}

TEST(CandidateInformation, AddsUpOverTheChannelsOfACandidateAndDoesNotDependOnThreads) {
  const auto problem = shared(chain_problem());
  auto candidates = accelerometers();
  candidates.push_back({"pair", {candidates[0].channels[0], candidates[2].channels[0]}});
  candidates[3].channels[0].name = "b1";
  candidates[3].channels[1].name = "b11";
  const auto one = candidate_information(problem, time_of(1.0), candidates, suspension, truth, {.threads = 1});
  const auto two = candidate_information(problem, time_of(1.0), candidates, suspension, truth, {.threads = 2});
  ASSERT_TRUE(one && two);
  for (std::size_t i = 0; i < one->size(); ++i) EXPECT_EQ((*one)[i], (*two)[i]);
  EXPECT_LT(((*one)[3] - (*one)[0] - (*one)[2]).norm(), 1e-12 * (*one)[3].norm());
}

TEST(CandidateInformation, PassesTheMeasurementChain) {
  const auto problem = shared(chain_problem());
  auto candidates = accelerometers();
  candidates.resize(1);
  const auto wide = candidate_information(problem, time_of(1.0), candidates, suspension, truth);
  Sensor& channel = candidates[0].channels[0];
  channel.chain = MeasurementChain({.sections = {GainSection{-2.0}}});
  const auto twice = candidate_information(problem, time_of(1.0), candidates, suspension, truth);
  channel.relative_noise = false;
  channel.noise = 1.0;
  channel.chain = MeasurementChain({.sections = {FilterSection{.cutoff = 400.0}}});
  const auto open = candidate_information(problem, time_of(1.0), candidates, suspension, truth);
  channel.chain = MeasurementChain({.sections = {FilterSection{.cutoff = 5.0}}});
  const auto narrow = candidate_information(problem, time_of(1.0), candidates, suspension, truth);
  ASSERT_TRUE(wide && twice && open && narrow);
  EXPECT_LT(((*wide)[0] - (*twice)[0]).norm(), 1e-9 * (*wide)[0].norm());  // its noise doubles with it
  EXPECT_LT((*narrow)[0].norm(), 0.1 * (*open)[0].norm());
}

/// Three masses on a moving ground, all of its numbers unknown: no acceleration tells its scale.
TEST(CandidateInformation, OfAccelerationsDeterminesOnlyRatiosOfMassesAndStiffnesses) {
  auto structure = std::make_shared<StructureData>();
  LumpedSubstructure tower;
  tower.name = "tower";
  tower.masses = {{"1", 2.0}, {"2", 1.5}, {"3", 1.0}};
  tower.springs = {{"s1", "ground", "1", 4e3}, {"s2", "1", "2", 3e3}, {"s3", "2", "3", 2e3}};
  tower.modal_damping = {0.02};
  structure->parts.substructures = {tower};
  structure->parts.inputs = {{"quake", InputKind::base_displacement, "tower.ground"}};
  structure->signals = {
      make_random({.rms = 3e-3, .lower = 0.5, .upper = 15.0, .duration = 10.0, .fade_in = 0.5, .seed = 3})};
  EstimationProblem problem{.structure = structure, .sample_rate = 200.0};
  const std::vector<std::string> names = {"tower.1.mass",       "tower.2.mass",       "tower.3.mass",
                                          "tower.s1.stiffness", "tower.s2.stiffness", "tower.s3.stiffness"};
  std::vector<InformedParameter> parameters;
  VectorXd theta(6);
  for (const auto& name : names) {
    const double value = parameter(*structure, name).value;
    theta[static_cast<Index>(parameters.size())] = value;
    problem.settings.unknowns.push_back(unknown(*structure, name, value, 0.3 * value));
    parameters.push_back({name, value, std::numeric_limits<double>::infinity()});
  }
  const auto found = candidate_information(
      shared(problem), time_of(10.0, 200.0),
      {{"all", {accelerometer("a1", "tower.1"), accelerometer("a2", "tower.2"), accelerometer("a3", "tower.3")}}},
      names, theta);
  ASSERT_TRUE(found);
  const auto judged = identifiability(found->front(), parameters);
  // with a step of 1e-3, the error of the differences gave it a deviation of 4.4 values
  EXPECT_EQ(
      judged.text,
      "Only ratios of tower.1.mass, tower.2.mass, tower.3.mass, tower.s1.stiffness, tower.s2.stiffness and "
      "tower.s3.stiffness are determined: the record does not change when all are multiplied by the same factor.");
  for (std::size_t i = 0; i < 5; ++i) EXPECT_TRUE(judged.combinations[i].determined) << judged.combinations[i].words;
}

TEST(CandidateInformation, RefusesWhatItCannotCompute) {
  const auto message = [](const EstimationProblem& problem, const std::vector<CandidateSensor>& candidates,
                          const std::vector<std::string>& names, const VectorXd& theta) {
    return refusal([&] { candidate_information(shared(problem), time_of(0.1), candidates, names, theta); });
  };
  EXPECT_NE(message(chain_problem(), accelerometers(), {"suspension.mu_k1", "suspension.mu_c"}, truth)
                .find("'suspension.mu_c' is no unknown of the structure"),
            std::string::npos);
  EXPECT_NE(message(chain_problem(), accelerometers(), {"suspension.mu_k1"}, truth).find("2 values and 0 scales for 1"),
            std::string::npos);
  auto silent = accelerometers();
  silent[0].channels[0].noise = 0.0;
  EXPECT_NE(message(chain_problem(), silent, suspension, truth).find("'a1' has a channel with the noise 0"),
            std::string::npos);
  auto unknown_road = chain_problem();
  unknown_road.settings.unknown_inputs = {{.name = "road"}};
  EXPECT_NE(message(unknown_road, accelerometers(), suspension, truth).find("the excitation 'road' is unknown"),
            std::string::npos);
  EXPECT_NE(message(chain_problem(), {candidate(accelerometer("x", "body.12"))}, suspension, truth).find("body.12"),
            std::string::npos);
}

}  // namespace
}  // namespace kalfem::test
