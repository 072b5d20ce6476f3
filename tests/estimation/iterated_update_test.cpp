// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/iterated_update.hpp"

#include <gtest/gtest.h>

#include "estimation/brute_force.hpp"
#include "kalfem/estimation/covariance_filter.hpp"

// Updates that linearise the measurement about their own posterior, against exact posteriors and against each other.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr FilterKind kinds[] = {FilterKind::unscented, FilterKind::unscented_square_root, FilterKind::partially_linear,
                                FilterKind::partially_linear_square_root, FilterKind::extended};

/// States in pairs, the form that the partially linear filter needs.
FunctionMap resting_process(RandomStream& random, Index n) {
  auto process = random_map(random, n, n, 3, 2, bent);
  process.linear = 0.9 * MatrixXd::Identity(n, n);
  for (Index i = 0; i + 1 < n; i += 2) process.linear(i, i + 1) = 0.1;
  process.gain *= 0.1;
  process.selection *= 0.2;
  return process;
}

Gaussian random_prior(RandomStream& random, Index n) {
  const MatrixXd root = random_matrix(random, n, n);
  return {random_matrix(random, n, 1), root * root.transpose() / double(n)};
}

Gaussian updated(FilterKind kind, const FilterModel& model, const Gaussian& prior, const VectorXd& y, int passes,
                 Innovation& innovation) {
  const auto filter = make_filter(kind, model, {.update_iterations = passes});
  filter->reset(prior);
  EXPECT_EQ(filter->update(y, innovation), FilterOutcome::usable);
  return {filter->mean(), filter->covariance()};
}

void expect_same(const Gaussian& found, const Gaussian& expected, double tolerance, FilterKind kind) {
  EXPECT_LE((found.mean - expected.mean).norm(), tolerance * expected.mean.norm()) << to_string(kind);
  EXPECT_LE((found.covariance - expected.covariance).norm(), tolerance * expected.covariance.norm()) << to_string(kind);
}

TEST(IteratedUpdate, OfALinearMeasurementIsThePlainOne) {
  RandomStream random(5, "linear measurement");
  auto process = resting_process(random, 6);
  auto measurement = random_map(random, 3, 6, 3, 2,
                                [](const VectorXd& w) { return VectorXd(Eigen::Vector2d(w[0] - 2.0 * w[1], w[2])); });
  const auto prior = random_prior(random, 6);
  const FilterModel model{process, MatrixXd::Zero(6, 6), measurement, 1e-4 * MatrixXd::Identity(3, 3)};
  const VectorXd y = random_matrix(random, 3, 1);
  for (const auto kind : kinds) {
    Innovation innovation;
    const auto once = updated(kind, model, prior, y, 1, innovation),
               often = updated(kind, model, prior, y, 5, innovation);
    // The extended filter takes slopes by differences.
    expect_same(often, once, kind == FilterKind::extended ? 1e-7 : 1e-10, kind);
  }
}

/// An accelerometer beside a stiff cubic connector: y = 2 w + 30 w^3 with little noise, w known to 0.25 about 0.5.
struct StiffConnector {
  RandomStream random{6, "stiff connector"};
  FunctionMap process = resting_process(random, 4);
  FunctionMap measurement{[](const VectorXd& w) { return VectorXd(VectorXd::Constant(1, 30.0 * std::pow(w[0], 3))); }};
  MatrixXd R = MatrixXd::Constant(1, 1, 0.04);
  Gaussian prior;
  VectorXd y = VectorXd::Constant(1, 2.0 * 0.8 + 30.0 * 0.512 + 0.1);

  StiffConnector() {
    measurement.selection = Eigen::RowVector4d(1.0, 0.0, -1.0, 0.0);
    measurement.linear = 2.0 * measurement.selection;
    measurement.gain = MatrixXd::Ones(1, 1);
    measurement.offset = VectorXd::Zero(1);
    measurement.input_offset = VectorXd::Zero(1);
    prior = random_prior(random, 4);
    const VectorXd direction = measurement.selection.transpose();
    prior.covariance *= 0.0625 / direction.dot(prior.covariance * direction);
    prior.mean += direction * (0.5 - direction.dot(prior.mean)) / direction.squaredNorm();
  }

  FilterModel model() { return {process, MatrixXd::Zero(4, 4), measurement, R}; }

