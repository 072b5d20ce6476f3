// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/unknown_information.hpp"

#include <gtest/gtest.h>

#include "chain_structure.hpp"
#include "kalfem/identification/filter_likelihood.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Estimated {
  EstimationProblemPtr problem;
  Record record;
  RecordEstimate estimate;
};

Estimated estimated(EstimationProblem problem, double duration) {
  problem.settings.substeps = 4;
  const Record record = chain_record(problem, duration);
  const auto given = shared(std::move(problem));
  IssueList issues;
  const auto setup = make_augmented_model_setup(*given, given->structure->parts, {}, issues);
  issues.raise();
  return {given, record, estimate_record(given, setup, record)};
}

/// ln p(record, x) of the two unknowns by their logarithms, by a whole filter at each: no tangents, gains anew.
class LogPosterior {
public:
  explicit LogPosterior(const Estimated& of)
      : unknowns_(of.problem->settings.unknowns),
        likelihood_(of.problem, of.record, {unknowns_[0].name, unknowns_[1].name},
                    {.first = of.estimate.result.unknowns.mean.rightCols(1)}) {}

  double operator()(const VectorXd& x) const {
    double sum = likelihood_.log_likelihood(x.array().exp());
    for (Index i = 0; i < 2; ++i) {
      const auto& unknown = unknowns_[static_cast<std::size_t>(i)];
      const double away = (x[i] - std::log(unknown.initial)) * unknown.initial / unknown.deviation;
      sum -= 0.5 * away * away;
    }
    return sum;
  }

private:
  std::vector<Unknown> unknowns_;
  FilterLikelihood likelihood_;
};

/// Central differences of the logarithm of the posterior, each step a part of the deviation.
TEST(UnknownInformation, IsTheCurvatureOfThePosterior) {
  const Estimated chain = estimated(chain_problem(), 3.0);
  StepBudget unlimited;
  const auto found = information_at_estimates(chain.problem, chain.record, chain.estimate, unlimited);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->any_too_sure());
  const LogPosterior posterior(chain);
  const VectorXd x = chain.estimate.result.unknowns.mean.rightCols(1).array().log();
  const VectorXd h = 0.3 * found->covariance.diagonal().cwiseSqrt();
  const auto at = [&](double i, double j) { return posterior(x + VectorXd{{i * h[0], j * h[1]}}); };
  const double here = at(0, 0);
  MatrixXd curvature(2, 2);
  curvature << 2.0 * here - at(1, 0) - at(-1, 0), 0.0, 0.0, 2.0 * here - at(0, 1) - at(0, -1);
  curvature(0, 1) = curvature(1, 0) = -0.25 * (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1));
  curvature = h.cwiseInverse().asDiagonal() * curvature * h.cwiseInverse().asDiagonal();
  const VectorXd gradient = VectorXd{{at(1, 0) - at(-1, 0), at(0, 1) - at(0, -1)}}.cwiseQuotient(2.0 * h);
  const MatrixXd scale = found->covariance.diagonal().cwiseSqrt().cwiseInverse().asDiagonal();
  // the held gains, and what noise makes of second derivatives
  const MatrixXd expected = scale * curvature.inverse() * scale, have = scale * found->covariance * scale;
  EXPECT_LT((have - expected).norm(), 0.05) << have << "\n\n" << expected;
  EXPECT_LT((scale * (found->step - curvature.inverse() * gradient)).norm(), 0.05)
      << found->step.transpose() << ", " << (curvature.inverse() * gradient).transpose();
}

TEST(UnknownInformation, AgreesWithTheFilterOfARightModel) {
  auto problem = chain_problem();
  problem.settings.unknowns.push_back(unknown(*problem.structure, "body.3-4.stiffness", 2.8e4, 3e3));
  const Estimated chain = estimated(std::move(problem), 4.0);
  StepBudget unlimited;
  const auto found = information_at_estimates(chain.problem, chain.record, chain.estimate, unlimited);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->any_too_sure());
  const auto& model = *chain.estimate.augmented_model;
  for (Index i = 0; i < 3; ++i) {
    const double deviation = chain.estimate.result.state.deviation.rightCols(1)(model.layout().unknown() + i, 0);
    EXPECT_NEAR(std::sqrt(found->covariance(i, i)) / deviation, 1.0, 0.1) << i;
    EXPECT_LT(std::abs(found->step[i]), 0.3 * deviation) << i;
  }
}

TEST(UnknownInformation, IsNoneWithoutConstantUnknownsOrBudget) {
  auto walking = chain_problem();
  for (auto& unknown : walking.settings.unknowns) unknown.random_walk = 0.1;
  const Estimated chain = estimated(std::move(walking), 1.0);
  StepBudget unlimited, none(0.0);
  EXPECT_FALSE(information_at_estimates(chain.problem, chain.record, chain.estimate, unlimited));
  const Estimated constant = estimated(chain_problem(), 1.0);
  EXPECT_FALSE(information_at_estimates(constant.problem, constant.record, constant.estimate, none));
  EXPECT_TRUE(none.refused());
}

}  // namespace
}  // namespace kalfem::test
