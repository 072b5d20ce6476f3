// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/parameter_statistics.hpp"

#include <gtest/gtest.h>
#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/updating/gauss_newton.hpp"
#include "updating/nist_problems.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nist::vector;

VectorXd normals(RandomStream& random, Index count) {
  return VectorXd::NullaryExpr(count, [&] { return random.normal(); });
}

MatrixXd normals(RandomStream& random, Index rows, Index columns) {
  return MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

bool mentions(const std::vector<std::string>& findings, std::initializer_list<std::string> words) {
  return std::any_of(findings.begin(), findings.end(), [&](const std::string& finding) {
    return std::all_of(words.begin(), words.end(),
                       [&](const std::string& word) { return finding.find(word) != std::string::npos; });
  });
}

// ------------------------------------------------------------------------------------------------- covariance

TEST(ParameterStatistics, CovarianceOfLinearRegressionInClosedForm) {
  RandomStream random(1, "regression");
  const MatrixXd matrix = normals(random, 40, 3) * vector({1e-6, 1.0, 1e4}).asDiagonal();  // units far apart
  const VectorXd residual = 3.0 * normals(random, 40);
  auto parameters = free_parameters(vector({2e6, 1.0, 3e-4}));
  const auto plain = parameter_statistics(parameters, initial_values(parameters), {residual, matrix});
  const double chi_squared = residual.squaredNorm() / 37.0;
  const MatrixXd expected = chi_squared * MatrixXd((matrix.transpose() * matrix).inverse());
  const auto unit = [](const MatrixXd& m) {
    const VectorXd d = m.diagonal().cwiseSqrt().cwiseInverse();
    return MatrixXd(d.asDiagonal() * m * d.asDiagonal());
  };
  // rounding, with parameters scaled by their columns
  EXPECT_NEAR(*plain.reduced_chi_squared, chi_squared, 1e-14 * chi_squared);
  EXPECT_GT(plain.variance_inflation, 4.0);
  EXPECT_LT((plain.deviations - expected.diagonal().cwiseSqrt()).cwiseQuotient(plain.deviations).norm(), 1e-13);
  EXPECT_LT((plain.correlation - unit(expected)).norm(), 1e-13);
  EXPECT_LT((unit(plain.covariance) - unit(expected)).norm(), 1e-13);

  // Smaller residuals than stated narrow nothing; a prior adds its precision.
  parameters[1].deviation = 0.1;
  const auto with_prior = parameter_statistics(parameters, initial_values(parameters), {0.01 * residual, matrix});
  MatrixXd precision = matrix.transpose() * matrix;
  precision(1, 1) += 100.0;
  const VectorXd deviations = MatrixXd(precision.inverse()).diagonal().cwiseSqrt();
  EXPECT_EQ(with_prior.variance_inflation, 1.0);
  EXPECT_LT((with_prior.deviations - deviations).cwiseQuotient(deviations).norm(), 1e-13);
  EXPECT_NEAR(with_prior.to_prior[1], deviations[1] / 0.1, 1e-13);
  EXPECT_EQ(with_prior.to_prior[0], 0.0);
  // a parameter that its prior holds takes less than one
  EXPECT_NEAR(with_prior.degrees_of_freedom, 37.0 + std::pow(with_prior.to_prior[1], 2), 1e-12);
}

/// The certified standard deviations are those of residuals whose own deviation is estimated from them, so the stated
/// one is made too small for all four.
TEST(ParameterStatistics, DeviationsOfCertifiedRegressions) {
  for (const auto& problem : nist_problems()) {
    auto value = *problem.residual.evaluate(problem.certified, true);
    value.values *= 1e4, value.jacobian *= 1e4;
    const auto statistics = parameter_statistics(free_parameters(problem.certified), problem.certified, value);
    const VectorXd error =
        (statistics.deviations - problem.certified_deviations).cwiseQuotient(problem.certified_deviations);
    // the eleven digits of the parameters leave 5e-10
    EXPECT_LT(error.cwiseAbs().maxCoeff(), 2e-9) << problem.name;
    EXPECT_NEAR(statistics.degrees_of_freedom, static_cast<double>(problem.residual.size() - problem.certified.size()),
                1e-12)
        << problem.name;
  }
}

// Two values, three parameters with priors: kappa is that of the formula although less than one degree of freedom is
// left. (I - J H^-1 J^T) is the inverse of the covariance of the values, so |r|^2 has the mean N - trace(J^T J H^-1).
TEST(ParameterStatistics, AFewValuesBesidePriorsWidenAsManyDo) {
  MatrixXd matrix(2, 3);
  matrix << 30.0, 12.0, -7.0, 9.0, -20.0, 4.0;
  auto parameters = free_parameters(vector({1.0, 2.0, 0.5}));
  for (auto& each : parameters) each.deviation = 0.05 * each.initial;
  const VectorXd residual = vector({0.9, -1.3});
  const auto found = parameter_statistics(parameters, initial_values(parameters), {residual, matrix});
  const MatrixXd prior = vector({400.0, 100.0, 1600.0}).asDiagonal(), told = matrix.transpose() * matrix,
                 inverse = (told + prior).inverse();
  const double freedom = 2.0 - (told * inverse).trace(), kappa = residual.squaredNorm() / freedom;
  ASSERT_LT(freedom, 1.0);
  ASSERT_GT(kappa, 2.0);
  const VectorXd expected = (inverse * (kappa * told + prior) * inverse).diagonal().cwiseSqrt();
  EXPECT_NEAR(found.variance_inflation, kappa, 1e-12 * kappa);
  EXPECT_LT((found.deviations - expected).cwiseQuotient(expected).norm(), 1e-12);
}

/// With as many values as parameters and no prior nothing is left to judge the noise by.
TEST(ParameterStatistics, NothingIsWidenedWithoutAnyFreedom) {
  const auto parameters = free_parameters(vector({1.0, 2.0}));
  const MatrixXd matrix = MatrixXd::Identity(2, 2) * 30.0;
  EXPECT_EQ(
      parameter_statistics(parameters, initial_values(parameters), {vector({1e-4, 1e-4}), matrix}).variance_inflation,
      1.0);
}

/// Shares of 600 runs in which the truth lies within 1.96 deviations of the estimate. The truth of a parameter with a
/// prior is drawn from it; the noise is `noise` times as large as stated.
VectorXd coverage(const VectorXd& prior, double noise) {
  constexpr int runs = 600;
  constexpr Index samples = 60;
  VectorXd inside = VectorXd::Zero(3);
  for (int run = 0; run < runs; ++run) {
    RandomStream random(static_cast<std::uint64_t>(run), "coverage");
    auto parameters = free_parameters(vector({3.0, 1.5, 0.2}));
    VectorXd truth = vector({3.1, 1.4, 0.25});
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = static_cast<Index>(i);
      parameters[i].deviation = prior[at];
      if (std::isfinite(prior[at])) truth[at] = parameters[i].initial + prior[at] * random.normal();
    }
    const VectorXd time = VectorXd::LinSpaced(samples, 0.0, 3.0), error = noise * normals(random, samples);
    const auto decay = [=](const VectorXd& theta) {
      const VectorXd shape = (-theta[1] * time).array().exp();
      ResidualValue value{theta[0] * shape + VectorXd::Constant(samples, theta[2]), MatrixXd(samples, 3)};
      value.jacobian << shape, -theta[0] * time.cwiseProduct(shape), VectorXd::Ones(samples);
      return value;
    };
    const VectorXd measured = decay(truth).values + 0.1 * error;
    const FunctionResidual residual(samples, [=](const VectorXd& theta) {
      auto value = decay(theta);
      value.values = (value.values - measured) / 0.1;
      value.jacobian /= 0.1;
      return value;
    });
    const auto outcome = minimise(residual, parameters);
    const auto statistics = parameter_statistics(parameters, outcome.parameters, outcome.residual);
    for (Index i = 0; i < 3; ++i)
      inside[i] += std::abs(outcome.parameters[i] - truth[i]) < 1.96 * statistics.deviations[i] ? 1.0 / runs : 0.0;
  }
  return inside;
}

