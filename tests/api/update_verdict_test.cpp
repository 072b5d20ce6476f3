// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>

#include <fmt/format.h>

#include "casefile/case_run.hpp"
#include "chain.hpp"

#include "kalfem/steps/study_results.hpp"
#include "kalfem/steps/updating/outcome.hpp"

// Whether the numbers of an updating can be trusted: the library says the same as the command does of the same
// frequencies.

namespace kalfem::test {
namespace {

constexpr double relative_deviation = 0.002;

/// Three masses on three springs.
Structure tower() {
  Structure s;
  s.add(lumped("tower")
            .mass("a", 2.0)
            .mass("b", 3.0)
            .mass("c", 1.0)
            .spring("k", "ground", "a", 8e3)
            .spring("l", "a", "b", 7e3)
            .spring("m", "b", "c", 9e3));
  return s;
}

/// Natural frequencies with k = 10 kN/m [Hz], each off by so many of its deviations.
std::vector<double> frequencies(const Eigen::Vector3d& errors) {
  Eigen::Matrix3d stiffness;
  stiffness << 17e3, -7e3, 0.0, -7e3, 16e3, -9e3, 0.0, -9e3, 9e3;
  const Eigen::Matrix3d mass = Eigen::Vector3d(2.0, 3.0, 1.0).asDiagonal();
  const Eigen::Vector3d squares =
      Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d>(stiffness, mass).eigenvalues();
  const Eigen::Array3d exact = squares.array().sqrt() / (2.0 * EIGEN_PI);
  const Eigen::Array3d measured = exact * (1.0 + relative_deviation * errors.array());
  return {measured.begin(), measured.end()};
}

UpdateResult updated(const std::vector<double>& measured) {
  UpdateOptions options{.substructure = "tower", .parameters = {{"tower.k.stiffness"}}};
  for (const double f : measured) options.frequencies.push_back({f, relative_deviation * f});
  return update(tower(), options);
}

StudyResults updated_by_command(const std::vector<double>& measured) {
  return results_of(fmt::format(R"(kalfem: 1
substructures:
  tower:
    masses: {{a: 2, b: 3, c: 1}}
    springs:
      - {{name: k, from: ground, to: a, stiffness: 8e3}}
      - {{name: l, from: a, to: b, stiffness: 7e3}}
      - {{name: m, from: b, to: c, stiffness: 9e3}}
update:
  parameters: {{tower.k.stiffness: {{}}}}
  compare: {{frequencies: {{modes: tower, frequencies: [{}], deviation: 0.2 %}}}}
)",
                                fmt::join(measured, ", ")),
                    "update");
}

void expect_same(const UpdateResult& found, const StudyResults& expected) {
  const auto reasons = found.verdict.reasons(), of_command = expected.verdict.reasons();
  ASSERT_EQ(reasons.size(), of_command.size());
  for (std::size_t i = 0; i < reasons.size(); ++i) {
    EXPECT_EQ(reasons[i].code, of_command[i].code);
    EXPECT_EQ(reasons[i].subject, of_command[i].subject);
    EXPECT_EQ(reasons[i].text, of_command[i].text);
  }
  const auto& outcome = expected.get<UpdatingOutcome>();
  EXPECT_NEAR(found.parameters[0].value, outcome.values[0], 1e-3 * found.parameters[0].std);
  EXPECT_NEAR(found.parameters[0].std, outcome.statistics.deviations[0], 1e-3 * found.parameters[0].std);
  EXPECT_NEAR(found.parameters[0].std_robust, outcome.robust.deviations[0], 1e-3 * found.parameters[0].std);
  EXPECT_LE(found.parameters[0].interval_95.lower, found.parameters[0].value - 1.95 * found.parameters[0].std);
  EXPECT_GE(found.parameters[0].interval_95.upper, found.parameters[0].value + 1.95 * found.parameters[0].std_robust);
}

TEST(UpdateVerdict, IsConsistentWhereFrequenciesScatterAsStated) {
  const auto measured = frequencies({0.9, -0.8, 0.7});
  const auto result = updated(measured);
  EXPECT_EQ(result.verdict.state(), VerdictState::consistent);
  EXPECT_TRUE(result.usable());
  EXPECT_NEAR(result.parameters[0].value, 1e4, 3.0 * result.parameters[0].std);
  EXPECT_GT(result.parameters[0].std_robust, 0.0);
  expect_same(result, updated_by_command(measured));
}

/// The third mode is another one: no stiffness of the first spring explains it.
TEST(UpdateVerdict, IsUnusableWhereTheModelCannotFollow) {
  const auto measured = frequencies({0.0, 0.0, 25.0});
  const auto result = updated(measured);
  EXPECT_TRUE(result.converged) << result.reason;
  EXPECT_EQ(result.verdict.state(), VerdictState::unusable);
  EXPECT_FALSE(result.usable());
  const auto reasons = result.verdict.reasons();
  EXPECT_EQ(reasons.front().code, "residual_large");
  EXPECT_GT(reasons.front().weight, 12.0);  // standard deviations, expected 1
  EXPECT_LT(reasons.front().weight, 16.0);
  expect_same(result, updated_by_command(measured));
}

/// One frequency for one parameter: it is found, but nothing is left that could contradict it.
TEST(UpdateVerdict, HasNoRobustDeviationWhereNothingIsLeftThatScatters) {
  const auto result = updated({frequencies({0.0, 0.0, 0.0}).front()});
  EXPECT_EQ(result.verdict.state(), VerdictState::consistent);
  EXPECT_TRUE(std::isnan(result.parameters[0].std_robust));
}

}  // namespace
}  // namespace kalfem::test
