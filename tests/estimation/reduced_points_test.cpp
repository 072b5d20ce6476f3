// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "estimation/brute_force.hpp"
#include "estimation/kalman_filter.hpp"
#include "estimation/linear_chain.hpp"
#include "kalfem/estimation/process_model.hpp"
#include "kalfem/system/signals/deterministic.hpp"

// Sigma points of the channels w = N x + e alone: equal to those of the state wherever both must be exact.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Mean, covariance and cross covariance S D^T of the transform, and its scatter.
struct Transformed : Moments {
  MatrixXd scatter;
};

Transformed transformed(PartiallyLinearMap& map, const VectorXd& m, const MatrixXd& S, UnscentedOptions options,
                        SigmaPoints points) {
  options.points = points;
  UnscentedTransform transform(options);
  EXPECT_TRUE(transform.apply(map, m, S));
  const Index n_y = map.linear().rows();
  MatrixXd covariance = MatrixXd::Zero(n_y, n_y);
  transform.add_covariance(map, covariance);
  return {{transform.mean(), covariance.selfadjointView<Eigen::Lower>(), S * transform.deviations().transpose()},
          transform.scatter()};
}

/// To a part of the size, which is rounding wherever the points are the same.
void expect_equal(const Moments& found, const Moments& expected, double tolerance) {
  EXPECT_LT((found.mean - expected.mean).norm(), tolerance * expected.mean.norm());
  EXPECT_LT((found.covariance - expected.covariance).norm(), tolerance * expected.covariance.norm());
  EXPECT_LT((found.cross - expected.cross).norm(), tolerance * expected.cross.norm());
}

/// A triangular root whose channels stand in the order in which a pivoted factorisation would take them, too.
MatrixXd ordered_root(RandomStream& random) {
  Eigen::Matrix3d correlation;
  correlation << 1.0, 0.1, 0.6, 0.1, 1.0, 0.3, 0.6, 0.3, 1.0;
  const Eigen::Vector3d scale(1.5 + random.uniform(), 1.0 + 0.3 * random.uniform(), 0.5 + 0.3 * random.uniform());
  return Eigen::LLT<MatrixXd>(scale.asDiagonal() * correlation * scale.asDiagonal()).matrixL();
}

/// Three channels of a normal x of covariance S S^T with this root.
MatrixXd channels_with_root(const MatrixXd& root, const MatrixXd& any, const MatrixXd& S) {
  const MatrixXd L = Eigen::LLT<MatrixXd>((any * S) * (any * S).transpose()).matrixL();
  return root * L.inverse() * any;
}

// ------------------------------------------------------------------------------------------- phi linear in w

/// How the channels stand to each other.
enum class Channels { independent, dependent, repeated, without_variance, more_than_states };

class LinearInTheChannels : public testing::TestWithParam<Channels> {};

