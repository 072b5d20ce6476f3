#include "kalfem/identification/simulation_likelihood.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "identification/chain_structure.hpp"
#include "kalfem/identification/simulation_residual.hpp"
#include "kalfem/identification/updating_setup.hpp"

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
TEST(SimulationLikelihood, DensityOfASeriesIsTheMultivariateNormal) {
  for (const bool with_gaps : {false, true})
    for (const double time : {0.0, 1e-4, 4e-3, 0.1}) {
      const CorrelatedError error{.correlation_time = time, .deviation = 1.3};
      const VectorXd series = noisy_series(with_gaps);
      const double expected = dense_log_density(series, error, 1.3);
      EXPECT_NEAR(log_density_of_correlated_series(series, interval, error), expected, 1e-10 * std::abs(expected))
          << time;
    }
}

TEST(SimulationLikelihood, AProfiledDeviationIsTheMostLikelyOne) {
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

TEST(SimulationLikelihood, OfNothingIsNoneAndOfZerosIsInfinite) {
  EXPECT_EQ(log_density_of_correlated_series(VectorXd::Constant(9, missing), interval, {}), -infinity);
  EXPECT_EQ(log_density_of_correlated_series(VectorXd(), interval, {}), -infinity);
  EXPECT_EQ(log_density_of_correlated_series(VectorXd::Constant(9, infinity), interval, {}), -infinity);
  EXPECT_EQ(log_density_of_correlated_series(VectorXd::Zero(9), interval, {}), infinity);
}

/// r = theta_0 + theta_1 t about fixed series of two channels, whose rows are mixed; fails at a negative theta_0.
class LineResidual final : public Residual {
public:
  LineResidual() : first(noisy_series(false)), second(2.0 * noisy_series(false).reverse()) {}

  [[nodiscard]] std::string name() const override { return "line"; }
  [[nodiscard]] Index size() const override { return 120; }
  [[nodiscard]] RowLayout layout() const override {
    RowLayout layout;
    for (Index row = 0; row < size(); ++row) {
      layout.part.push_back(row % 2);
      layout.step.push_back(59 - row / 2);
    }
    return layout;
  }
  [[nodiscard]] std::optional<ResidualValue> evaluate(const VectorXd& theta, bool /*with_jacobian*/) const override {
    if (theta[0] < 0.0) return std::nullopt;
    ResidualValue value{VectorXd(120), {}};
    for (Index row = 0; row < 120; ++row) value.values[row] = channel(row % 2, theta)[59 - row / 2];
    return value;
  }
  [[nodiscard]] VectorXd channel(Index which, const VectorXd& theta) const {
    return (which == 0 ? first : second).array() + theta[0] + theta[1] * VectorXd::LinSpaced(60, 0.0, 1.0).array();
  }
  VectorXd first, second;
};

TEST(SimulationLikelihood, SumsOverChannelsAlongTheirTime) {
  const auto residual = std::make_shared<LineResidual>();
  const std::vector<CorrelatedError> errors{{.correlation_time = 4e-3, .deviation = 1.1}, {.correlation_time = 1e-2}};
  const SimulationLikelihood likelihood(residual, errors, interval);
  const VectorXd theta{{0.3, -0.2}};
  double expected = 0.0;
  for (const Index which : {0, 1})
    expected += log_density_of_correlated_series(residual->channel(which, theta), interval, errors[std::size_t(which)]);
  EXPECT_DOUBLE_EQ(likelihood.log_likelihood(theta), expected);
  EXPECT_EQ(likelihood.log_likelihood(VectorXd{{-1.0, 0.0}}), -infinity);
  EXPECT_EQ(likelihood.log_likelihood(VectorXd{{missing, 0.0}}), -infinity);
}

TEST(SimulationLikelihood, SaysWhatIsWrongWithTheErrors) {
  const auto residual = std::make_shared<LineResidual>();
  const auto said = [&](const std::vector<CorrelatedError>& errors, double step) {
    return refusal([&] { SimulationLikelihood(residual, errors, step); });
  };
  EXPECT_EQ(said({{}, {}}, interval), "");
  EXPECT_NE(said({{}}, interval).find("1 error models for 2 channels"), std::string::npos);
  EXPECT_NE(said({{}, {.correlation_time = -1.0}}, interval).find("correlation time"), std::string::npos);
  EXPECT_NE(said({{.deviation = 0.0}, {}}, interval).find("deviation"), std::string::npos);
  EXPECT_NE(said({{}, {}}, 0.0).find("interval"), std::string::npos);
}

// The density of the chain's record: what is missing counts as such, not as a residual of zero, and white noise is most
// likely at the truth.
TEST(SimulationLikelihood, OfASimulatedStructure) {
  const auto problem = chain_problem();
  Record record = chain_record(problem, 1.0);
  record.values.row(1).segment(300, 200).setConstant(missing);
  const auto& structure = problem.structure;
  const std::vector<StructureBinding> bindings{{0, parameter(*structure, "body.3-4.stiffness")}};
  const std::vector<UpdatingParameter> parameters{{.name = "stiffness", .unit = "N/m", .initial = body_stiffness}};
  const auto residual = std::make_shared<SimulationResidual>(
      structure, problem.sensors, record, std::make_shared<const ParameterisedStructure>(structure, bindings, 1),
      parameters, SimulationResidual::Options{.name = "record"});
  const auto compared = residual->compared_rows();
  EXPECT_EQ(std::ranges::count(compared, false), 200);
  const SimulationLikelihood white(residual, std::vector<CorrelatedError>(4, {.deviation = 1.0}), 1.0 / chain_rate);
  const VectorXd truth = VectorXd::Constant(1, body_stiffness);
  const VectorXd values = residual->evaluate(truth, false)->values;
  const auto n = static_cast<double>(values.size() - 200);
  EXPECT_NEAR(white.log_likelihood(truth), -0.5 * (values.squaredNorm() + n * std::log(2.0 * std::numbers::pi)),
              1e-9 * n);
  EXPECT_GT(white.log_likelihood(truth), white.log_likelihood(0.98 * truth));
  EXPECT_GT(white.log_likelihood(truth), white.log_likelihood(1.02 * truth));
  EXPECT_EQ(white.log_likelihood(-truth), -infinity);
}

}  // namespace
}  // namespace kalfem::test