/// 600 runs leave 0.009 of deviation to a share of 0.95. kappa is estimated: 57 degrees of freedom cost it half a
/// percent of coverage where noise is larger than stated, and where it is not, its never being below one adds one
/// percent.
TEST(ParameterStatistics, CoverTheTruthAsOftenAsTheySay) {
  const double none = std::numeric_limits<double>::infinity();
  for (const auto& [prior, noise] : {std::pair(vector({none, none, none}), 1.0),
                                     {vector({none, none, none}), 3.0},
                                     {vector({0.05, 0.1, 0.01}), 1.0},
                                     {vector({0.05, 0.1, none}), 3.0}}) {
    const VectorXd shares = coverage(prior, noise);
    EXPECT_GT(shares.minCoeff(), 0.92) << "noise " << noise << ", prior " << prior.transpose();
    EXPECT_LT(shares.maxCoeff(), 0.98) << "noise " << noise << ", prior " << prior.transpose();
  }
}

// ------------------------------------------------------------------------------------- what the residual does not tell

/// Frequencies of a plate: they depend on E t^2 / rho with stretching left out, on the mass m well, and not on d at
/// all.
struct Plate {
  std::vector<UpdatingParameter> parameters;
  ResidualValue value;
  VectorXd values;

  Plate() {
    parameters = free_parameters(vector({70e9, 2e-3, 4.0, 0.01}));
    const char* names[] = {"plate.E", "plate.t", "mass", "damping"};
    for (std::size_t i = 0; i < 4; ++i) parameters[i].name = names[i];
    values = initial_values(parameters);
    RandomStream random(1, "plate");
    value.values = normals(random, 30);
    value.jacobian = MatrixXd::Zero(30, 4);
    const VectorXd stiffness = 500.0 * normals(random, 30), mass = 400.0 * normals(random, 30);
    value.jacobian.col(0) = stiffness / 70e9;
    value.jacobian.col(1) = 2.0 * stiffness / 2e-3;
    value.jacobian.col(2) = mass / 4.0;
  }
};

