// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "estimation/kalman_filter.hpp"
#include "estimation/linear_chain.hpp"
#include "kalfem/statistics/quantiles.hpp"
#include "kalfem/system/signals/deterministic.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double h = LinearChainModel::h;

struct LinearChain : LinearChainModel {
  MatrixXd R = Eigen::Vector3d(0.04, 0.09, 1e-8).asDiagonal();

  [[nodiscard]] AugmentedModelOptions options() const {
    auto options = all_known(model.system(), h);
    options.prior.displacement_deviation.setConstant(1e-3);
    options.prior.velocity_deviation.setConstant(0.05);
    options.prior.mean.displacement << 1e-3, -2e-3, 0.0;
    options.process_noise.acceleration.setConstant(0.5);
    return options;
  }
  [[nodiscard]] MatrixXd inputs(Index samples) const {
    return make_sine({.amplitude = 3e-3, .frequency = 6.0})->sample(0.0, h, samples).matrix().transpose();
  }
};

class EqualsTheKalmanFilter : public testing::TestWithParam<FilterKind> {};

TEST_P(EqualsTheKalmanFilter, OnALinearChainWithMissingSamples) {
  const LinearChain chain;
  const AugmentedModel augmented_model(chain.model.system(), chain.sensors, {}, chain.options());
  const auto problem = closed_loop(augmented_model, chain.R);
  const Index samples = 400;
  auto record = draw_record(problem, augmented_model.prior(), chain.inputs(samples), 3);
  const double missing = std::numeric_limits<double>::quiet_NaN();
  record.measured.values.middleCols(100, 7).setConstant(missing);
  for (Index k = 200; k < 260; ++k) record.measured.values(k % 3, k) = missing;

  const auto result = estimate(augmented_model, record, {.filter = GetParam()});
  ASSERT_FALSE(result.failure) << result.failure->reason;
  KalmanFilter kalman{augmented_model.prior().mean, augmented_model.prior().covariance};
  double mean_error = 0.0, deviation_error = 0.0, nis_error = 0.0;
  for (Index k = 0; k < samples; ++k) {
    if (k > 0) kalman.predict(problem, problem.drive(record.inputs.col(k - 1), record.inputs.col(k)));
    kalman.update(problem, record.inputs.col(k), record.measured.values.col(k));
    const VectorXd deviation = kalman.P.diagonal().cwiseSqrt();
    mean_error =
        std::max(mean_error, ((result.state.mean.col(k) - kalman.x).array() / deviation.array()).abs().maxCoeff());
    deviation_error =
        std::max(deviation_error, (result.state.deviation.col(k).array() / deviation.array() - 1.0).abs().maxCoeff());
    if (result.measured[k] > 0)
      nis_error = std::max(nis_error, std::abs(result.nis[k] - kalman.nis) / (1.0 + kalman.nis));
  }
  // Rounding through a few hundred steps, in standard deviations; the linearised form takes differences of 1e-4 of one.
  const double tolerance = GetParam() == FilterKind::extended ? 2e-9 : 5e-10;  // found 1e-10 and 3e-11
  EXPECT_LT(mean_error, tolerance);
  EXPECT_LT(deviation_error, tolerance);
  EXPECT_LT(nis_error, tolerance);
  EXPECT_LT((result.final_covariance - kalman.P).norm(), tolerance * kalman.P.norm());
  EXPECT_NEAR(result.log_likelihood, kalman.log_likelihood, 1e-2 * tolerance * std::abs(kalman.log_likelihood));
  EXPECT_EQ(result.measured[100], 0);
  EXPECT_TRUE(std::isnan(result.nis[103]));
  EXPECT_EQ(result.measured[210], 2);
  EXPECT_TRUE(std::isnan(result.innovation(0, 210)) && std::isfinite(result.innovation(1, 210)));
}

INSTANTIATE_TEST_SUITE_P(Kinds, EqualsTheKalmanFilter,
                         testing::Values(FilterKind::unscented, FilterKind::unscented_square_root,
                                         FilterKind::extended));

