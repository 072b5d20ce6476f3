// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <numbers>

#include "estimation/chain_model.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/estimation/filter_setup.hpp"
#include "kalfem/system/laws/expression_law.hpp"
#include "kalfem/system/laws/law_library.hpp"

// How the error of a prediction falls with the parts of the sample interval, in mean and covariance, by laws. The
// reference moves each sigma point by the equations of motion written down here, with the classical Runge-Kutta method
// and many short steps: no code of the filter's step is in it, and none of the laws.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double wheel_mass = 1.5, tyre_stiffness = 2e4, tyre_damping = 4.0;  // of quarter_chain(), whose body has 1 kg
constexpr double interval = 0.0173;                                           // [s]: no whole period of anything

/// A suspension between wheel and body, in words of the library and as it is written on paper.
struct Suspension {
  std::string name;
  ConnectorLawPtr law;
  VectorXd parameters;
  Index unknown;  ///< parameter that the filter estimates
  std::function<double(double d, double v, double z, const VectorXd& p)> force;
  std::function<double(double d, double v, double z, const VectorXd& p)> flow = {};  ///< z'; empty: no state
};

/// The road [r; r'; r''] at a time.
Eigen::Vector3d road(double t) {
  Eigen::Vector3d r = Eigen::Vector3d::Zero();
  for (const auto& [size, rate, phase] : {std::array{3e-3, 44.0, 0.3}, std::array{1e-3, 130.0, 1.0}})
    r += size * Eigen::Vector3d(std::sin(rate * t + phase), rate * std::cos(rate * t + phase),
                                -rate * rate * std::sin(rate * t + phase));
  return r;
}

/// Of y = [wheel, body, their velocities, z, ln theta].
VectorXd flow(const Suspension& suspension, double t, const VectorXd& y) {
  VectorXd p = suspension.parameters, rate = VectorXd::Zero(y.size());
  p[suspension.unknown] = std::exp(y[y.size() - 1]);
  const double d = y[1] - y[0], v = y[3] - y[2], z = suspension.flow ? y[4] : 0.0;
  const double f = suspension.force(d, v, z, p);
  const Eigen::Vector3d r = road(t);
  rate.head(2) = y.segment(2, 2);
  rate[2] = (-tyre_stiffness * (y[0] - r[0]) - tyre_damping * (y[2] - r[1]) + f) / wheel_mass;
  rate[3] = -f;
  if (suspension.flow) rate[4] = suspension.flow(d, v, z, p);
  return rate;
}

VectorXd runge_kutta(const Suspension& suspension, VectorXd y, int steps) {
  const double h = interval / steps;
  for (int i = 0; i < steps; ++i) {
    const double t = i * h;
    const VectorXd a = flow(suspension, t, y), b = flow(suspension, t + h / 2, y + h / 2 * a),
                   c = flow(suspension, t + h / 2, y + h / 2 * b), d = flow(suspension, t + h, y + h * c);
    y += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return y;
}

/// The unscented transform of the exact motion, with the filter's default weights: alpha 1, beta 2, kappa 0.
Gaussian exact_prediction(const Suspension& suspension, const Gaussian& prior, int steps) {
  const Index n = prior.mean.size();
  const MatrixXd spread = std::sqrt(double(n)) * MatrixXd(Eigen::LLT<MatrixXd>(prior.covariance).matrixL());
  std::vector<VectorXd> images{runge_kutta(suspension, prior.mean, steps)};
  for (Index i = 0; i < n; ++i)
    for (const double sign : {1.0, -1.0})
      images.push_back(runge_kutta(suspension, prior.mean + sign * spread.col(i), steps));
  Gaussian moments{VectorXd::Zero(n), MatrixXd::Zero(n, n)};
  for (std::size_t i = 1; i < images.size(); ++i) moments.mean += images[i] / double(2 * n);
  for (std::size_t i = 0; i < images.size(); ++i)
    moments.covariance +=
        (i == 0 ? 2.0 : 0.5 / double(n)) * (images[i] - moments.mean) * (images[i] - moments.mean).transpose();
  return moments;
}

CoupledModel model_of(const Suspension& suspension) {
  return quarter_chain(1, {{"suspension", "wheel.w", "body.1", suspension.law, suspension.parameters}},
                       {{"road", InputKind::base_displacement, "wheel.ground"}}, 0.0);
}

AugmentedModel augmented_model_of(const Suspension& suspension, int order, int substeps) {
  const auto model = model_of(suspension);
  auto options = all_known(model.system(), interval);
  options.substeps = substeps;
  options.step_order = order;
  const double theta = suspension.parameters[suspension.unknown];
  options.unknowns = {{"theta", "", {{0, suspension.unknown}}, {TransformKind::log}, theta, 0.2 * theta}};
  options.forces.tolerance = 1e-12;
  return AugmentedModel(model.system(), make_outputs(model, {Chain::acceleration("1")}), {}, options);
}

/// In motion, with deviations of the size at which the laws bend, and correlated.
Gaussian prior_of(const Suspension& suspension) {
  const Index n = suspension.flow ? 6 : 5;
  Gaussian prior{VectorXd::Zero(n), MatrixXd::Zero(n, n)};
  prior.mean.head(4) << 2e-3, 5.5e-3, 0.1, -0.35;
  prior.mean[n - 1] = std::log(suspension.parameters[suspension.unknown]);
  VectorXd deviation(n);
  deviation.head(4) << 0.4e-3, 0.5e-3, 0.05, 0.04;
  deviation[n - 1] = 0.2;
  if (suspension.flow) {
    prior.mean[4] = 1e-3;
    deviation[4] = 0.2e-3;
  }
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j)
      prior.covariance(i, j) = deviation[i] * deviation[j] * std::pow(0.4, double(std::abs(i - j)));
  return prior;
}

