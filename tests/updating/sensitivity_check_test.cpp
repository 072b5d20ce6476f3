// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/sensitivity_check.hpp"

#include <gtest/gtest.h>
#include <cmath>

#include "updating/nist_problems.hpp"

namespace kalfem {
namespace {

using Eigen::VectorXd;
using nist::vector;
using Verdict = SensitivityComparison::Verdict;

TEST(SensitivityCheck, RightDerivativesAgreeToElevenDigits) {
  for (const auto& problem : nist_problems())
    for (const auto& comparison :
         check_sensitivities(problem.residual, free_parameters(problem.starts[1]), problem.certified)) {
      EXPECT_EQ(comparison.verdict, Verdict::agrees) << problem.name << " " << comparison.parameter;
      EXPECT_LT(comparison.deviation, 1e-11) << problem.name << " " << comparison.parameter;
    }
}

/// Rosenbrock's residual with one entry of its Jacobian off by a part.
FunctionResidual with_fault(double part) {
  return {2, [=](const VectorXd& theta) {
            auto value = *rosenbrock().evaluate(theta, true);
            value.jacobian(1, 0) *= 1.0 + part;
            return value;
          }};
}

TEST(SensitivityCheck, FindsAWrongEntry) {
  const auto parameters = free_parameters(vector({0.04, 1.0}));
  const auto comparisons = check_sensitivities(with_fault(2e-3), parameters, vector({0.04, 1.0}));
  ASSERT_EQ(comparisons.size(), 2U);
  EXPECT_EQ(comparisons[0].verdict, Verdict::deviates);
  EXPECT_EQ(comparisons[0].row, 1);
  EXPECT_NEAR(comparisons[0].deviation, 2e-3, 1e-12);  // as above
  EXPECT_EQ(comparisons[1].verdict, Verdict::agrees);
  EXPECT_EQ(check_sensitivities(with_fault(2e-5), parameters, vector({0.04, 1.0}))[0].verdict, Verdict::agrees)
      << "below the tolerance";
}

TEST(SensitivityCheck, FindsADependenceThatIsMissingOrMadeUp) {
  const FunctionResidual residual(1, [](const VectorXd& theta) {
    return ResidualValue{vector({theta[0]}), vector({0.0, 0.5}).transpose()};
  });
  const auto comparisons = check_sensitivities(residual, free_parameters(vector({1.0, 1.0})), vector({1.0, 1.0}));
  EXPECT_EQ(comparisons[0].verdict, Verdict::deviates);
  EXPECT_EQ(comparisons[1].verdict, Verdict::deviates);
  EXPECT_NEAR(comparisons[1].deviation, 0.5, 1e-12);  // linear: rounding over the step
}

TEST(SensitivityCheck, KeepsWithinTheBounds) {
  auto parameters = free_parameters(vector({1.0, 1.0, 1.0, 1.0}));
  parameters[0].lower = 1.0;  // one side only
  parameters[1].lower = 1.0 - 1e-4, parameters[1].upper = 1.0 + 1e-3;
  parameters[2].upper = 1.0, parameters[2].lower = 1.0 - 1e-3;
  parameters[3].lower = parameters[3].upper = 1.0;  // held: not compared
  bool outside = false;
  const FunctionResidual residual(4, [&](const VectorXd& theta) {
    for (Eigen::Index i = 0; i < 4; ++i) {
      const auto& p = parameters[static_cast<std::size_t>(i)];
      outside = outside || theta[i] < p.lower || theta[i] > p.upper;
    }
    return ResidualValue{theta.array().exp().matrix(), theta.array().exp().matrix().asDiagonal()};
  });
  const auto comparisons = check_sensitivities(residual, parameters, vector({1.0, 1.0, 1.0, 1.0}));
  EXPECT_FALSE(outside);
  ASSERT_EQ(comparisons.size(), 3U);
  for (const auto& comparison : comparisons) {
    EXPECT_EQ(comparison.verdict, Verdict::agrees);
    EXPECT_LT(comparison.deviation, 2e-11);  // differences to one side lose a digit: found 4e-12
  }
}

TEST(SensitivityCheck, SaysWhenDifferencesScatterOrAreMissing) {
  int count = 0;
  const FunctionResidual rough(1, [&](const VectorXd& theta) {
    return ResidualValue{vector({theta[0] + (++count % 3 == 0 ? 1e-3 : 0.0)}), vector({1.0})};
  });
  EXPECT_EQ(check_sensitivities(rough, free_parameters(vector({1.0})), vector({1.0}))[0].verdict, Verdict::undecided);
  const FunctionResidual island(1, [](const VectorXd& theta) -> std::optional<ResidualValue> {
    if (theta[0] != 1.0) return std::nullopt;
    return ResidualValue{vector({1.0}), vector({1.0})};
  });
  EXPECT_EQ(check_sensitivities(island, free_parameters(vector({1.0})), vector({1.0}))[0].verdict,
            Verdict::no_response);
  const FunctionResidual narrow(1, [](const VectorXd& theta) -> std::optional<ResidualValue> {
    if (std::abs(theta[0] - 1.0) > 3e-3) return std::nullopt;
    return ResidualValue{vector({std::exp(theta[0])}), vector({std::exp(theta[0])})};
  });
  EXPECT_EQ(check_sensitivities(narrow, free_parameters(vector({1.0})), vector({1.0}))[0].verdict, Verdict::agrees);
}

TEST(SensitivityCheck, TellsWhyASearchStalled) {
  using Comparisons = std::vector<SensitivityComparison>;
  const SensitivityComparison right{.parameter = "k"},
      wrong{.parameter = "m", .deviation = 0.12, .verdict = Verdict::deviates},
      rough{.parameter = "c", .verdict = Verdict::undecided};
  EXPECT_NE(explain_stall(Comparisons{right, wrong, rough}).find("by 'm' differ from finite differences by up to 12 %"),
            std::string::npos);
  EXPECT_NE(explain_stall(Comparisons{right, rough}).find("by 'c' scatter: the residual is not smooth"),
            std::string::npos);
  EXPECT_NE(explain_stall(Comparisons{right}).find("agree with finite differences"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