/// Runs the mean with the gains that a filter had: the means of that filter, also where a channel is missing.
TEST(FixedGains, RepeatTheMeansOfTheFilterThatTheyAreOf) {
  const LinearChain chain;
  const AugmentedModel augmented_model(chain.model.system(), chain.sensors, {}, chain.options());
  const Index samples = 400;
  auto record = draw_record(closed_loop(augmented_model, chain.R), augmented_model.prior(), chain.inputs(samples), 3);
  record.measured.values(1, 120) = std::numeric_limits<double>::quiet_NaN();
  record.measured.values.col(300).setConstant(std::numeric_limits<double>::quiet_NaN());
  for (const auto kind : {FilterKind::unscented, FilterKind::unscented_square_root, FilterKind::partially_linear}) {
    const auto result =
        estimate(augmented_model, record, {.filter = kind, .keep_gains = true, .monitored = chain.sensors});
    ASSERT_EQ(std::ssize(result.gains), samples);
    EXPECT_TRUE(result.gains[120].col(1).isZero(0.0));
    const auto means = run_with_gains(augmented_model, record, result.gains, chain.sensors, samples - 1);
    ASSERT_TRUE(means.has_value());
    const VectorXd last = result.state.mean.col(samples - 1);
    EXPECT_LT((means->state - last).norm(), 1e-10 * last.norm()) << to_string(kind);
    EXPECT_LT((means->monitored - result.monitored.mean).norm(), 1e-10 * result.monitored.mean.norm())
        << to_string(kind);
  }
}

/// Mean and covariance of [x(0); y(0); ...; y(T)] of the linear problem, written out from its definition.
Gaussian joint_of_start_and_record(const LinearProblem& problem, const Gaussian& prior, const MatrixXd& inputs) {
  const Index n = problem.Phi.rows(), l = problem.H.rows(), samples = inputs.cols();
  MatrixXd state = MatrixXd::Zero(n, n * samples);  // x(k) per [x(0), w(1), ..., w(T)]
  state.leftCols(n).setIdentity();
  VectorXd mean = prior.mean;
  MatrixXd rows = MatrixXd::Zero(n + l * samples, n * samples);
  Gaussian joint{VectorXd(n + l * samples), {}};
  rows.topRows(n) = state;
  joint.mean.head(n) = prior.mean;
  for (Index k = 0; k < samples; ++k) {
    if (k > 0) {
      mean = problem.Phi * mean + problem.drive(inputs.col(k - 1), inputs.col(k));
      state = (problem.Phi * state).eval();
      state.middleCols(n * k, n).setIdentity();
    }
    rows.middleRows(n + l * k, l) = problem.H * state;
    joint.mean.segment(n + l * k, l) = problem.H * mean + problem.D * inputs.col(k);
  }
  MatrixXd sources = MatrixXd::Zero(n * samples, n * samples);
  for (Index k = 0; k < samples; ++k) sources.block(n * k, n * k, n, n) = k == 0 ? prior.covariance : problem.Q;
  joint.covariance = rows * sources * rows.transpose();
  for (Index k = 0; k < samples; ++k) joint.covariance.block(n + l * k, n + l * k, l, l) += problem.R;
  return joint;
}

