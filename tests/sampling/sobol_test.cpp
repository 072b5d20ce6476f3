// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/sobol.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "evidence_cases.hpp"

namespace kalfem {
namespace {

constexpr double pi = std::numbers::pi;

struct Exact {
  Eigen::VectorXd first, total;
};

/// Ishigami and Homma (1990) with a = 7, b = 0.1: S = .3139 .4424 0, T = .5576 .4424 .2437.
double ishigami(const Eigen::VectorXd& x) {
  return std::sin(x[0]) + 7.0 * std::pow(std::sin(x[1]), 2) + 0.1 * std::pow(x[2], 4) * std::sin(x[0]);
}

Exact ishigami_indices() {
  const double pi4 = std::pow(pi, 4), a = 7.0, b = 0.1;
  const double v1 = 0.5 * std::pow(1.0 + b * pi4 / 5.0, 2), v2 = a * a / 8.0, v13 = b * b * pi4 * pi4 * 8.0 / 225.0;
  const double v = v1 + v2 + v13;
  return {Eigen::Vector3d(v1, v2, 0.0) / v, Eigen::Vector3d(v1 + v13, v2, v13) / v};
}

const Eigen::VectorXd g_factors = (Eigen::VectorXd(5) << 0.0, 1.0, 4.5, 9.0, 99.0).finished();

/// Sobol's g-function, product of (|4 x_i - 2| + a_i) / (1 + a_i).
double g_function(const Eigen::VectorXd& x) {
  return ((4.0 * x.array() - 2.0).abs() + g_factors.array()).cwiseQuotient(1.0 + g_factors.array()).prod();
}

Exact g_indices() {
  const Eigen::ArrayXd v = (1.0 + g_factors.array()).square().inverse() / 3.0;
  const double all = (1.0 + v).prod();
  return {v / (all - 1.0), v * all / (1.0 + v) / (all - 1.0)};
}

void expect_indices(const SobolIndices& found, const Exact& exact, double tolerance) {
  double worst = 0.0;
  for (Eigen::Index i = 0; i < exact.first.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_NEAR(found.first[k].value, exact.first[i], tolerance) << i;
    EXPECT_NEAR(found.total[k].value, exact.total[i], tolerance) << i;
    EXPECT_LE(found.first[k].lower, found.first[k].upper);
    worst = std::max(
        {worst, std::abs(found.first[k].value - exact.first[i]), std::abs(found.total[k].value - exact.total[i])});
  }
  std::printf("largest error of an index %.4f\n", worst);
}

ModelOutputs single(double (*f)(const Eigen::VectorXd&)) {
  return [f](const Eigen::VectorXd& x) { return Eigen::VectorXd::Constant(1, f(x)); };
}

TEST(Sobol, IndicesOfIshigami) {
  const JointPrior prior = uniform_box(3, -pi, pi);
  for (const auto points : {SobolPoints::scrambled, SobolPoints::plain})
    expect_indices(sobol_indices(prior, single(ishigami), {.samples = 4096, .points = points, .bootstrap = 20})[0],
                   ishigami_indices(), 0.01);
  // random points: 1 / sqrt(N) of terms of order one
  expect_indices(
      sobol_indices(prior, single(ishigami), {.samples = 16384, .points = SobolPoints::random, .bootstrap = 20})[0],
      ishigami_indices(), 0.04);
}

TEST(Sobol, IndicesOfTheGFunction) {
  const auto found = sobol_indices(uniform_box(5, 0.0, 1.0), single(g_function), {.samples = 4096, .bootstrap = 20})[0];
  expect_indices(found, g_indices(), 0.01);
  EXPECT_NEAR(found.mean, 1.0, 0.005);
}

TEST(Sobol, BoundsHoldTheTruth) {
  // Random points, for which the bootstrap is made: 240 bounds of 95 %, less five deviations of a binomial.
  const Exact exact = ishigami_indices();
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto found =
        sobol_indices(uniform_box(3, -pi, pi), single(ishigami),
                      {.samples = 500, .points = SobolPoints::random, .bootstrap = 300, .seed = seed})[0];
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      inside += found.first[i].lower <= exact.first[k] && exact.first[k] <= found.first[i].upper ? 1 : 0;
      inside += found.total[i].lower <= exact.total[k] && exact.total[k] <= found.total[i].upper ? 1 : 0;
      all += 2;
    }
  }
  std::printf("95 %% bounds hold the exact index in %d of %d\n", inside, all);
  EXPECT_GE(inside, static_cast<int>(0.88 * all));
}

TEST(Sobol, NormalParametersOfALinearModelShareByVariance) {
  const JointPrior prior({{"a", NormalPrior{1.0, 3.0}}, {"b", NormalPrior{0.0, 1.0}}});
  const auto sum = [](const Eigen::VectorXd& x) { return Eigen::Vector2d(x[0] + x[1], 5.0); };
  const auto found = sobol_indices(prior, sum, {.samples = 4096, .bootstrap = 20});
  expect_indices(found[0], {Eigen::Vector2d(0.9, 0.1), Eigen::Vector2d(0.9, 0.1)}, 0.01);
  EXPECT_EQ(found[1].total[0].value, 0.0);  // it does not vary
}

TEST(Sobol, DoesNotDependOnThreads) {
  const JointPrior prior = uniform_box(3, -pi, pi);
  const auto one = sobol_indices(prior, single(ishigami), {.samples = 256})[0];
  const auto three = sobol_indices(prior, single(ishigami), {.samples = 256, .threads = 3})[0];
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(one.first[i].value, three.first[i].value);
    EXPECT_EQ(one.total[i].lower, three.total[i].lower);
  }
}

TEST(Sobol, LeavesOutUnknownOutputsAndRefusesCorrelation) {
  const auto gappy = [](const Eigen::VectorXd& x) {
    return Eigen::VectorXd::Constant(1, x[0] > 0.99 ? NAN : x[0] + x[1]);
  };
  EXPECT_GT(sobol_indices(uniform_box(2, 0.0, 1.0), gappy)[0].left_out, 0);
  const auto nothing = [](const Eigen::VectorXd&) { return Eigen::VectorXd::Constant(1, NAN); };
  EXPECT_THROW(sobol_indices(uniform_box(2, 0.0, 1.0), nothing), InvalidInput);
  Eigen::Matrix2d r;
  r << 1.0, 0.5, 0.5, 1.0;
  EXPECT_THROW(sobol_indices(JointPrior({{"a", NormalPrior{}}, {"b", NormalPrior{}}}, r), gappy), InvalidInput);
  EXPECT_THROW(sobol_indices(uniform_box(2, 0.0, 1.0), gappy, {.samples = 0}), InvalidInput);
}

}  // namespace
}  // namespace kalfem