TEST(ParameterStatistics, NamesWhatCannotBeToldApartAndWhatIsNotSeen) {
  const Plate plate;
  const auto statistics = parameter_statistics(plate.parameters, plate.values, plate.value);
  EXPECT_EQ(statistics.seen, (std::vector{Seen::poorly, Seen::poorly, Seen::well, Seen::not_at_all}));
  ASSERT_EQ(statistics.unidentifiable.size(), 1U);
  EXPECT_EQ(statistics.unidentifiable[0].parameters, (std::vector<Index>{0, 1}));
  EXPECT_NEAR(statistics.unidentifiable[0].changes[1], -0.5, 1e-12) << "half the thickness, squared, makes up for E";
  EXPECT_TRUE(std::isinf(statistics.deviations[0]));
  EXPECT_TRUE(std::isinf(statistics.deviations[1]));
  EXPECT_TRUE(std::isinf(statistics.deviations[3]));
  const VectorXd mass = plate.value.jacobian.col(2), stiffness = plate.value.jacobian.col(0).normalized();
  const double across = (mass - stiffness * stiffness.dot(mass)).norm();  // what only the mass explains
  EXPECT_NEAR(statistics.deviations[2] * across / std::sqrt(statistics.variance_inflation), 1.0, 1e-14);
  EXPECT_NEAR(statistics.correlation(0, 1), -1.0, 1e-12);
  EXPECT_TRUE(statistics.correlated.empty()) << "said already";
  EXPECT_TRUE(statistics.covariance.allFinite() == false && !statistics.covariance.hasNaN());
  EXPECT_NEAR(statistics.degrees_of_freedom, 28.0, 1e-12);

  const auto findings = parameter_findings(plate.parameters, plate.values, statistics);
  EXPECT_EQ(findings.size(), 2U);
  EXPECT_TRUE(mentions(findings,
                       {"plate.E and plate.t cannot be identified separately", "plate.E by +10 %", "plate.t by -5 %"}));
  EXPECT_TRUE(mentions(findings, {"damping", "no measurement depends on it"}));
}