TEST(LinearRecord, LikelihoodAndSmoothedStartAreThoseOfTheJointNormal) {
  const LinearChain chain;
  auto options = chain.options();
  const AugmentedModel plain(chain.model.system(), chain.sensors, {}, options);
  options.keep_initial_state = true;
  const AugmentedModel augmented_model(chain.model.system(), chain.sensors, {}, options);
  ASSERT_EQ(augmented_model.layout().size(), 12);
  const auto problem = closed_loop(plain, chain.R);
  const Index samples = 12, n = 6;
  const auto record = draw_record(problem, plain.prior(), chain.inputs(samples), 5);

  const auto joint = joint_of_start_and_record(problem, plain.prior(), record.inputs);
  const Index count = joint.mean.size() - n;
  const VectorXd residual = record.measured.values.reshaped() - joint.mean.tail(count);
  const Eigen::LLT<MatrixXd> factor(joint.covariance.bottomRightCorner(count, count));
  const double log_determinant = 2.0 * MatrixXd(factor.matrixL()).diagonal().array().log().sum();
  const double log_density =
      -0.5 * (residual.dot(factor.solve(residual)) + log_determinant + double(count) * std::log(2 * std::numbers::pi));
  const MatrixXd cross = joint.covariance.topRightCorner(n, count);
  const VectorXd start = plain.prior().mean + cross * factor.solve(residual);
  const MatrixXd covariance = plain.prior().covariance - cross * factor.solve(cross.transpose());

  for (const auto kind : {FilterKind::unscented, FilterKind::unscented_square_root}) {
    const auto result = estimate(augmented_model, record, {.filter = kind});
    ASSERT_FALSE(result.failure) << result.failure->reason;
    // rounding of a sum of thousands of squares
    EXPECT_NEAR(result.log_likelihood, log_density, 1e-11 * std::abs(log_density));
    const VectorXd deviation = covariance.diagonal().cwiseSqrt();
    const auto smoothed = result.state.mean.col(samples - 1).segment(augmented_model.layout().initial_state(), n);
    // in standard deviations, found 4e-11: the covariance of the joint state loses digits
    EXPECT_LT(((smoothed - start).array() / deviation.array()).abs().maxCoeff(), 1e-9);
    EXPECT_LT((result.final_covariance.bottomRightCorner(n, n) - covariance).norm(), 1e-9 * covariance.norm());
  }
}

TEST(LinearRecord, SmoothedStartIsTheGaussMarkovEstimateOfALongRecord) {
  const LinearChain chain;
  auto options = chain.options();
  options.process_noise.acceleration.setZero();
  const AugmentedModel plain(chain.model.system(), chain.sensors, {}, options);
  options.keep_initial_state = true;
  const AugmentedModel augmented_model(chain.model.system(), chain.sensors, {}, options);
  const auto problem = closed_loop(plain, chain.R);
  const Index samples = 400, n = 6;
  const auto record = draw_record(problem, plain.prior(), chain.inputs(samples), 6);
  MatrixXd information = plain.prior().covariance.inverse(), power = MatrixXd::Identity(n, n);
  VectorXd error_indicators = information * plain.prior().mean, forced = VectorXd::Zero(n);
  for (Index k = 0; k < samples; ++k) {
    if (k > 0) {
      power = (problem.Phi * power).eval();
      forced = (problem.Phi * forced + problem.drive(record.inputs.col(k - 1), record.inputs.col(k))).eval();
    }
    const MatrixXd weighted = (problem.H * power).transpose() * problem.R.inverse();
    information += weighted * problem.H * power;
    error_indicators +=
        weighted * (record.measured.values.col(k) - problem.D * record.inputs.col(k) - problem.H * forced);
  }
  const MatrixXd covariance = information.inverse();
  const VectorXd start = covariance * error_indicators;
  for (const auto kind : {FilterKind::unscented, FilterKind::unscented_square_root}) {
    const auto result = estimate(augmented_model, record, {.filter = kind});
    ASSERT_FALSE(result.failure) << result.failure->reason;
    const auto smoothed = result.state.mean.col(samples - 1).segment(augmented_model.layout().initial_state(), n);
    // The covariance of [x; x(0)] is singular without process noise: directions of relative variance 1e-13 are dropped.
    // found 3e-10
    EXPECT_LT(((smoothed - start).array() / covariance.diagonal().cwiseSqrt().array()).abs().maxCoeff(), 1e-8);
    EXPECT_LT((result.final_covariance.bottomRightCorner(n, n) - covariance).norm(), 1e-8 * covariance.norm());
  }
}