Gaussian prediction(const Suspension& suspension, const Gaussian& prior, int order, int substeps) {
  const auto model = std::make_shared<const AugmentedModel>(augmented_model_of(suspension, order, substeps));
  FilterSetup setup(model, MatrixXd::Identity(1, 1), {});
  const int instants = model->options().instants();
  MatrixXd inputs(3, instants + 1);
  for (int i = 0; i <= instants; ++i) inputs.col(i) = road(interval * i / instants);
  setup.transition.set_inputs(inputs);
  setup.filter->reset(prior);
  if (setup.filter->predict() != FilterOutcome::usable) throw std::runtime_error("the prediction failed");
  return {setup.filter->mean(), setup.filter->covariance()};
}

/// The largest error of a mean in standard deviations, and of an entry of the covariance in those of its row and
/// column.
struct Error {
  double mean, covariance;
};
Error error_of(const Gaussian& found, const Gaussian& exact) {
  const VectorXd scale = exact.covariance.diagonal().cwiseSqrt().cwiseInverse();
  return {(found.mean - exact.mean).cwiseProduct(scale).cwiseAbs().maxCoeff(),
          (scale.asDiagonal() * (found.covariance - exact.covariance) * scale.asDiagonal()).cwiseAbs().maxCoeff()};
}

/// Slope of log(error) over log(parts), least squares.
double order_of(const std::vector<int>& parts, const std::vector<double>& errors) {
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double x = std::log(double(parts[i])), y = std::log(errors[i]);
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  const auto n = double(parts.size());
  return -(n * sxy - sx * sy) / (n * sxx - sx * sx);
}

struct Orders {
  double mean, covariance;
  Error least;  ///< with the most parts
};
Orders measured_orders(const Suspension& suspension, int order, const std::vector<int>& parts, int reference_steps) {
  const auto prior = prior_of(suspension);
  const auto exact = exact_prediction(suspension, prior, reference_steps);
  std::vector<double> of_mean, of_covariance;
  for (const int each : parts) {
    const auto error = error_of(prediction(suspension, prior, order, each), exact);
    of_mean.push_back(error.mean);
    of_covariance.push_back(error.covariance);
  }
  const Orders orders{order_of(parts, of_mean), order_of(parts, of_covariance), {of_mean.back(), of_covariance.back()}};
  std::cout << suspension.name << ", step of order " << order << ": " << orders.mean << " (mean), " << orders.covariance
            << " (covariance); with " << parts[0] << " parts " << of_mean[0] << ", " << of_covariance[0] << "; with "
            << parts.back() << " " << of_mean.back() << ", " << of_covariance.back() << "\n";
  return orders;
}

ConnectorLawPtr written(const std::string& force, const std::vector<std::string>& parameters,
                        const std::vector<ExpressionState>& states = {}) {
  ExpressionLawOptions options{.force = force, .parameters = {}, .states = states};
  for (const auto& name : parameters) options.parameters.push_back({name, "-"});
  return expression_law(options);
}

// ---------------------------------------------------------------------------------------------------- smooth laws

