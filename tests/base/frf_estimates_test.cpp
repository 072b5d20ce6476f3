// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/frf_estimates.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index samples = 60000;

VectorXd white(const std::string& name) {
  RandomStream stream(3, name);
  VectorXd values(samples);
  for (auto& value : values) value = stream.normal();
  return values;
}

/// x_k + 0.8 x_(k-1), whose response is 1 + 0.8 exp(-i 2 pi f / rate).
VectorXd filtered(const VectorXd& x) {
  VectorXd y = x;
  y.tail(samples - 1) += 0.8 * x.head(samples - 1);
  return y;
}

std::complex<double> response_at(double frequency) {
  return 1.0 + 0.8 * std::exp(std::complex<double>(0.0, -2.0 * M_PI * frequency / 100.0));
}

FrfMatrix frfs(const Record& record, const std::vector<std::string>& inputs, FrfEstimator estimator) {
  return estimate_frfs({&record, 1}, inputs, {"y"}, {{.segment = 200}, estimator});
}

double mean_error(const Eigen::VectorXcd& values, const VectorXd& lines, double factor) {
  double sum = 0.0;
  for (Index k = 0; k < lines.size(); ++k) sum += std::abs(values[k]) / std::abs(factor * response_at(lines[k])) - 1.0;
  return sum / static_cast<double>(lines.size());
}

TEST(FrfEstimates, SeveralForcesHaveTheirOwnResponses) {
  const VectorXd f = white("f"), g = 0.6 * f + white("g");  // correlated forces
  const Record record = make_record(100.0, {{"f", f}, {"g", g}, {"y", filtered(f) - 3.0 * g + 0.5 * white("noise")}});
  for (const FrfEstimator estimator : {FrfEstimator::h1, FrfEstimator::hv}) {
    const auto found = frfs(record, {"f", "g"}, estimator);
    ASSERT_EQ(found.values.size(), 2u);
    double inside = 0.0;
    for (Index k = 0; k < found.lines.size(); ++k) {
      const auto error = found.values[0](k, 0) - response_at(found.lines[k]);
      inside += (std::abs(error.real()) < 2.0 * found.deviations[0](k, 0)) +
                (std::abs(error.imag()) < 2.0 * found.deviations[0](k, 0));
      EXPECT_LT(std::abs(found.values[1](k, 0) + 3.0), 0.2) << found.lines[k];
    }
    // Hv shares the noise, which is the response's alone, between forces and response: it is biased here.
    EXPECT_GT(inside / static_cast<double>(2 * found.lines.size()), estimator == FrfEstimator::h1 ? 0.85 : 0.6);
  }
}

TEST(FrfEstimates, NoiseOnTheForceOrTheResponseAsksForItsEstimator) {
  const VectorXd f = white("f"), y = filtered(f);
  const Record on_force = make_record(100.0, {{"f", f + 0.5 * white("n")}, {"y", y}});
  const Record on_response = make_record(100.0, {{"f", f}, {"y", y + 0.5 * white("n")}});
  const auto error = [&](const Record& record, FrfEstimator estimator) {
    const auto found = frfs(record, {"f"}, estimator);
    return mean_error(found.values[0].col(0), found.lines, 1.0);
  };
  EXPECT_NEAR(error(on_force, FrfEstimator::h2), 0.0, 0.01);
  EXPECT_NEAR(error(on_force, FrfEstimator::h1), 1.0 / 1.25 - 1.0, 0.01);
  EXPECT_NEAR(error(on_response, FrfEstimator::h1), 0.0, 0.01);
  EXPECT_GT(error(on_response, FrfEstimator::h2), 0.1);
  EXPECT_NEAR(error(on_force, FrfEstimator::hv), 1.0 / std::sqrt(1.25) - 1.0, 0.01);  // between the two
}

TEST(FrfEstimates, MistakesAreNamed) {
  const VectorXd f = white("f");
  const Record record = make_record(100.0, {{"f", f}, {"g", 2.0 * f}, {"y", filtered(f)}});
  const auto refusal = [&](const std::vector<std::string>& inputs, FrfEstimator estimator) -> std::string {
    try {
      frfs(record, inputs, estimator);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refusal({"f", "g"}, FrfEstimator::h1).find("the inputs are the same, or 0"), std::string::npos);
  EXPECT_NE(refusal({"f", "g"}, FrfEstimator::h2).find("H2 of 2 inputs"), std::string::npos);
  EXPECT_NE(refusal({}, FrfEstimator::h1).find("no input is named"), std::string::npos);
  EXPECT_NE(refusal({"y"}, FrfEstimator::h1).find("is an input and an output"), std::string::npos);
  EXPECT_NE(refusal({"h"}, FrfEstimator::h1).find("'h'"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