  /// Mean and variance of w given y by quadrature, from which those of x follow, as x is normal given w.
  Gaussian exact() {
    const VectorXd N = measurement.selection.transpose(), cross = prior.covariance * N;
    const double m = N.dot(prior.mean), variance = N.dot(cross);
    double sum = 0.0, first = 0.0, second = 0.0;
    for (int i = -40000; i <= 40000; ++i) {
      const double w = m + std::sqrt(variance) * i * 2e-4, error = y[0] - 2.0 * w - 30.0 * w * w * w;
      const double density = std::exp(-0.5 * (w - m) * (w - m) / variance - 0.5 * error * error / R(0, 0));
      sum += density;
      first += density * w;
      second += density * w * w;
    }
    const double mean = first / sum, left = second / sum - mean * mean;
    return {prior.mean + cross * (mean - m) / variance,
            prior.covariance - cross * cross.transpose() * (variance - left) / (variance * variance)};
  }
};

TEST(IteratedUpdate, ComesNearTheExactPosteriorOfAStiffMeasurement) {
  StiffConnector setting;
  const Gaussian exact = setting.exact();
  const VectorXd N = setting.measurement.selection.transpose();
  const double mean = N.dot(exact.mean), deviation = std::sqrt(N.dot(exact.covariance * N));
  for (const auto kind : kinds) {
    Innovation innovation;
    const auto once = updated(kind, setting.model(), setting.prior, setting.y, 1, innovation),
               often = updated(kind, setting.model(), setting.prior, setting.y, 5, innovation);
    const auto error = [&](const Gaussian& found) { return std::abs(N.dot(found.mean) - mean) / deviation; };
    const auto spread = [&](const Gaussian& found) { return std::sqrt(N.dot(found.covariance * N)) / deviation; };
    EXPECT_GT(error(once), 5.0) << to_string(kind);
    EXPECT_LT(error(often), 0.1) << to_string(kind);
    EXPECT_NEAR(spread(often), 1.0, 0.05) << to_string(kind);
    EXPECT_GT(std::abs(spread(once) - 1.0), 0.3) << to_string(kind);
    // Every state, not only the one that the connector feels.
    const double least = 0.1 * (once.mean - exact.mean).norm();
    EXPECT_LT((often.mean - exact.mean).norm(), least) << to_string(kind);
  }
}

TEST(IteratedUpdate, LeavesThePredictionsScoreAndTellsWhatItConditionedOn) {
  StiffConnector setting;
  for (const auto kind : kinds) {
    Innovation once, often;
    updated(kind, setting.model(), setting.prior, setting.y, 1, once);
    const auto filter = make_filter(kind, setting.model(), {.update_iterations = 5});
    filter->reset(setting.prior);
    ASSERT_EQ(filter->update(setting.y, often), FilterOutcome::usable);
    EXPECT_EQ(often.nis, once.nis);
    EXPECT_EQ(often.value, once.value);
    EXPECT_FALSE(once.relinearised);
    ASSERT_TRUE(often.relinearised) << to_string(kind);
    const VectorXd moved = filter->gain() * often.conditioned_value();
    EXPECT_LT((setting.prior.mean + moved - filter->mean()).norm(), 1e-10) << to_string(kind);
    const MatrixXd S = often.conditioned_covariance().selfadjointView<Eigen::Lower>();
    const MatrixXd left = setting.prior.covariance - filter->gain() * S * filter->gain().transpose();
    EXPECT_LT((left - filter->covariance()).norm(), 1e-9) << to_string(kind);
  }
}