TEST_P(LinearInTheChannels, EqualsThePointsOfTheState) {
  RandomStream random(11, "linear channels");
  for (const auto& options : {UnscentedOptions{}, UnscentedOptions{0.5, 2.0, 0.0}, UnscentedOptions{1.0, 0.0, 3.0}})
    for (int trial = 0; trial < 20; ++trial) {
      const Index n = 6 + trial % 3, q = GetParam() == Channels::more_than_states ? n + 3 : 4, p = 3, n_y = 5;
      const MatrixXd slope = random_matrix(random, p, q);
      const VectorXd level = random_matrix(random, p, 1);
      auto map = random_map(random, n_y, n, q, p, [&](const VectorXd& w) { return VectorXd(slope * w + level); });
      if (GetParam() == Channels::dependent) map.selection.row(3) = 2.0 * map.selection.row(0) - map.selection.row(2);
      if (GetParam() == Channels::repeated) map.selection.row(1) = map.selection.row(2);
      if (GetParam() == Channels::without_variance) map.selection.row(1).setZero();
      const VectorXd m = random_matrix(random, n, 1);
      MatrixXd S = random_matrix(random, n, n);
      if (trial % 2) S = MatrixXd(S.triangularView<Eigen::Lower>());
      // Channels that depend on each other are kept apart by 1e-12 of their variance: 1e-6 of a deviation, whose share
      // of the images is of the second order where phi is linear.
      expect_equal(transformed(map, m, S, options, SigmaPoints::of_arguments),
                   transformed(map, m, S, options, SigmaPoints::of_state), 2e-10);
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, LinearInTheChannels,
                         testing::Values(Channels::independent, Channels::dependent, Channels::repeated,
                                         Channels::without_variance, Channels::more_than_states));

TEST(ReducedPoints, EqualThePointsOfTheStateWhereEveryStateIsAChannel) {
  // n = q, N = 1 and S = L: the same points, so the same moments whatever phi is.
  RandomStream random(12, "all channels");
  for (int trial = 0; trial < 20; ++trial) {
    auto map = random_map(random, 4, 3, 3, 2, bent);
    map.selection.setIdentity();
    const VectorXd m = random_matrix(random, 3, 1);
    const MatrixXd S = ordered_root(random);
    for (const auto& options : {UnscentedOptions{}, UnscentedOptions{0.6, 1.0, 0.5}}) {
      const auto reduced = transformed(map, m, S, options, SigmaPoints::of_arguments);
      // found 1e-15: rounding of sums over the points
      expect_equal(reduced, transformed(map, m, S, options, SigmaPoints::of_state), 3e-14);
      expect_equal(reduced, table_1(map, m, S, options), 3e-14);
    }
  }
}

TEST(ReducedPoints, StandForTheWholeStateByItsMeanGivenTheChannels) {
  // Written out with dense inverses: points of w alone, x completed by E[x | w].
  RandomStream random(13, "completion");
  const UnscentedOptions options{0.8, 2.0, 0.0};
  for (int trial = 0; trial < 10; ++trial) {
    const Index n = 7, q = 3;
    auto map = random_map(random, 4, n, q, 2, bent);
    const VectorXd m = random_matrix(random, n, 1);
    const MatrixXd S = random_matrix(random, n, n), P = S * S.transpose(), L = ordered_root(random);
    const MatrixXd N = map.selection = channels_with_root(L, map.selection, S);
    const MatrixXd P_ww = N * P * N.transpose(), completion = P * N.transpose() * P_ww.inverse();
    FunctionMap of_w(bent);  // w -> y at the completed state
    of_w.linear = map.linear * completion, of_w.gain = map.gain, of_w.selection = MatrixXd::Identity(q, q);
    of_w.input_offset = N * m + map.input_offset, of_w.offset = map.linear * m + map.offset;
    auto expected = table_1(of_w, VectorXd::Zero(q), L, options);
    const MatrixXd rest = P - completion * P_ww * completion.transpose();  // of x given w, moved by A alone
    expected.covariance += map.linear * rest * map.linear.transpose();
    expected.cross = (completion * expected.cross + rest * map.linear.transpose()).eval();
    // rounding of sums over the points
    expect_equal(transformed(map, m, S, options, SigmaPoints::of_arguments), expected, 3e-14);
  }
}

TEST(ReducedPoints, DoNotSeeStatesThatReachNoChannel) {
  // Twenty more states that are correlated with the others change nothing of the moments of the first outputs. Points
  // of the state would move out by sqrt(23 / 3).
  RandomStream random(14, "more states");
  auto map = random_map(random, 4, 3, 3, 2, bent);
  const VectorXd m = random_matrix(random, 3, 1);
  const MatrixXd S = random_matrix(random, 3, 3);
  auto large = random_map(random, 4, 23, 3, 2, bent);
  large.linear << map.linear, MatrixXd::Zero(4, 20);
  large.selection << map.selection, MatrixXd::Zero(3, 20);
  large.gain = map.gain, large.offset = map.offset, large.input_offset = map.input_offset;
  MatrixXd large_S = random_matrix(random, 23, 23);
  large_S.topRows(3) << S, MatrixXd::Zero(3, 20);
  VectorXd large_m(23);
  large_m << m, random_matrix(random, 20, 1);
  const auto small = transformed(map, m, S, {}, SigmaPoints::of_arguments);
  const auto found = transformed(large, large_m, large_S, {}, SigmaPoints::of_arguments);
  // the states that no channel sees add exact zeros
  EXPECT_LT((found.mean - small.mean).norm(), 1e-14 * small.mean.norm());
  EXPECT_LT((found.covariance - small.covariance).norm(), 1e-14 * small.covariance.norm());
  const auto of_state = transformed(large, large_m, large_S, {}, SigmaPoints::of_state);
  EXPECT_GT((of_state.covariance - small.covariance).norm(), 0.05 * small.covariance.norm());
}

// ------------------------------------------------------------------------------------------------ known moments

TEST(ReducedPoints, QuadraticOfOneChannelHasItsExactMeanAndVariance) {
  // w ~ N(mu, s^2): w^2 has mean mu^2 + s^2 and variance 4 mu^2 s^2 + 2 s^4, and Cov(x, w^2) = 2 mu P N^T. c = 3 and
  // beta = 0, with q = 1 whatever the number of states.
  RandomStream random(15, "square");
  for (const Index n : {1, 2, 9}) {
    auto map = random_map(random, 1, n, 1, 1, [](const VectorXd& w) { return VectorXd(w.cwiseAbs2()); });
    map.linear.setZero();
    map.gain.setOnes();
    const VectorXd m = random_matrix(random, n, 1);
    const MatrixXd S = random_matrix(random, n, n), P = S * S.transpose();
    const double mu = (map.selection * m + map.input_offset)[0],
                 s2 = (map.selection * P * map.selection.transpose())(0);
    const auto found = transformed(map, m, S, {1.0, 0.0, 2.0}, SigmaPoints::of_arguments);
    // rounding of sums over the points
    EXPECT_NEAR(found.mean[0], mu * mu + s2 + map.offset[0], 4e-15 * (mu * mu + s2));
    const double variance = 4 * mu * mu * s2 + 2 * s2 * s2;
    EXPECT_NEAR(found.covariance(0, 0), variance, 1e-14 * variance);
    EXPECT_LT((found.cross - 2 * mu * P * map.selection.transpose()).norm(), 1e-14 * found.cross.norm());
  }
}

TEST(ReducedPoints, MeanAndCrossCovarianceOfAnyQuadraticAreExact) {
  // phi = w^T H w: mean mu^T H mu + tr(H P_ww), Cov(x, phi) = 2 P N^T H mu, for any spread; with dependent channels
  // too.
  RandomStream random(16, "quadratic");
  for (int trial = 0; trial < 10; ++trial) {
    const Index n = 8, q = 4;
    const MatrixXd half = random_matrix(random, q, q), H = half + half.transpose();
    auto map = random_map(random, 1, n, q, 1, [&](const VectorXd& w) { return VectorXd(w.transpose() * H * w); });
    if (trial % 2) map.selection.row(3) = map.selection.row(0) + map.selection.row(1);
    map.linear.setZero();
    map.gain.setOnes();
    const VectorXd m = random_matrix(random, n, 1);
    const MatrixXd S = random_matrix(random, n, n), P = S * S.transpose(), N = map.selection;
    const VectorXd mu = N * m + map.input_offset;
    const auto found = transformed(map, m, S, {0.7, 2.0, 0.0}, SigmaPoints::of_arguments);
    const MatrixXd cross = 2.0 * P * N.transpose() * H * mu;
    const double mean = mu.dot(H * mu) + (H * N * P * N.transpose()).trace() + map.offset[0];
    // dependent channels are told apart by the root of the rounding: found 2e-13
    EXPECT_NEAR(found.mean[0], mean, 2e-12 * (H.norm() * (N * P * N.transpose()).norm() + mu.dot(mu) * H.norm()));
    EXPECT_LT((found.cross - cross).norm(), 1e-14 * cross.norm());
  }
}

TEST(ReducedPoints, ScatterIsThatOfTheCurvaturesAndHasNoNegativeDirection) {
  // With e_i = (phi+ + phi-) / 2 - phi(mean) the scatter is sum e_i e_i^T / c + (beta - alpha^2) s s^T, s = phi(mean) -
  // mean(phi): semidefinite for beta >= alpha^2, however negative the weight of the centre.
  RandomStream random(17, "scatter");
  const Index n = 9, q = 3;
  for (const double c : {0.5, 3.0, 8.0}) {
    const UnscentedOptions options{std::sqrt(c / double(q)), 3.0, 0.0};
    auto map = random_map(random, 2, n, q, 2, bent);
    const VectorXd m = random_matrix(random, n, 1);
    const MatrixXd S = random_matrix(random, n, n), L = ordered_root(random);
    map.selection = channels_with_root(L, map.selection, S);
    const VectorXd centre = map.selection * m + map.input_offset;
    MatrixXd expected = MatrixXd::Zero(2, 2);
    VectorXd sum = VectorXd::Zero(2);
    for (Index i = 0; i < q; ++i) {
      const VectorXd step = std::sqrt(c) * L.col(i);
      const VectorXd curvature = 0.5 * (bent(centre + step) + bent(centre - step)) - bent(centre);
      expected += curvature * curvature.transpose() / c;
      sum += curvature / c;
    }
    expected += (options.beta - options.alpha * options.alpha) * sum * sum.transpose();
    const auto found = transformed(map, m, S, options, SigmaPoints::of_arguments);
    // rounding
    EXPECT_LT((found.scatter - expected).norm(), 2e-14 * expected.norm());
    EXPECT_GE(found.scatter.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-14 * expected.norm());
  }
}

TEST(ReducedPoints, NegativeVarianceAndMapsWithoutValueAreAnswers) {
  RandomStream random(18, "failures");
  auto map = random_map(random, 2, 3, 1, 1, [](const VectorXd& w) { return VectorXd(w.array().log()); });
  UnscentedOptions options;
  options.points = SigmaPoints::of_arguments;
  UnscentedTransform transform(options);
  EXPECT_FALSE(transform.apply(map, VectorXd::Zero(3), 100.0 * MatrixXd::Identity(3, 3)));
  EXPECT_FALSE(transform.apply(map, VectorXd::Zero(3), MatrixXd::Constant(3, 3, NAN)));
}

// -------------------------------------------------------------------------------------------------- the filters

/// Some samples are missing.
struct LinearRecord : LinearChainModel {
  [[nodiscard]] AugmentedModel augmented_model(int substeps,
                                               StateCoordinates coordinates = StateCoordinates::physical) const {
    auto options = all_known(model.system(), h);
    options.substeps = substeps;
    options.coordinates = coordinates;
    options.prior.displacement_deviation.setConstant(1e-3);
    options.prior.velocity_deviation.setConstant(0.05);
    options.prior.mean.displacement << 1e-3, -2e-3, 0.0;
    options.process_noise.acceleration.setConstant(0.5);
    return AugmentedModel(model.system(), sensors, {}, options);
  }
};

/// In modal coordinates the covariance form moves block by block; results come back in physical ones.
struct Form {
  FilterKind kind;
  StateCoordinates coordinates;
};

class ReducedFilters : public testing::TestWithParam<Form> {};

TEST_P(ReducedFilters, EqualAKalmanFilterOnALinearChain) {
  const LinearRecord linear;
  const auto physical = linear.augmented_model(1), augmented_model = linear.augmented_model(1, GetParam().coordinates);
  const auto problem = closed_loop(physical, Eigen::Vector3d(0.04, 0.09, 1e-8).asDiagonal());
  const Index samples = 400;
  const MatrixXd inputs =
      make_sine({.amplitude = 3e-3, .frequency = 6.0})->sample(0.0, LinearRecord::h, samples).matrix().transpose();
  auto record = draw_record(problem, physical.prior(), inputs, 21);
  record.measured.values.middleCols(100, 7).setConstant(NAN);
  for (Index k = 200; k < 260; ++k) record.measured.values(k % 3, k) = NAN;

  const auto result = estimate(augmented_model, record, {.filter = GetParam().kind});
  ASSERT_FALSE(result.failure) << result.failure->reason;
  KalmanFilter kalman{physical.prior().mean, physical.prior().covariance};
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
  // The channels at both ends of a step nearly depend on each other; what holds them apart is not seen, phi is linear.
  EXPECT_LT(mean_error, 4e-10);
  EXPECT_LT(deviation_error, 2e-10);
  EXPECT_LT((result.final_covariance - kalman.P).norm(), 2e-11 * kalman.P.norm());
  EXPECT_NEAR(result.log_likelihood, kalman.log_likelihood, 1e-12 * std::abs(kalman.log_likelihood));
}

TEST_P(ReducedFilters, StayWithTheUnscentedFilterWhereManyPartsMakeManyChannels) {
  const LinearRecord linear;
  const auto physical = linear.augmented_model(6);  // many more channels than states
  const auto augmented_model = linear.augmented_model(6, GetParam().coordinates);
  const Index samples = 200;
  const MatrixXd inputs =
      make_sine({.amplitude = 3e-3, .frequency = 6.0})->sample(0.0, LinearRecord::h, samples).matrix().transpose();
  const auto problem = closed_loop(linear.augmented_model(1), Eigen::Vector3d(0.04, 0.09, 1e-8).asDiagonal());
  const auto record = draw_record(problem, physical.prior(), inputs, 22);
  const auto expected = estimate(physical, record, {.filter = FilterKind::unscented});
  const auto found = estimate(augmented_model, record, {.filter = GetParam().kind});
  ASSERT_FALSE(expected.failure || found.failure);
  EXPECT_LT(((found.state.mean - expected.state.mean).array() / expected.state.deviation.array()).abs().maxCoeff(),
            // rounding of 200 steps, in standard deviations: found 1.4e-11
            4e-10);
  EXPECT_LT((found.state.deviation.array() / expected.state.deviation.array() - 1.0).abs().maxCoeff(), 2e-10);
}

INSTANTIATE_TEST_SUITE_P(Forms, ReducedFilters,
                         testing::Values(Form{FilterKind::partially_linear, StateCoordinates::physical},
                                         Form{FilterKind::partially_linear, StateCoordinates::modal},
                                         Form{FilterKind::partially_linear_square_root, StateCoordinates::physical},
                                         Form{FilterKind::partially_linear_square_root, StateCoordinates::modal}));

TEST(ReducedFiltersAgree, OnTheNonlinearChainAtAnySpread) {
  const Chain chain;
  const auto augmented_model = [&](StateCoordinates coordinates) {
    auto options = chain.options();
    options.substeps = 4;
    options.process_noise.acceleration.setConstant(0.2);
    options.coordinates = coordinates;
    return AugmentedModel(chain.model.system(), chain.sensors, {}, options);
  };
  const auto physical = augmented_model(StateCoordinates::physical), modal = augmented_model(StateCoordinates::modal);
  const auto record = Chain::record(chain.reference(0.8), 23);
  for (const double alpha : {2.0, 1.0}) {  // c = 12 and 3; of 12 channels the centre then weighs 0 and less
    EstimationOptions options{.filter = FilterKind::partially_linear};
    options.unscented.alpha = alpha;
    const auto covariance = estimate(physical, record, options), tiles = estimate(modal, record, options);
    options.filter = FilterKind::partially_linear_square_root;
    const auto factor = estimate(physical, record, options);
    ASSERT_FALSE(covariance.failure) << covariance.failure->reason;
    for (const auto* other : {&tiles, &factor}) {
      ASSERT_FALSE(other->failure) << other->failure->reason;
      // Of twelve channels some depend on each other: what is left of them is known to the root of the rounding error,
      // 1e-8 of a standard deviation, at every one of 800 steps.
      const auto& deviation = covariance.state.deviation.array();
      // found 2.4e-7
      EXPECT_LT(((other->state.mean - covariance.state.mean).array() / deviation).abs().maxCoeff(), 1e-6);
      EXPECT_LT((other->state.deviation.array() / deviation - 1.0).abs().maxCoeff(), 1e-6);
      EXPECT_NEAR(other->log_likelihood, covariance.log_likelihood, 1e-9 * std::abs(covariance.log_likelihood));
    }
  }
}

}  // namespace
}  // namespace kalfem
