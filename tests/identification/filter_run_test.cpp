#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identification/chain_structure.hpp"
#include "kalfem/estimation/consistency.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

FilterRun run_of(const EstimationProblemPtr& problem, const FullRecord& record) {
  IssueList issues;
  const auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  issues.raise();
  return make_filter_run(problem, setup, record);
}

TEST(FilterRun, HandsTheSensorsChannelsAndTheRoadToTheFilter) {
  const auto problem = shared(chain_problem());
  FullRecord record = chain_record(*problem, 0.1);
  // in another order, with a channel that no sensor has
  record.series.channels = {{"a10", ""}, {"extra", ""}, {"a4", ""}, {"a2", ""}, {"a6", ""}};
  record.series.values = Eigen::MatrixXd::Random(101, 5);
  record.noise = {10.0, 0.0, 4.0, 2.0, 6.0};
  const auto run = run_of(problem, record);
  EXPECT_EQ(run.noise, VectorXd(Eigen::Vector4d(2.0, 4.0, 6.0, 10.0)));
  ASSERT_EQ(run.record.measurements.cols(), 101);
  EXPECT_TRUE(run.record.measurements.row(0).transpose() == record.series.values.col(3));
  EXPECT_TRUE(run.record.measurements.row(3).transpose() == record.series.values.col(0));
  EXPECT_EQ(run.record.noise(2, 2), 36.0);
  // [r; r'; r''] at every substep
  const auto road = problem->structure->signals[0]->sample(0.0, 0.25 / chain_rate, 401);
  EXPECT_TRUE(run.record.inputs.transpose() == road.matrix());
}

TEST(FilterRun, HidesTheSamplesThatTheFilterMustNotLearnFrom) {
  const auto problem = shared(chain_problem());
  FullRecord record = chain_record(*problem, 0.1);
  record.used = 60;
  const auto run = run_of(problem, record);
  EXPECT_TRUE(run.record.measurements.leftCols(60).allFinite());
  EXPECT_TRUE(run.record.measurements.rightCols(41).array().isNaN().all());
  EXPECT_TRUE(run.measurements.values.allFinite());  // for comparison
}

/// Nothing that the run holds ends with the problem.
TEST(FilterRun, FindsTheSuspensionAfterTheProblemIsGone) {
  auto problem = shared(chain_problem());
  const FullRecord record = chain_record(*problem, 4.0);
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
  const auto consistency = summarise_consistency(result.nis, result.measured, result.innovation, filter.noise, 500);
  EXPECT_NEAR(consistency.mean_nis, 4.0, 0.15);  // 14,000 squares: 1.2 % is one deviation
}

TEST(FilterRun, FindsALinearUnknownAfterTheProblemIsGone) {
  EstimationProblem given = chain_problem();
  given.settings.unknowns = {unknown(*given.structure, "body.4-5.stiffness", 0.9 * body_stiffness, 4e3)};
  auto problem = shared(given);
  const FullRecord record = chain_record(*problem, 2.0);
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
  FullRecord record = chain_record(*problem, 0.1, false);
  record.noise.back() = 1e-6;
  const double velocity = 0.2;
  for (Index k = 0; k < record.series.samples(); ++k)
    record.series.values(k, 4) = 0.003 + velocity * static_cast<double>(k) / chain_rate;
  const auto run = run_of(problem, record);
  const auto& prior = run.choice.augmented_model->options().prior.mean;
  EXPECT_NEAR(prior.displacement[3], 0.003, 1e-12);
  EXPECT_NEAR(prior.velocity[3], velocity, 1e-9);
  EXPECT_NEAR(prior.displacement.norm(), 0.003, 1e-12);
}

TEST(FilterRun, ConstantsOfSensorsAndThreadsAreAsTheyAreAskedFor) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_DOUBLE_EQ(rms_of_present(Eigen::Vector4d(3.0, none, -4.0, none)), std::sqrt(12.5));
  EXPECT_EQ(rms_of_present(Eigen::Vector2d(none, none)), 0.0);
  EXPECT_EQ(filter_threads({.threads = 3}), 3);
  EXPECT_EQ(filter_threads({}), processors());
  EXPECT_GE(processors(), 1);
}

}  // namespace
}  // namespace kalfem::test
