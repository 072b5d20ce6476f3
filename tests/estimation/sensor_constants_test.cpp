// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "estimation/kalman_filter.hpp"
#include "estimation/linear_chain.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/signals/deterministic.hpp"

// Unknown constants in the channels of sensors: zeros of transducers, rest positions.
namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A chain with an unknown constant in its displacement sensor and one that two accelerometers share.
struct ChainWithConstants : LinearChainModel {
  MatrixXd R = Eigen::Vector3d(0.04, 0.09, 1e-8).asDiagonal();

  [[nodiscard]] AugmentedModelOptions options() const {
    auto options = all_known(model.system(), h);
    options.prior.displacement_deviation.setConstant(1e-3);
    options.prior.velocity_deviation.setConstant(0.05);
    options.process_noise.acceleration.setConstant(0.5);
    UnknownParameter zero{"zero", "m", {}, {}, 1e-3, 5e-3, 0.0};
    zero.sensors = {2};
    UnknownParameter bias{"bias", "m/s^2", {}, {}, 0.0, 0.4, 0.0};
    bias.sensors = {0, 1};
    options.unknowns = {zero, bias};
    return options;
  }
};

/// [x; b] with b constant, y = H x + E b.
LinearProblem augmented(const LinearProblem& problem, const MatrixXd& E) {
  const Index n = problem.Phi.rows(), b = E.cols();
  LinearProblem with = problem;
  with.Phi = MatrixXd::Identity(n + b, n + b);
  with.Phi.topLeftCorner(n, n) = problem.Phi;
  with.Q = MatrixXd::Zero(n + b, n + b);
  with.Q.topLeftCorner(n, n) = problem.Q;
  for (MatrixXd* gain : {&with.begin, &with.end}) {
    const MatrixXd of_states = *gain;
    *gain = MatrixXd::Zero(n + b, of_states.cols());
    gain->topRows(n) = of_states;
  }
  with.H.resize(E.rows(), n + b);
  with.H << problem.H, E;
  return with;
}

class SensorConstants : public testing::TestWithParam<FilterKind> {};

TEST_P(SensorConstants, AreEstimatedAsTheKalmanFilterDoes) {
  const ChainWithConstants chain;
  const AugmentedModel augmented_model(chain.model.system(), chain.sensors, {}, chain.options());
  const MatrixXd E = (MatrixXd(3, 2) << 0, 1, 0, 1, 1, 0).finished();
  const auto problem = augmented(closed_loop(augmented_model, chain.R), E);
  const Index samples = 300;
  const MatrixXd inputs =
      make_sine({.amplitude = 3e-3, .frequency = 6.0})->sample(0.0, chain.h, samples).matrix().transpose();
  const auto record = draw_record(problem, augmented_model.prior(), inputs, 3);
  const auto result = estimate(augmented_model, record, {.filter = GetParam()});
  ASSERT_FALSE(result.failure) << result.failure->reason;
  KalmanFilter kalman{augmented_model.prior().mean, augmented_model.prior().covariance};
  double mean_error = 0.0, deviation_error = 0.0;
  for (Index k = 0; k < samples; ++k) {
    if (k > 0) kalman.predict(problem, problem.drive(record.inputs.col(k - 1), record.inputs.col(k)));
    kalman.update(problem, record.inputs.col(k), record.measured.values.col(k));
    const VectorXd deviation = kalman.P.diagonal().cwiseSqrt();
    mean_error =
        std::max(mean_error, ((result.state.mean.col(k) - kalman.x).array() / deviation.array()).abs().maxCoeff());
    deviation_error =
        std::max(deviation_error, (result.state.deviation.col(k).array() / deviation.array() - 1.0).abs().maxCoeff());
  }
  // As for the chain without constants (linear_filter_test).
  const double tolerance = GetParam() == FilterKind::extended ? 5e-9 : 1e-9;  // found 3e-10 and 6e-11
  EXPECT_LT(mean_error, tolerance);
  EXPECT_LT(deviation_error, tolerance);
  EXPECT_NEAR(result.log_likelihood, kalman.log_likelihood, 1e-2 * tolerance * std::abs(kalman.log_likelihood));
  // they are learned: found 1.3e-4
  EXPECT_LT(result.unknowns.deviation(0, samples - 1), 3e-4);
}

INSTANTIATE_TEST_SUITE_P(Kinds, SensorConstants,
                         testing::Values(FilterKind::unscented, FilterKind::unscented_square_root, FilterKind::extended,
                                         FilterKind::partially_linear, FilterKind::partially_linear_square_root));

TEST(SensorConstantsOptions, RefuseWhatIsNoConstantOfASensor) {
  const ChainWithConstants chain;
  const auto made = [&](const auto& change) {
    auto options = chain.options();
    change(options.unknowns.front());
    return AugmentedModel(chain.model.system(), chain.sensors, {}, options).layout().unknowns;
  };
  EXPECT_EQ(made([](UnknownParameter&) {}), 2);
  EXPECT_THROW(made([](UnknownParameter& unknown) { unknown.sensors = {3}; }), InvalidInput);
  EXPECT_THROW(made([](UnknownParameter& unknown) { unknown.targets = {{0, 0}}; }), InvalidInput);
  EXPECT_THROW(made([](UnknownParameter& unknown) { unknown.transform.kind = TransformKind::log; }), InvalidInput);
  EXPECT_THROW(made([](UnknownParameter& unknown) { unknown.sensors.clear(); }), InvalidInput);
}

}  // namespace
}  // namespace kalfem
