// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "estimation/brute_force.hpp"
#include "kalfem/estimation/filter.hpp"

// A filter works on the maps, Q and R that it was made with: nothing that its owner does to its own copies afterwards
// is half seen.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr FilterKind kinds[] = {FilterKind::unscented, FilterKind::unscented_square_root, FilterKind::partially_linear,
                                FilterKind::partially_linear_square_root, FilterKind::extended};

/// Twelve states in pairs, three sensors, all matrices of the filter's model drawn at random.
struct SmallProblem {
  RandomStream random{31, "filter model"};
  FunctionMap process = random_map(random, 12, 12, 3, 2, bent), measurement = random_map(random, 3, 12, 3, 2, bent);
  MatrixXd Q, R;
  Gaussian prior;

  SmallProblem() {
    MatrixXd pairs = MatrixXd::Zero(12, 12);
    for (Index i = 0; i < 12; i += 2) pairs.block<2, 2>(i, i) = 0.4 * random_matrix(random, 2, 2);
    process.linear = pairs;
    for (auto* map : {&process, &measurement}) map->gain *= 0.1, map->selection *= 0.2;
    const MatrixXd q = 0.1 * random_matrix(random, 12, 12), r = random_matrix(random, 3, 3),
                   p = random_matrix(random, 12, 12);
    Q = q * q.transpose();
    R = r * r.transpose() + MatrixXd::Identity(3, 3);
    prior = {random_matrix(random, 12, 1), p * p.transpose()};
  }

  FilterModel model() { return {process, Q, measurement, R}; }
};

/// Mean and covariance after the same five measurements, gaps among them.
Gaussian after_a_run(Filter& filter, const Gaussian& prior, bool with_gaps) {
  RandomStream random(32, "measurements");
  filter.reset(prior);
  Innovation innovation;
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(filter.predict(), FilterOutcome::usable);
    VectorXd y = random_matrix(random, 3, 1);
    if (with_gaps && k % 2) y[1] = NAN;
    EXPECT_EQ(filter.update(y, innovation), FilterOutcome::usable);
  }
  return {filter.mean(), filter.covariance()};
}

void expect_same(const Gaussian& found, const Gaussian& expected, double tolerance, FilterKind kind) {
  EXPECT_LE((found.mean - expected.mean).norm(), tolerance * expected.mean.norm()) << to_string(kind);
  EXPECT_LE((found.covariance - expected.covariance).norm(), tolerance * expected.covariance.norm()) << to_string(kind);
}

TEST(FilterModel, NoiseChangedInPlaceAfterwardsIsNotSeenAtAll) {
  for (const auto kind : kinds) {
    SmallProblem problem;
    const auto filter = make_filter(kind, problem.model());
    const auto expected = after_a_run(*filter, problem.prior, false);
    problem.Q(0, 1) = problem.Q(1, 0) *= 0.5;  // off the diagonal only
    problem.Q(4, 4) *= 3.0;
    problem.R(0, 2) = problem.R(2, 0) *= 0.5;
    expect_same(after_a_run(*filter, problem.prior, false), expected, 0.0, kind);
  }
}

TEST(FilterModel, NoiseOffTheDiagonalCountsInAnewFilter) {
  // Two filters with noise that differs off its diagonal alone, in one place in memory: every kind sees the second one.
  for (const auto kind : kinds) {
    SmallProblem problem;
    const auto first = after_a_run(*make_filter(kind, problem.model()), problem.prior, false);
    problem.Q(0, 1) = problem.Q(1, 0) = 0.9 * std::sqrt(problem.Q(0, 0) * problem.Q(1, 1));
    problem.Q.row(0).tail(10).setZero(), problem.Q.row(1).tail(10).setZero();
    problem.Q.col(0).tail(10).setZero(), problem.Q.col(1).tail(10).setZero();
    const auto second = after_a_run(*make_filter(kind, problem.model()), problem.prior, false);
    EXPECT_GT((second.covariance - first.covariance).norm(), 1e-4 * first.covariance.norm()) << to_string(kind);
    // The same moments as the filter that keeps a dense covariance, where the sigma points are the same.
    if (kind == FilterKind::partially_linear) {
      const auto root =
          after_a_run(*make_filter(FilterKind::partially_linear_square_root, problem.model()), problem.prior, false);
      expect_same(second, root, 1e-10, kind);  // rounding of five steps
    }
  }
}

TEST(FilterModel, AMissingChannelIsASensorThatIsNotThere) {
  for (const auto kind : kinds) {
    SmallProblem problem;
    const auto found = after_a_run(*make_filter(kind, problem.model()), problem.prior, true);

    // The same by two filters that are changed for each other at every gap.
    const std::vector<Index> present{0, 2};
    FunctionMap fewer = problem.measurement;
    fewer.linear = MatrixXd(problem.measurement.linear(present, Eigen::all));
    fewer.gain = MatrixXd(problem.measurement.gain(present, Eigen::all));
    fewer.offset = VectorXd(problem.measurement.offset(present));
    const auto all = make_filter(kind, problem.model());
    const auto some = make_filter(kind, {problem.process, problem.Q, fewer, problem.R(present, present)});
    RandomStream random(32, "measurements");
    Innovation innovation;
    Gaussian estimate = problem.prior;
    for (int k = 0; k < 5; ++k) {
      auto& filter = k % 2 ? *some : *all;
      filter.reset(estimate);
      EXPECT_EQ(filter.predict(), FilterOutcome::usable);
      const VectorXd y = random_matrix(random, 3, 1);
      EXPECT_EQ(filter.update(k % 2 ? VectorXd(y(present)) : y, innovation), FilterOutcome::usable);
      estimate = {filter.mean(), filter.covariance()};
    }
    // rounding of five steps and of square roots that are formed anew
    expect_same(found, estimate, 1e-9, kind);
  }
}

TEST(FilterModel, WithoutAnyMeasurementTheEstimateStays) {
  for (const auto kind : kinds) {
    SmallProblem problem;
    const auto filter = make_filter(kind, problem.model());
    filter->reset(problem.prior);
    ASSERT_EQ(filter->predict(), FilterOutcome::usable);
    const VectorXd mean = filter->mean();
    const MatrixXd covariance = filter->covariance();
    Innovation innovation;
    EXPECT_EQ(filter->update(VectorXd::Constant(3, NAN), innovation), FilterOutcome::usable);
    EXPECT_TRUE(innovation.channels.empty());
    EXPECT_EQ(filter->mean(), mean) << to_string(kind);
    EXPECT_EQ(filter->covariance(), covariance) << to_string(kind);
  }
}

TEST(FilterModel, MovingColumnsOfTheGainAreReadAtEveryStep) {
  // The last column of G may change with every step; a filter made with the new one from the start agrees.
  for (const auto kind : kinds) {
    SmallProblem problem;
    problem.process.moving_gain = 1;
    const auto filter = make_filter(kind, problem.model());
    const auto before = after_a_run(*filter, problem.prior, false);
    problem.process.gain.col(1) *= 2.0;
    const auto moved = after_a_run(*filter, problem.prior, false);
    EXPECT_GT((moved.mean - before.mean).norm(), 1e-3 * before.mean.norm()) << to_string(kind);
    expect_same(moved, after_a_run(*make_filter(kind, problem.model()), problem.prior, false), 1e-12, kind);
  }
}

}  // namespace
}  // namespace kalfem