TEST(ParameterStatistics, PriorsDecideWhereTheResidualIsBlind) {
  Plate plate;
  plate.parameters[0].deviation = 0.1 * 70e9;
  plate.parameters[1].deviation = 0.1 * 2e-3;
  plate.parameters[3].deviation = 0.005;
  const auto statistics = parameter_statistics(plate.parameters, plate.values, plate.value);
  // a = dE / E, b = dt / t with a + 2 b = 0 and prior deviations of 0.1: along (2, -1) / sqrt(5) the prior remains.
  // The residual, whose own deviation across is 4e-4 of the prior's, takes the square of it: found 3e-7.
  EXPECT_NEAR(statistics.deviations[0] / 70e9, 0.1 * 2.0 / std::sqrt(5.0), 1.5e-7);
  EXPECT_NEAR(statistics.deviations[1] / 2e-3, 0.1 / std::sqrt(5.0), 1e-6);
  EXPECT_NEAR(statistics.deviations[3], 0.005, 1e-17);
  EXPECT_NEAR(statistics.to_prior[3], 1.0, 1e-14);
  EXPECT_EQ(statistics.seen, (std::vector{Seen::poorly, Seen::poorly, Seen::well, Seen::not_at_all}));
  EXPECT_EQ(statistics.unidentifiable.size(), 1U);
}

TEST(ParameterStatistics, SeparatesTwoPairsThatCannotBeToldApart) {
  RandomStream random(1, "pairs");
  const VectorXd first = 1e3 * normals(random, 20), second = 1e3 * normals(random, 20);
  MatrixXd jacobian(20, 5);
  jacobian << first, second, 3.0 * first, -second, 1e3 * normals(random, 20);
  const auto parameters = free_parameters(VectorXd::Ones(5));
  const auto statistics = parameter_statistics(parameters, VectorXd::Ones(5), {normals(random, 20), jacobian});
  ASSERT_EQ(statistics.unidentifiable.size(), 2U);
  for (const auto& combination : statistics.unidentifiable) {
    ASSERT_EQ(combination.parameters.size(), 2U);
    const bool is_first = combination.parameters[0] == 0;
    EXPECT_NEAR(combination.changes[1], is_first ? -1.0 / 3.0 : 1.0, 1e-14);  // rounding
    EXPECT_EQ(combination.parameters[0] + combination.parameters[1], is_first ? 2 : 4);
  }
  EXPECT_EQ(statistics.seen[4], Seen::well);
}