TEST(IteratedUpdate, OfThePartiallyLinearFilterIsThatOfTheDenseOne) {
  RandomStream random(7, "partially linear");
  auto process = resting_process(random, 12);
  auto measurement = random_map(random, 3, 12, 3, 2, bent);
  measurement.selection *= 0.3;
  const MatrixXd Q = 0.01 * MatrixXd::Identity(12, 12), R = 0.05 * MatrixXd::Identity(3, 3);
  const auto prior = random_prior(random, 12);
  const auto tiled = make_filter(FilterKind::partially_linear, {process, Q, measurement, R}, {.update_iterations = 4});
  CovarianceFilter dense({process, Q, measurement, R}, UnscentedTransform({.points = SigmaPoints::of_arguments}));
  CovarianceFilter plain({process, Q, measurement, R}, UnscentedTransform({.points = SigmaPoints::of_arguments}));
  dense.iterate_updates(4);
  for (Filter* filter : {tiled.get(), static_cast<Filter*>(&dense), static_cast<Filter*>(&plain)}) filter->reset(prior);
  double moved = 0.0;
  for (int k = 0; k < 20; ++k) {
    VectorXd y = measurement(prior.mean) + random_matrix(random, 3, 1);
    if (k % 3 == 1) y[1] = NAN;
    Innovation innovation;
    for (Filter* filter : {tiled.get(), static_cast<Filter*>(&dense), static_cast<Filter*>(&plain)}) {
      ASSERT_EQ(filter->predict(), FilterOutcome::usable);
      ASSERT_EQ(filter->update(y, innovation), FilterOutcome::usable);
    }
    const VectorXd deviation = dense.standard_deviation();
    EXPECT_LT(((tiled->mean() - dense.mean()).array() / deviation.array()).abs().maxCoeff(), 1e-9) << k;
    EXPECT_LT((tiled->covariance() - dense.covariance()).norm(), 1e-9 * dense.covariance().norm()) << k;
    moved = std::max(moved, ((plain.mean() - dense.mean()).array() / deviation.array()).abs().maxCoeff());
  }
  EXPECT_GT(moved, 0.1);
}

TEST(IteratedUpdate, TreatsOutliersAsAPlainOne) {
  RandomStream random(8, "outliers");
  auto process = resting_process(random, 6);
  auto measurement = random_map(random, 3, 6, 3, 2, bent);
  measurement.selection *= 0.3;
  const MatrixXd R = 0.05 * MatrixXd::Identity(3, 3);
  const FilterModel model{process, MatrixXd::Zero(6, 6), measurement, R};
  const auto prior = random_prior(random, 6);
  VectorXd y = measurement(prior.mean);
  VectorXd missing = y;
  missing[1] = NAN;
  y[1] += 1e3;
  for (const auto kind : kinds) {
    Innovation innovation;
    const auto expected = updated(kind, model, prior, missing, 4, innovation);
    const auto gated = make_filter(kind, model, {.update_iterations = 4});
    gated->treat_outliers({OutlierTreatment::gate});
    gated->reset(prior);
    ASSERT_EQ(gated->update(y, innovation), FilterOutcome::usable);
    ASSERT_EQ(innovation.set_aside.size(), 1U);
    EXPECT_EQ(innovation.set_aside[0].channel, 1);
    expect_same({gated->mean(), gated->covariance()}, expected, 1e-12, kind);

    const auto robust = make_filter(kind, model, {.update_iterations = 4});
    robust->treat_outliers({OutlierTreatment::robust});
    robust->reset(prior);
    ASSERT_EQ(robust->update(y, innovation), FilterOutcome::usable);
    ASSERT_EQ(innovation.added_variance.size(), 3);
    FilterModel wider = model;
    wider.measurement_noise.diagonal() += innovation.added_variance;
    expect_same({robust->mean(), robust->covariance()}, updated(kind, wider, prior, y, 4, innovation), 1e-9, kind);
  }
}

/// A measurement that cannot be evaluated away from the prior.
TEST(IteratedUpdate, KeepsThePassBeforeOneThatFails) {
  StiffConnector setting;
  const double m = setting.measurement.selection.row(0).dot(setting.prior.mean);
  FunctionMap broken([&](const VectorXd& w) {
    return VectorXd(VectorXd::Constant(1, std::abs(w[0] - m) > 0.7 ? NAN : 0.1 * std::pow(w[0], 3)));
  });
  for (auto [to, from] :
       {std::pair{&broken.selection, &setting.measurement.selection},
        std::pair{&broken.linear, &setting.measurement.linear}, std::pair{&broken.gain, &setting.measurement.gain}})
    *to = *from;
  broken.offset = broken.input_offset = VectorXd::Zero(1);
  const FilterModel model{setting.process, MatrixXd::Zero(4, 4), broken, setting.R};
  const VectorXd far = VectorXd::Constant(1, 30.0);
  for (const auto kind : kinds) {
    Innovation innovation;
    const auto once = updated(kind, model, setting.prior, far, 1, innovation);
    expect_same(updated(kind, model, setting.prior, far, 5, innovation), once, 1e-10, kind);
  }
}

}  // namespace
}  // namespace kalfem
