// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "chain_structure.hpp"

// A second pass over the record begins with a narrow prior about the estimates of the first, and the stated one is put
// back at the end.

namespace kalfem::test {
namespace {

/// The chain with a linear suspension, one sensor of which has an offset that is not known: it enters linearly.
EstimationProblem offset_problem() {
  StructureParts parts = chain_parts();
  parts.connectors[0].law = make_law("linear");
  parts.connectors[0].parameters = Eigen::Vector2d(8e3, 40.0);
  EstimationProblem problem = chain_problem();
  problem.structure = chain_structure(parts);
  problem.settings.unknowns.clear();
  problem.offsets = {{.name = "offset", .sensor = "a2", .deviation = 2.0}};
  return problem;
}

EstimationResult passes_over(const EstimationProblem& problem, const Record& record, int passes) {
  IssueList issues;
  const auto given = shared(problem);
  const auto setup = make_augmented_model_setup(*given, given->structure->parts, {}, issues);
  EXPECT_TRUE(issues.empty());
  const auto filter = make_filter_run(given, setup, record);
  return estimate(*filter.choice.augmented_model, filter.input,
                  {.filter = filter.choice.filter, .passes = passes, .keep_unknowns = true});
}

TEST(SecondPassOverRecord, IsTheFirstWhereTheConstantsEnterLinearly) {
  const EstimationProblem problem = offset_problem();
  Record record = chain_record(problem, 2.0);
  record.values.row(record.find("a2")).array() += 1.5;
  const auto once = passes_over(problem, record, 1), twice = passes_over(problem, record, 2);
  ASSERT_FALSE(twice.failure);
  const auto last = once.unknowns.mean.cols() - 1;
  const double deviation = once.unknowns.deviation(0, last);
  EXPECT_NEAR(once.unknowns.mean(0, last), 1.5, 4.0 * deviation);
  // rounding of covariances: the narrow prior is a thousandth of the stated one
  EXPECT_NEAR(twice.unknowns.deviation(0, last) / deviation, 1.0, 1e-6);
  EXPECT_NEAR(twice.unknowns.mean(0, last), once.unknowns.mean(0, last), 1e-6 * deviation);
  EXPECT_NEAR(twice.log_likelihood, once.log_likelihood, 1e-5);
  EXPECT_NEAR(twice.log_density.sum(), once.log_density.sum(), 1e-5);
  for (const Eigen::Index k : {Eigen::Index{20}, Eigen::Index{200}, last / 2}) {
    EXPECT_NEAR(twice.unknowns.deviation(0, k) / once.unknowns.deviation(0, k), 1.0, 1e-4) << k;
    EXPECT_NEAR(twice.unknowns.mean(0, k), once.unknowns.mean(0, k), 1e-3 * once.unknowns.deviation(0, k)) << k;
  }
  EXPECT_LT((twice.final_covariance - once.final_covariance).norm(), 1e-6 * once.final_covariance.norm());
  EXPECT_LT((twice.state.mean.col(last) - once.state.mean.col(last)).norm(), 1e-6 * once.state.mean.col(last).norm());
  EXPECT_EQ(twice.prior.covariance, once.prior.covariance);
  EXPECT_EQ(twice.prior.mean, once.prior.mean);
  const auto &one = once.unknowns_history, &other = twice.unknowns_history;
  EXPECT_NEAR(robust_covariance(other).covariance(0, 0) / robust_covariance(one).covariance(0, 0), 1.0, 1e-3);
  const auto innovations = sensitive_innovations(one, 0), again = sensitive_innovations(other, 0);
  EXPECT_LT((again.value - innovations.value).rightCols(1000).norm(), 1e-4 * innovations.value.rightCols(1000).norm());
}

}  // namespace
}  // namespace kalfem::test