TEST(ParameterStatistics, ReportsWeakPriorsCorrelationBoundsAndLargeResiduals) {
  RandomStream random(1, "weak");
  MatrixXd jacobian = 100.0 * normals(random, 50, 4);
  jacobian.col(1) = jacobian.col(0) + 0.05 * jacobian.col(1);  // alike to 5 %: correlated, and yet both well seen
  jacobian.col(2) *= 1e-3;                                     // deviation about 1.4 / scale, prior 0.2
  auto parameters = free_parameters(VectorXd::Ones(4));
  parameters[2].deviation = 0.2;
  parameters[3].upper = 1.25;
  VectorXd values = VectorXd::Ones(4);
  values[3] = 1.25;
  parameters[0].lower = 1.0;  // ended there, but is pulled inwards
  VectorXd residual = 2.0 * normals(random, 50);
  residual -= jacobian.col(3) * 0.01 + jacobian.col(0) * 0.01;
  const auto statistics = parameter_statistics(parameters, values, {residual, jacobian});
  EXPECT_EQ(statistics.seen, (std::vector{Seen::well, Seen::well, Seen::poorly, Seen::held}));
  EXPECT_TRUE(std::isnan(statistics.deviations[3]));
  ASSERT_EQ(statistics.correlated.size(), 1U);
  // the columns are not quite at right angles
  EXPECT_NEAR(statistics.correlated[0].correlation, -1.0 / std::sqrt(1.0 + 0.05 * 0.05), 1.5e-4);
  EXPECT_EQ(statistics.at_bound, (std::vector{false, false, false, true}));
  auto held_by_prior = parameters;
  held_by_prior[3].deviation = 1e-3;
  EXPECT_FALSE(parameter_statistics(held_by_prior, values, {residual, jacobian}).at_bound[3]) << "its prior pulls back";
  const auto findings = parameter_findings(parameters, values, statistics);
  EXPECT_EQ(findings.size(), 4U);
  EXPECT_TRUE(mentions(findings, {"p1 and p2 have a correlation of -0.99"}));
  EXPECT_TRUE(mentions(findings, {"the data hardly identify p3", "% of the prior's"}));
  EXPECT_TRUE(mentions(findings, {"p4 ended at its upper bound, 1.25"}));
  EXPECT_TRUE(mentions(findings, {"times as large as the stated standard deviations"}));
}

TEST(ParameterStatistics, SaysNothingWhereAllIsWell) {
  RandomStream random(1, "well");
  const auto parameters = free_parameters(VectorXd::Ones(3));
  const auto statistics =
      parameter_statistics(parameters, VectorXd::Ones(3), {normals(random, 50), 100.0 * normals(random, 50, 3)});
  EXPECT_TRUE(parameter_findings(parameters, VectorXd::Ones(3), statistics).empty());
}

TEST(ParameterStatistics, LeavesHeldParametersOut) {
  RandomStream random(1, "held");
  MatrixXd jacobian = 100.0 * normals(random, 50, 3);
  jacobian.col(2) = jacobian.col(0);
  auto parameters = free_parameters(VectorXd::Ones(3));
  parameters[2].lower = parameters[2].upper = 1.0;
  const auto statistics = parameter_statistics(parameters, VectorXd::Ones(3), {normals(random, 50), jacobian});
  EXPECT_EQ(statistics.seen, (std::vector{Seen::well, Seen::well, Seen::held}));
  EXPECT_EQ(statistics.deviations[2], 0.0);
  EXPECT_TRUE(statistics.unidentifiable.empty());
  EXPECT_TRUE(statistics.covariance.allFinite());
  EXPECT_NEAR(statistics.degrees_of_freedom, 48.0, 1e-12);  // rounding
}

TEST(ParameterStatistics, FewerResidualsThanParametersNeedPriors) {
  auto parameters = free_parameters(vector({1.0, 2.0}));
  const ResidualValue value{vector({0.5}), MatrixXd::Constant(1, 2, 10.0)};
  const auto alone = parameter_statistics(parameters, vector({1.0, 2.0}), value);
  EXPECT_FALSE(alone.reduced_chi_squared);
  EXPECT_TRUE(std::isinf(alone.deviations[0]));
  for (auto& p : parameters) p.deviation = 0.1;
  const auto held = parameter_statistics(parameters, vector({1.0, 2.0}), value);
  const MatrixXd precision = MatrixXd::Constant(2, 2, 100.0) + MatrixXd(100.0 * MatrixXd::Identity(2, 2));
  EXPECT_LT((held.covariance - precision.inverse()).norm(), 1e-16);  // rounding of .007
}

TEST(ParametersWithoutEffect, AreThoseThatNothingDependsOn) {
  const Plate plate;
  auto parameters = plate.parameters;
  EXPECT_EQ(without_effect(parameters, plate.value.jacobian), std::vector{parameters[3].name});
  parameters[3].lower = parameters[3].upper = parameters[3].initial;
  EXPECT_TRUE(without_effect(parameters, plate.value.jacobian).empty());
}

}  // namespace
}  // namespace kalfem