void PrintTo(const Suspension& suspension, std::ostream* out) { *out << suspension.name; }
class SmoothLaws : public testing::TestWithParam<Suspension> {};

TEST_P(SmoothLaws, GiveAStepOfOrderFourInMeanAndCovariance) {
  const auto& suspension = GetParam();
  const auto two = measured_orders(suspension, 2, {4, 8, 16, 32}, 4000);
  const auto four = measured_orders(suspension, 4, {2, 4, 8, 16}, 4000);
  EXPECT_NEAR(two.mean, 2.0, 0.2);
  EXPECT_NEAR(two.covariance, 2.0, 0.2);
  EXPECT_GE(four.mean, 3.8);
  EXPECT_GE(four.covariance, 3.8);
  // Two quadratic parts have the instants of four linear ones.
  EXPECT_LT(four.least.mean, 0.02 * two.least.mean);
  EXPECT_LT(four.least.covariance, 0.02 * two.least.covariance);
}

TEST_P(SmoothLaws, AreIndependentlyReferenced) {  // the reference moves by less than what is judged by it
  const auto& suspension = GetParam();
  const auto prior = prior_of(suspension);
  const auto error = error_of(exact_prediction(suspension, prior, 2000), exact_prediction(suspension, prior, 4000));
  EXPECT_LT(error.mean, 1e-10);
  EXPECT_LT(error.covariance, 1e-10);
}

