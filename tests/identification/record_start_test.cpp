// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "identification/chain_structure.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/identification/refined_filter.hpp"

// What a filter assumes of the motion at a record's first sample.

namespace kalfem::test {
namespace {

using Eigen::VectorXd;

/// The chain without a word about its start, 15 % noise.
EstimationProblem silent_problem() {
  EstimationProblem problem = chain_problem();
  for (auto& sensor : problem.sensors) sensor.noise = 0.15;
  problem.settings.initial_state = {};
  problem.settings.substeps = 4;
  return problem;
}

/// Certain rest, said by the case.
EstimationProblem at_rest_problem() {
  EstimationProblem problem = silent_problem();
  problem.settings.initial_state = {{"all", {{0.0, 0.0, 0.0, 0.0}}}};
  return problem;
}

FilteredRecord filtered(const EstimationProblem& given, const Record& record) {
  const auto problem = shared(given);
  IssueList issues;
  const auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  issues.raise();
  return run_refined_filter(problem, setup, record, {}).filtered;
}

const Record& whole_record() {
  static const Record record = chain_record(silent_problem(), 6.0);
  return record;
}

/// Errors of mu_k1 and mu_c1 in standard deviations.
Eigen::Array2d errors_of(const EstimationResult& result) {
  const Eigen::Array2d mean = result.unknowns.mean.rightCols(1).array(),
                       deviation = result.unknowns.deviation.rightCols(1).array();
  return (mean - Eigen::Array2d(true_mu_k1, true_mu_c1)).abs() / deviation;
}

double mean_nis(const EstimationResult& result) { return result.nis.mean(); }

TEST(RecordStart, AStructureThatMovesWhenTheRecordIsCutHasAnUnknownInitialState) {
  const Record part = cut(whole_record(), 2.0, 6.0);
  const auto free = filtered(silent_problem(), part);
  ASSERT_FALSE(free.result.failure);
  EXPECT_TRUE(free.run.start.moving);
  EXPECT_NE(explain(free.run.start).find("the record starts at 2 s"), std::string::npos) << explain(free.run.start);
  EXPECT_LT(errors_of(free.result).maxCoeff(), 3.0) << errors_of(free.result).transpose();
  EXPECT_NEAR(mean_nis(free.result), 4.0, 0.2);

  const auto held = filtered(at_rest_problem(), part);
  EXPECT_FALSE(held.run.start.moving);
  EXPECT_TRUE(held.result.failure || mean_nis(held.result) > 8.0 || errors_of(held.result).maxCoeff() > 5.0)
      << mean_nis(held.result) << ", " << errors_of(held.result).transpose();
}

/// The same part with its clock set to zero: the samples alone show the motion.
TEST(RecordStart, TheFirstSamplesShowAMotionThatTheClockDoesNot) {
  Record part = cut(whole_record(), 2.0, 6.0);
  auto problem = silent_problem();
  auto structure = std::make_shared<StructureData>(*problem.structure);
  structure->signals = {delayed(problem.structure->signals[0], -2.0)};
  problem.structure = structure;
  part.start = 0.0;
  const auto free = filtered(problem, part);
  ASSERT_FALSE(free.result.failure);
  EXPECT_TRUE(free.run.start.moving);
  EXPECT_NE(explain(free.run.start).find("first samples"), std::string::npos) << explain(free.run.start);
  EXPECT_LT(errors_of(free.result).maxCoeff(), 3.0) << errors_of(free.result).transpose();
  EXPECT_NEAR(mean_nis(free.result), 4.0, 0.2);
}

TEST(RecordStart, AStructureAtRestIsCertainlyAtRest) {
  const auto silent = filtered(silent_problem(), whole_record());
  const auto said = filtered(at_rest_problem(), whole_record());
  EXPECT_FALSE(silent.run.start.moving);
  EXPECT_EQ(silent.run.choice.augmented_model->options().prior.motion_covariance.size(), 0);
  EXPECT_EQ(silent.result.unknowns.mean, said.result.unknowns.mean);
}

/// The record with one value of the first samples wrong by so many times the noise.
Record with_spike(Eigen::Index channel, Eigen::Index sample, double deviations) {
  Record record = whole_record();
  record.values(channel, sample) += deviations * record.channels[static_cast<std::size_t>(channel)].noise;
  return record;
}

TEST(RecordStart, OneSpikeAmongTheFirstSamplesIsNoMotion) {
  for (const Eigen::Index channel : {0, 2})
    for (const Eigen::Index sample : {0, 3, 9})
      for (const double size : {-8.0, 20.0, 1e4}) {
        const auto problem = shared(silent_problem());
        IssueList issues;
        const auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
        issues.raise();
        const auto run = make_filter_run(problem, setup, with_spike(channel, sample, size));
        EXPECT_FALSE(run.start.moving) << channel << ", " << sample << ", " << size;
      }
}

/// Two spikes in a row in each channel look like a motion: then the run from rest, which the record fits, is kept.
TEST(RecordStart, RestIsTriedWhereAMovingStartContradictsItself) {
  Record record = whole_record();
  for (Eigen::Index channel = 0; channel < record.values.rows(); ++channel)
    for (const Eigen::Index sample : {2, 3, 4, 5}) {
      const double noise = record.channels[static_cast<std::size_t>(channel)].noise;
      record.values(channel, sample) += (channel % 2 == 0 ? 25.0 : -25.0) * noise;
    }
  const auto problem = shared(silent_problem());
  IssueList issues;
  const auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  issues.raise();
  const RecordEstimate estimate = estimate_record(problem, setup, record, {});
  ASSERT_FALSE(estimate.result.failure);
  EXPECT_LT(errors_of(estimate.result).maxCoeff(), 3.5) << errors_of(estimate.result).transpose();
}

/// The deviations are of the motion's own size: not less than what is there, nor a hundred times more.
TEST(RecordStart, DeviationsHaveTheSizeOfTheMotion) {
  const Record part = cut(whole_record(), 2.0, 6.0);
  const auto free = filtered(silent_problem(), part);
  const auto& covariance = free.run.choice.augmented_model->options().prior.motion_covariance;
  const Eigen::Index n = covariance.rows() / 2;
  std::vector<OutputDescription> motions;
  for (const auto quantity : {ObservedQuantity::displacement, ObservedQuantity::velocity})
    for (const std::string point : {"wheel.w", "body.1", "body.5", "body.10"})
      motions.push_back({point, quantity, {{point, 1.0}}});
  const auto truth = simulate_chain(*silent_problem().structure, motions, 6.0).every_sample;
  const std::vector<Eigen::Index> dofs = {0, 1, 5, 10};
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Eigen::Index state = dofs[i % 4] + (i < 4 ? 0 : n);
    const double deviation = std::sqrt(covariance(state, state));
    const double size = rms(truth.row(static_cast<Eigen::Index>(i)).transpose());
    EXPECT_GT(deviation, 0.5 * size) << motions[i].name;
    EXPECT_LT(deviation, 20.0 * size) << motions[i].name;
  }
}

}  // namespace
}  // namespace kalfem::test