TEST(LinearRecord, NisAndErrorsOfManyRecordsAreChiSquared) {
  const LinearChain chain;
  const AugmentedModel augmented_model(chain.model.system(), chain.sensors, {}, chain.options());
  const auto problem = closed_loop(augmented_model, chain.R);
  const Index samples = 250, seeds = 40;
  double sum = 0.0;
  for (Index seed = 0; seed < seeds; ++seed) {
    const auto record = draw_record(problem, augmented_model.prior(), chain.inputs(samples), 100 + std::uint64_t(seed));
    const auto result = estimate(augmented_model, record, {});
    ASSERT_FALSE(result.failure);
    sum += result.nis.sum();
  }
  const double freedoms = double(3 * samples * seeds);  // innovations of a linear Gaussian problem are independent
  EXPECT_GT(sum, chi_squared_quantile(0.001, freedoms));
  EXPECT_LT(sum, chi_squared_quantile(0.999, freedoms));
}

TEST(ProcessNoise, IsIndependentOfTheSamplingRate) {
  const LinearChain chain;
  auto options = chain.options();
  options.unknowns = {{"k", "N/m", {{0, 0}}, {TransformKind::log}, 4e3, 500.0, 30.0}};
  const AugmentedModel fine(chain.model.system(), chain.sensors, {}, options);
  options.step = 2 * h;
  const AugmentedModel coarse(chain.model.system(), chain.sensors, {}, options);
  const MatrixXd Q = fine.process_noise().topLeftCorner(6, 6), A = fine.step().nodes.back().transition;
  const MatrixXd twice = A * Q * A.transpose() + Q;
  EXPECT_LT((coarse.process_noise().topLeftCorner(6, 6) - twice).norm(), 2e-15 * twice.norm());  // rounding
  EXPECT_NEAR(coarse.process_noise()(6, 6), 2 * h * 30.0 * 30.0 / (4e3 * 4e3), 1e-20);           // log: relative drift
  EXPECT_NEAR(fine.process_noise()(6, 6), h * 30.0 * 30.0 / (4e3 * 4e3), 1e-20);
}

TEST(ProcessNoise, EstimatesDoNotDependOnSamplesThatAreMissing) {
  // Linear without connectors, forces straight between the coarse samples: half the steps give the same estimates.
  const auto model = quarter_chain(2, {}, {{"F", InputKind::force, "body.1"}});
  const auto sensors = make_outputs(model, {Chain::acceleration("2")});
  auto options = all_known(model.system(), h);
  options.prior.displacement_deviation.setConstant(1e-3);
  options.prior.velocity_deviation.setConstant(0.05);
  options.process_noise.acceleration.setConstant(0.5);
  const AugmentedModel coarse(model.system(), sensors, {}, options);
  options.step = h / 2;
  const AugmentedModel fine(model.system(), sensors, {}, options);
  const Index samples = 300;
  RandomStream random(9, "forces");
  FilterInput record{{.values = MatrixXd(1, samples)}, MatrixXd::Zero(3, samples), MatrixXd::Constant(1, 1, 0.04)};
  for (Index k = 0; k < samples; ++k)
    record.inputs(0, k) = 5.0 * random.normal(), record.measured.values(0, k) = random.normal();
  FilterInput dense{
      {.values = MatrixXd::Constant(1, 2 * samples - 1, NAN)}, MatrixXd::Zero(3, 2 * samples - 1), record.noise};
  for (Index k = 0; k < samples; ++k) {
    dense.measured.values(0, 2 * k) = record.measured.values(0, k);
    dense.inputs(0, 2 * k) = record.inputs(0, k);
    if (k > 0) dense.inputs(0, 2 * k - 1) = 0.5 * (record.inputs(0, k - 1) + record.inputs(0, k));
  }
  const auto a = estimate(coarse, record, {}), b = estimate(fine, dense, {});
  const MatrixXd at_samples = b.state.mean(Eigen::all, Eigen::seq(0, Eigen::last, 2));
  // The free body's position is seen through accelerations only, so rounding of the covariance gathers in it.
  EXPECT_LT((at_samples - a.state.mean).norm(), 1e-8 * a.state.mean.norm());
  EXPECT_LT((b.final_covariance - a.final_covariance).norm(), 2e-10 * a.final_covariance.norm());
  // found 1.3e-10
  EXPECT_NEAR(a.log_likelihood, b.log_likelihood, 1e-9 * std::abs(a.log_likelihood));
}

}  // namespace
}  // namespace kalfem