std::string name_of(const testing::TestParamInfo<Suspension>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(
    Laws, SmoothLaws,
    testing::Values(Suspension{"cubic", cubic_law(), values({5e3, 2e8, 10.0, 40.0}), 1,
                               [](double d, double v, double /*z*/, const VectorXd& p) {
                                 return p[0] * d + p[1] * d * d * d + p[2] * v + p[3] * v * v * v;
                               }},
                    Suspension{"quintic", polynomial_law(5, 1), values({5e3, 2e5, 5e7, 0.0, 4e12, 10.0}), 4,
                               [](double d, double v, double /*z*/, const VectorXd& p) {
                                 return p[0] * d + p[1] * d * d + p[2] * std::pow(d, 3) + p[4] * std::pow(d, 5) +
                                        p[5] * v;
                               }},
                    Suspension{"expression",
                               written("k*x + f*tanh(x/s) + c*v/sqrt(1 + v*v/u)", {"k", "f", "s", "c", "u"}),
                               values({5e3, 15.0, 3e-3, 20.0, 0.1}), 1,
                               [](double d, double v, double /*z*/, const VectorXd& p) {
                                 return p[0] * d + p[1] * std::tanh(d / p[2]) + p[3] * v / std::sqrt(1 + v * v / p[4]);
                               }}),
    name_of);

// ---------------------------------------------------------------------------------- laws with kinks and with states

/// What limits the order: a jump in the second derivative of the force (saturating), where the part with the kink errs
/// by h^3; in its first derivative (gap, Bouc-Wen where the motion turns), by h^2; states, which laws integrate with an
/// error of second order, extrapolated to the third.
struct Limited {
  Suspension suspension;
  double least, most;  ///< measured order of the mean with a step of order 4, over 4 to 64 parts
};
void PrintTo(const Limited& limited, std::ostream* out) { *out << limited.suspension.name; }
class LimitedLaws : public testing::TestWithParam<Limited> {};

TEST_P(LimitedLaws, GiveALowerOrderAndLessErrorThanLinearForces) {
  const auto& [suspension, least, most] = GetParam();
  const std::vector<int> linear{8, 12, 16, 24, 32, 48, 64, 96, 128}, quadratic{4, 6, 8, 12, 16, 24, 32, 48, 64};
  const auto two = measured_orders(suspension, 2, linear, 40000);
  const auto four = measured_orders(suspension, 4, quadratic, 40000);
  EXPECT_GE(four.mean, least);
  EXPECT_LE(four.mean, most);
  EXPECT_LT(four.least.mean, 0.5 * two.least.mean);  // at the same instants
  EXPECT_LT(four.least.covariance, 0.8 * two.least.covariance);
}

INSTANTIATE_TEST_SUITE_P(
    Laws, LimitedLaws,
    testing::Values(Limited{{"saturating", saturating_law(), values({5e3, 20.0, 2e-3, 10.0, 10.0, 0.05}), 1,
                             [](double d, double v, double /*z*/, const VectorXd& p) {
                               return (p[0] + p[1] / (p[2] + std::abs(d))) * d +
                                      (p[3] + p[4] / (p[5] + std::abs(v))) * v;
                             }},
                            2.5,
                            3.2},
                    Limited{{"gap", gap_law(), values({2e4, 0.0, 4e-3, 4e-3, 5e3, 10.0}), 0,
                             [](double d, double v, double /*z*/, const VectorXd& p) {
                               const double over = std::max(0.0, d - p[2]), under = std::max(0.0, -d - p[3]);
                               return p[4] * d + p[5] * v + p[0] * (over - under);
                             }},
                            2.0,
                            2.6},
                    Limited{{"bouc_wen", bouc_wen_law(), values({2e4, 0.3, 1.0, 200.0, 100.0, 1.0, 10.0}), 0,
                             [](double d, double v, double z, const VectorXd& p) {
                               return p[1] * p[0] * d + (1 - p[1]) * p[0] * z + p[6] * v;
                             },
                             [](double /*d*/, double v, double z, const VectorXd& p) {
                               return p[2] * v - p[3] * std::abs(v) * z - p[4] * v * std::abs(z);
                             }},
                            2.0,
                            2.6},
                    Limited{
                        {"maxwell", written("k*x + K*(x - z)", {"k", "K", "T"}, {{{"z", "m"}, "(x - z)/T"}}),
                         values({5e3, 1e4, 5e-3}), 1,
                         [](double d, double /*v*/, double z, const VectorXd& p) { return p[0] * d + p[1] * (d - z); },
                         [](double d, double /*v*/, double z, const VectorXd& p) { return (d - z) / p[2]; }},
                        2.8,
                        3.2}),
    [](const testing::TestParamInfo<Limited>& info) { return info.param.suspension.name; });

// ------------------------------------------------------------------------------------------- the embedded step

/// The chain with noise, through a filter with so many parts of that order.
EstimationResult run_chain(const ConvergedSolution& reference, int order, int substeps, bool step_shift = false) {
  const Chain chain;
  auto options = chain.options();
  options.substeps = substeps;
  options.step_order = order;
  const AugmentedModel model(chain.model.system(), chain.sensors, {}, options);
  auto record = Chain::record(reference, 5);
  record.inputs =
      chain.inputs(options.instants() * Chain::rate, options.instants() * (record.measured.samples() - 1) + 1);
  return estimate(model, record, {.state_deviations = false, .step_shift = step_shift});
}

TEST(StepShift, TellsWithinARunWhatTheStepOfOrderTwoAddsToTheEstimates) {
  const Chain chain;
  const auto reference = chain.reference(5.0);
  const auto four = run_chain(reference, 4, 1, true), two = run_chain(reference, 2, 2),
             fine = run_chain(reference, 2, 64);
  ASSERT_FALSE(four.failure || two.failure || fine.failure);
  for (Index i = 0; i < 2; ++i) {
    const double deviation = fine.unknowns.deviation.rightCols(1)(i, 0);
    const auto last = [&](const MatrixXd& of) { return of.rightCols(1)(i, 0) / deviation; };
    const double shift = last(four.step_shift), difference = last(two.unknowns.mean) - last(four.unknowns.mean);
    std::cout << "unknown " << i << ": order 2 with two parts lies " << difference
              << " standard deviations from order 4 with one, found within the run " << shift << "; order 4 lies "
              << last(four.unknowns.mean) - last(fine.unknowns.mean) << " from order 2 with 64 parts\n";
    EXPECT_LT(std::abs(last(four.unknowns.mean) - last(fine.unknowns.mean)), std::abs(shift) + 0.1);
    // It lacks what the changed motion within the interval does to the forces, and what the gains change: found 0.014.
    EXPECT_NEAR(shift, difference, 0.03);
  }
}

TEST(StepShift, IsFoundOnlyWhereItIsAskedFor) {
  const Chain chain;
  const auto reference = chain.reference(0.2);
  EXPECT_EQ(run_chain(reference, 4, 1).step_shift.size(), 0);
  EXPECT_EQ(run_chain(reference, 2, 1, true).step_shift.size(), 0);  // it has no embedded step
  EXPECT_EQ(run_chain(reference, 4, 1, true).step_shift.cols(), 201);
}

TEST(StepOrder, IsTwoOrFour) {
  const Chain chain;
  auto options = chain.options();
  options.step_order = 3;
  EXPECT_THROW(AugmentedModel(chain.model.system(), chain.sensors, {}, options), InvalidInput);
}

}  // namespace
}  // namespace kalfem
