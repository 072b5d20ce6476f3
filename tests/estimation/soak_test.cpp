// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <iostream>

#include "base/figures.hpp"
#include "estimation/chain_model.hpp"
#include "kalfem/estimation/process_model.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index period = 20000;  ///< samples after which the road comes again

/// The chain as the augmented model models it, with the true parameters and with process noise of the augmented model's
/// covariance.
class TrueChain {
public:
  TrueChain(const AugmentedModel& augmented_model, const VectorXd& unknowns)
      : transition_(augmented_model), outputs_(augmented_model, sensor_outputs), random_(11, "soak") {
    state_ = VectorXd::Zero(augmented_model.layout().size());
    state_.tail(unknowns.size()) = unknowns;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(augmented_model.process_noise());
    noise_root_ = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  }

  void move(const VectorXd& begin, const VectorXd& end) {
    transition_.set_inputs(begin, end);
    state_ = image(transition_);
    for (auto& value : noise_) value = random_.normal();
    state_ += noise_root_ * noise_;
  }
  VectorXd measured(const VectorXd& inputs, double deviation) {
    outputs_.set_inputs(inputs);
    VectorXd y = image(outputs_);
    for (auto& value : y) value += deviation * random_.normal();
    return y;
  }

private:
  VectorXd image(PartiallyLinearMap& map) {
    const Eigen::ArrayXXd in = (map.selection() * state_ + map.input_offset()).transpose().array();
    Eigen::ArrayXXd out(1, map.gain().cols());
    EXPECT_TRUE(map.evaluate(in, out));
    return map.linear() * state_ + map.gain() * out.matrix().transpose() + map.offset();
  }

  ProcessModel transition_;
  MeasurementModel outputs_;
  RandomStream random_;
  VectorXd state_, noise_ = VectorXd::Zero(24);
  MatrixXd noise_root_;
};

/// Ten million steps, 2.8 hours at 1 kHz, with unknowns that may drift: no loss of definiteness, estimates in their
/// bands.
TEST(Soak, TenMillionStepsOfTheChain) {
  const Chain chain;
  auto options = chain.options();
  options.coordinates = StateCoordinates::modal;
  options.process_noise.acceleration.setConstant(0.02);
  const AugmentedModel augmented_model(chain.model.system(), chain.sensors, {}, options);
  const VectorXd truth = values({std::log(Chain::mu_k1), std::log(Chain::mu_c1)});
  const auto road = make_random({.rms = 3e-3, .lower = 0.5, .upper = 30.0, .duration = 20.0, .seed = 7});
  const MatrixXd inputs = road->sample(0.0, 1e-3, period).matrix().transpose();
  const double deviation = 0.5;
  const MatrixXd noise = deviation * deviation * MatrixXd::Identity(4, 4);

  TrueChain structure(augmented_model, truth);
  ProcessModel transition(augmented_model);
  MeasurementModel measurement(augmented_model, sensor_outputs);
  const auto filter =
      make_filter(FilterKind::partially_linear, {transition, augmented_model.process_noise(), measurement, noise});
  filter->reset(augmented_model.prior());
  Innovation innovation;
  double nis = 0.0, lowest = 1.0, worst = 0.0;
  const Index steps = 10'000'000, look = 100'000;
  for (Index k = 1; k <= steps; ++k) {
    const VectorXd begin = inputs.col((k - 1) % period), end = inputs.col(k % period);
    structure.move(begin, end);
    transition.set_inputs(begin, end);
    ASSERT_EQ(filter->predict(), FilterOutcome::usable) << k;
    measurement.set_inputs(end);
    ASSERT_EQ(filter->update(structure.measured(end, deviation), innovation), FilterOutcome::usable) << k;
    nis += innovation.nis / double(steps);
    if (k % look != 0) continue;
    const MatrixXd covariance = filter->covariance();
    ASSERT_TRUE(covariance.allFinite()) << k;
    EXPECT_TRUE(covariance == covariance.transpose()) << k;
    const VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
    lowest = std::min(lowest, correlation.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff());
    const VectorXd error = (filter->mean().tail(2) - truth).cwiseQuotient(filter->standard_deviation().tail(2));
    worst = std::max(worst, error.cwiseAbs().maxCoeff());
  }
  const VectorXd last = filter->standard_deviation().tail(2);
  std::cout << steps << " steps: mean NIS " << nis << " (4 expected), lowest eigenvalue of the correlation matrix "
            << lowest << ", worst error of an unknown " << worst << " standard deviations in " << steps / look
            << " looks, relative standard deviations at the end " << last.transpose() << "\n";
  test::expect_figure("soak.nis", nis);
  test::expect_figure("soak.lowest_eigenvalue", lowest);
  test::expect_figure("soak.worst_error", worst);
  EXPECT_GT(lowest, 0.0);
  EXPECT_LT(worst, 4.5);
  EXPECT_NEAR(nis, 4.0, 0.01);
}

}  // namespace
}  // namespace kalfem
