// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/smoother/smoother.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "estimation/kalman_filter.hpp"
#include "estimation/linear_chain.hpp"
#include "kalfem/system/signals/deterministic.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct LinearChain : LinearChainModel {
  MatrixXd R = Eigen::Vector3d(0.04, 0.09, 1e-8).asDiagonal();

  [[nodiscard]] AugmentedModelOptions options() const {
    auto options = all_known(model.system(), h);
    options.prior.displacement_deviation.setConstant(1e-3);
    options.prior.velocity_deviation.setConstant(0.05);
    options.process_noise.acceleration.setConstant(0.5);
    return options;
  }
  [[nodiscard]] FilterInput record(const AugmentedModel& augmented_model, Index samples) const {
    const MatrixXd inputs =
        make_sine({.amplitude = 3e-3, .frequency = 6.0})->sample(0.0, h, samples).matrix().transpose();
    auto record = draw_record(closed_loop(augmented_model, R), augmented_model.prior(), inputs, 3);
    const double missing = std::numeric_limits<double>::quiet_NaN();
    record.measured.values.middleCols(100, 7).setConstant(missing);
    for (Index k = 200; k < 260; ++k) record.measured.values(k % 3, k) = missing;
    return record;
  }
};

/// Rauch, Tung and Striebel (1965): x_s = x + D (x_s+ - x-+), P_s = P + D (P_s+ - P-+) D^T, D = P Phi^T (P-+)^-1.
std::vector<Gaussian> rts_smoother(const LinearProblem& problem, const Gaussian& prior, const FilterInput& record) {
  const Index samples = record.measured.samples();
  std::vector<Gaussian> predicted, updated;
  KalmanFilter kalman{prior.mean, prior.covariance};
  for (Index k = 0; k < samples; ++k) {
    if (k > 0) kalman.predict(problem, problem.drive(record.inputs.col(k - 1), record.inputs.col(k)));
    predicted.push_back({kalman.x, kalman.P});
    kalman.update(problem, record.inputs.col(k), record.measured.values.col(k));
    updated.push_back({kalman.x, kalman.P});
  }
  auto smoothed = updated;
  for (auto k = static_cast<std::size_t>(samples) - 1; k-- > 0;) {
    const MatrixXd D = predicted[k + 1].covariance.ldlt().solve(problem.Phi * updated[k].covariance).transpose();
    smoothed[k].mean += D * (smoothed[k + 1].mean - predicted[k + 1].mean);
    smoothed[k].covariance += D * (smoothed[k + 1].covariance - predicted[k + 1].covariance) * D.transpose();
  }
  return smoothed;
}

class Smoother : public testing::TestWithParam<std::tuple<FilterKind, StateCoordinates>> {};

TEST_P(Smoother, IsTheRtsSmootherOnALinearChainWithMissingSamples) {
  const auto [kind, coordinates] = GetParam();
  const LinearChain chain;
  auto options = chain.options();
  const AugmentedModel physical(chain.model.system(), chain.sensors, {}, options);
  options.coordinates = coordinates;
  const AugmentedModel augmented_model(chain.model.system(), chain.sensors, {}, options);
  const Index samples = 400;
  const auto record = chain.record(physical, samples);
  const auto expected = rts_smoother(closed_loop(physical, chain.R), physical.prior(), record);
  const EstimationOptions run{.filter = kind, .monitored = chain.sensors};
  const auto filtered = estimate(augmented_model, record, run);
  // Little memory: segments of four samples, checkpoints between checkpoints.
  for (const double memory : {256e6, 0.0}) {
    const auto smoothed = smooth(augmented_model, record, run, filtered, {.memory = memory});
    ASSERT_TRUE(smoothed.has_value());
    double mean_error = 0.0, deviation_error = 0.0;
    for (Index k = 0; k < samples; ++k) {
      const auto& [mean, covariance] = expected[static_cast<std::size_t>(k)];
      const VectorXd deviation = covariance.diagonal().cwiseSqrt();
      mean_error =
          std::max(mean_error, ((smoothed->state.mean.col(k) - mean).array() / deviation.array()).abs().maxCoeff());
      deviation_error = std::max(deviation_error,
                                 (smoothed->state.deviation.col(k).array() / deviation.array() - 1.0).abs().maxCoeff());
    }
    EXPECT_LT(mean_error, 1e-9) << memory;
    EXPECT_LT(deviation_error, 1e-9) << memory;
    RecordProperty("mean_error", std::to_string(mean_error));
    // Monitored: the sensors' own outputs, smoothed.
    const auto problem = closed_loop(physical, chain.R);
    for (const Index k : {Index{0}, Index{103}, Index{399}}) {
      const auto& [mean, covariance] = expected[static_cast<std::size_t>(k)];
      const VectorXd outputs = problem.H * mean + problem.D * record.inputs.col(k);
      const VectorXd deviation = (problem.H * covariance * problem.H.transpose()).diagonal().cwiseSqrt();
      EXPECT_LT(((smoothed->monitored.mean.col(k) - outputs).array() / deviation.array()).abs().maxCoeff(), 1e-8);
      EXPECT_LT((smoothed->monitored.deviation.col(k).array() / deviation.array() - 1.0).abs().maxCoeff(), 1e-7);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Smoother,
                         testing::Values(std::tuple{FilterKind::unscented, StateCoordinates::physical},
                                         std::tuple{FilterKind::unscented_square_root, StateCoordinates::physical},
                                         std::tuple{FilterKind::extended, StateCoordinates::physical},
                                         std::tuple{FilterKind::partially_linear, StateCoordinates::physical},
                                         std::tuple{FilterKind::partially_linear, StateCoordinates::modal}));

}  // namespace
}  // namespace kalfem
