// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identification/chain_structure.hpp"
#include "kalfem/base/parallel.hpp"
#include "kalfem/estimation/consistency.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

FilterRun run_of(const EstimationProblemPtr& problem, const Record& record) {
  IssueList issues;
  const auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  issues.raise();
  return make_filter_run(problem, setup, record);
}

TEST(FilterRun, HandsTheSensorsChannelsAndTheRoadToTheFilter) {
  const auto problem = shared(chain_problem());
  Record record = chain_record(*problem, 0.1);
  // in another order, with a channel that no sensor has
  record.channels = {{"a10", "", 10.0}, {"extra", "", 0.0}, {"a4", "", 4.0}, {"a2", "", 2.0}, {"a6", "", 6.0}};
  record.values = Eigen::MatrixXd::Random(5, 101);
  const auto run = run_of(problem, record);
  EXPECT_EQ(run.input.measured.noise(), VectorXd(Eigen::Vector4d(2.0, 4.0, 6.0, 10.0)));
  ASSERT_EQ(run.input.measured.samples(), 101);
  EXPECT_TRUE(run.input.measured.values.row(0) == record.values.row(3));
  EXPECT_TRUE(run.input.measured.values.row(3) == record.values.row(0));
  EXPECT_EQ(run.input.noise(2, 2), 36.0);
  // [r; r'; r''] at every substep
  const auto road = problem->structure->signals[0]->sample(0.0, 0.25 / chain_rate, 401);
  EXPECT_TRUE(run.input.inputs.transpose() == road.matrix());
}

TEST(FilterRun, HidesTheSamplesThatTheFilterMustNotLearnFrom) {
  const auto problem = shared(chain_problem());
  Record record = chain_record(*problem, 0.1);
  record.used = 60;
  const auto run = run_of(problem, record);
  VectorXd seen;
  for (Index k = 0; k < 101; ++k) {
    run.input.sample(k, seen);
    EXPECT_EQ(seen.allFinite(), k < 60) << k;
    EXPECT_EQ(seen.array().isNaN().all(), k >= 60) << k;
  }
  EXPECT_TRUE(run.input.measured.values.allFinite());  // for comparison
  const auto result = kalfem::test::run(run);
  EXPECT_EQ(result.measured.head(60).minCoeff(), 4);
  EXPECT_EQ(result.measured.tail(41).maxCoeff(), 0);
}

/// A channel that misses a sample goes to the filter as it is: it updates by the others.
TEST(FilterRun, KeepsMissingSamplesMissing) {
  const auto problem = shared(chain_problem());
  Record record = chain_record(*problem, 0.1);
  record.values(1, 30) = std::numeric_limits<double>::quiet_NaN();
  record.values.col(40).setConstant(std::numeric_limits<double>::quiet_NaN());
  const auto filter = run_of(problem, record);
  EXPECT_EQ(filter.input.measured.values.array().isNaN().count(), 5);
  const auto result = run(filter);
  ASSERT_FALSE(result.failure);
  EXPECT_EQ(result.measured[29], 4);
  EXPECT_EQ(result.measured[30], 3);
  EXPECT_EQ(result.measured[40], 0);
  EXPECT_TRUE(std::isnan(result.innovation(1, 30)));
}

/// Nothing that the run holds ends with the problem.
TEST(FilterRun, FindsTheSuspensionAfterTheProblemIsGone) {
  auto problem = shared(chain_problem());
  const Record record = chain_record(*problem, 4.0);
  const auto filter = run_of(problem, record);
  problem.reset();
  EXPECT_EQ(filter.choice.filter, FilterKind::partially_linear);
  const auto result = run(filter);
  ASSERT_FALSE(result.failure) << result.failure->reason;
  const VectorXd mean = result.unknowns.mean.rightCols(1), deviation = result.unknowns.deviation.rightCols(1);
  EXPECT_LT(std::abs(mean[0] - true_mu_k1), 3.0 * deviation[0]);
  EXPECT_LT(std::abs(mean[1] - true_mu_c1), 3.0 * deviation[1]);
  EXPECT_LT(deviation[0], 0.02 * true_mu_k1);
  EXPECT_LT(deviation[1], 0.02 * true_mu_c1);
  const auto consistency =
      summarise_consistency(result.nis, result.measured, result.innovation, filter.input.measured.noise(), 500);
  EXPECT_NEAR(consistency.mean_nis, 4.0, 0.15);  // 14,000 squares: 1.2 % is one deviation
}

TEST(FilterRun, FindsALinearUnknownAfterTheProblemIsGone) {
  EstimationProblem given = chain_problem();
  given.settings.unknowns = {unknown(*given.structure, "body.4-5.stiffness", 0.9 * body_stiffness, 4e3)};
  auto problem = shared(given);
  const Record record = chain_record(*problem, 2.0);
  const auto filter = run_of(problem, record);
  given = {};
  problem.reset();
  const auto result = run(filter);
  ASSERT_FALSE(result.failure) << result.failure->reason;
  EXPECT_NEAR(result.unknowns.mean(0, 2000), body_stiffness, 0.02 * body_stiffness);
}

TEST(FilterRun, StartsWhereTheDisplacementSensorsAre) {
  auto given = chain_problem();
  given.settings.initial_state_from_record = true;
  given.sensors.push_back({.name = "d3", .output = {"d3", ObservedQuantity::displacement, {{"body.3", 1.0}}}});
  const auto problem = shared(given);
  Record record = chain_record(*problem, 0.1, false);
  record.channels.back().noise = 1e-6;
  const double velocity = 0.2;
  for (Index k = 0; k < record.samples(); ++k)
    record.values(4, k) = 0.003 + velocity * static_cast<double>(k) / chain_rate;
  const auto run = run_of(problem, record);
  const auto& prior = run.choice.augmented_model->options().prior.mean;
  EXPECT_NEAR(prior.displacement[3], 0.003, 1e-12);
  EXPECT_NEAR(prior.velocity[3], velocity, 1e-9);
  EXPECT_NEAR(prior.displacement.norm(), 0.003, 1e-12);
}

TEST(FilterRun, UsesAsManyThreadsAsItIsAskedTo) {
  EXPECT_EQ(filter_threads({.threads = 3}), 3);
  EXPECT_EQ(filter_threads({}), processors());
  EXPECT_GE(processors(), 1);
}

}  // namespace
}  // namespace kalfem::test
