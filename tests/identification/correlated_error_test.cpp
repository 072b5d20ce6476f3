// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/correlated_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "identification/chain_structure.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double interval = 2e-3;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// ln N(series; 0, C) with C_jk = s^2 exp(-|t_j - t_k| / tau) of the samples that are there.
double dense_log_density(const VectorXd& series, const CorrelatedError& error, double deviation) {
  std::vector<Index> there;
  for (Index k = 0; k < series.size(); ++k)
    if (!std::isnan(series[k])) there.push_back(k);
  const auto n = std::ssize(there);
  MatrixXd covariance(n, n);
  for (Index j = 0; j < n; ++j)
    for (Index k = 0; k < n; ++k) {
      const double lag = interval * std::abs(static_cast<double>(there[std::size_t(j)] - there[std::size_t(k)]));
      const double correlation =
          error.correlation_time > 0.0 ? std::exp(-lag / error.correlation_time) : double(j == k);
      covariance(j, k) = deviation * deviation * correlation;
    }
  const Eigen::LLT<MatrixXd> factor(covariance);
  const VectorXd values = series(there);
  return -0.5 * (values.dot(factor.solve(values)) + static_cast<double>(n) * std::log(2.0 * std::numbers::pi)) -
         factor.matrixLLT().diagonal().array().log().sum();
}

VectorXd noisy_series(bool with_gaps) {
  RandomStream random(5, "series");
  VectorXd series = VectorXd::NullaryExpr(60, [&] { return random.normal(); });
  if (with_gaps) series.head(2).setConstant(missing), series.segment(20, 5).setConstant(missing), series[40] = missing;
  return series;
}

// The condition of the dense matrix is some 1e4 at the longest correlation.
TEST(CorrelatedError, DensityOfASeriesIsTheMultivariateNormal) {
  for (const bool with_gaps : {false, true})
    for (const double time : {0.0, 1e-4, 4e-3, 0.1}) {
      const CorrelatedError error{.correlation_time = time, .deviation = 1.3};
      const VectorXd series = noisy_series(with_gaps);
      const double expected = dense_log_density(series, error, 1.3);
      EXPECT_NEAR(log_density_of_correlated_series(series, interval, error), expected, 1e-10 * std::abs(expected))
          << time;
    }
}

TEST(CorrelatedError, AProfiledDeviationIsTheMostLikelyOne) {
  const VectorXd series = noisy_series(true);
  const CorrelatedError profiled{.correlation_time = 4e-3};
  const double best = log_density_of_correlated_series(series, interval, profiled);
  const auto at = [&](double deviation) {
    return log_density_of_correlated_series(series, interval, {.correlation_time = 4e-3, .deviation = deviation});
  };
  double largest = -infinity;
  for (double deviation = 0.5; deviation < 5.0; deviation *= 1.0005) largest = std::max(largest, at(deviation));
  EXPECT_GE(best, largest);
  EXPECT_NEAR(best, largest, 1e-5);  // 52 samples times the square of half a step of the search
}

TEST(CorrelatedError, OfNothingIsNoneAndOfZerosIsInfinite) {
  EXPECT_EQ(log_density_of_correlated_series(VectorXd::Constant(9, missing), interval, {}), -infinity);
  EXPECT_EQ(log_density_of_correlated_series(VectorXd(), interval, {}), -infinity);
  EXPECT_EQ(log_density_of_correlated_series(VectorXd::Constant(9, infinity), interval, {}), -infinity);
  EXPECT_EQ(log_density_of_correlated_series(VectorXd::Zero(9), interval, {}), infinity);
}

TEST(CorrelatedError, SaysWhatIsWrong) {
  const auto said = [&](const CorrelatedError& error, double step) {
    return refusal([&] { (void)log_density_of_correlated_series(noisy_series(false), step, error); });
  };
  EXPECT_EQ(said({}, interval), "");
  EXPECT_NE(said({.correlation_time = -1.0}, interval).find("correlation time"), std::string::npos);
  EXPECT_NE(said({.deviation = 0.0}, interval).find("deviation"), std::string::npos);
  EXPECT_NE(said({}, 0.0).find("interval"), std::string::npos);
}

}  // namespace
}  // namespace kalfem::test
