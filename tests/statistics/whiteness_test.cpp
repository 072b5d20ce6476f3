// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/whiteness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

TEST(Whiteness, OfIndependentSamplesLiesInItsBandNineteenTimesOfTwenty) {
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    RandomStream random(seed, "white");
    const VectorXd white = VectorXd::NullaryExpr(2000, [&](Index) { return random.normal(); });
    const auto found = autocorrelation(white);
    EXPECT_NEAR(found.band, 1.96 / std::sqrt(1999.0), 1e-12);
    inside += std::abs(found.value) <= found.band ? 1 : 0;
  }
  EXPECT_GE(inside, 367);  // binomial with 0.95 of 400: 380 +- 3 deviations of 4.4
  EXPECT_LE(inside, 393);
}

TEST(Whiteness, TellsHowMuchWiderTheDeviationIs) {
  RandomStream random(3, "correlated");
  VectorXd series(200000);
  double last = 0.0;
  for (Index k = 0; k < series.size(); ++k) series[k] = last = 0.96 * last + random.normal();
  const auto found = autocorrelation(series);
  EXPECT_NEAR(found.value, 0.96, 0.002);    // deviation sqrt(1 - 0.96^2) / sqrt(N) = 0.0006
  EXPECT_NEAR(found.widening(), 7.0, 0.2);  // sqrt(1.96 / 0.04)
  EXPECT_EQ(autocorrelation(-VectorXd::LinSpaced(10, 1.0, 1.0)).value, 1.0);
}

TEST(Whiteness, LeavesMissingSamplesOut) {
  RandomStream random(4, "gaps");
  VectorXd series(30000);
  double last = 0.0;
  for (Index k = 0; k < series.size(); ++k) series[k] = last = 0.7 * last + random.normal();
  for (Index k = 0; k < series.size(); k += 3) series[k] = missing;
  const auto found = autocorrelation(series);
  EXPECT_EQ(found.pairs, 10000);
  EXPECT_NEAR(found.value, 0.7, 0.02);
  EXPECT_EQ(autocorrelation(VectorXd::Constant(100, missing)).value, 0.0);
  EXPECT_TRUE(std::isinf(autocorrelation(VectorXd(0)).band));
}

}  // namespace
}  // namespace kalfem
