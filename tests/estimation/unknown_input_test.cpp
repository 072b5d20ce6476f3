// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "kalfem/base/random.hpp"
#include "kalfem/estimation/unknown_input/input_estimate.hpp"
#include "kalfem/estimation/unknown_input/unscented_input_filter.hpp"

// The filters of Gillijns and De Moor against least squares over all states and inputs at once, which know nothing of
// filters, and against Kalman filters whose input has a large variance.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Three states, the longitudinal motion of an aircraft in discrete time: two inputs, three sensors.
UnknownInputModel three_states(bool feedthrough) {
  UnknownInputModel model;
  model.A.resize(3, 3);
  model.A << 0.9944, -0.1203, -0.4302, 0.0017, 0.9902, -0.0747, 0.0, 0.8187, 0.0;
  model.G.resize(3, 2);
  model.G << 0.4252, 0.1, -0.0082, 0.3, 0.1813, -0.2;
  model.C = MatrixXd::Identity(3, 3);
  model.D = MatrixXd::Zero(3, 2);
  if (feedthrough) model.D << 1.0, 0.2, 0.0, 0.7, 0.4, -0.3;
  model.Q = Eigen::Vector3d(0.01, 0.01, 1e-4).asDiagonal();
  model.R = 0.01 * MatrixXd::Identity(3, 3);
  model.R(0, 1) = model.R(1, 0) = 2e-3;
  return model;
}

/// Darouach, Zasadzinski, Onana and Nowakowski 1995, Int. J. Systems Sci. 26, 1983-1990, section 5: one input, two
/// sensors of three states.
UnknownInputModel darouachs_case() {
  UnknownInputModel model;
  model.A.resize(3, 3);
  model.A << 0.0, 0.6, 0.075, 0.75, 0.0, 0.0, 0.0, 0.75, 0.0375;
  model.G = Eigen::Vector3d(0.0, 1.0, 1.0);
  model.C.resize(2, 3);
  model.C << 1.0, 1.0, 0.0, 0.0, 1.0, 1.0;
  model.D = MatrixXd::Zero(2, 1);
  model.Q = Eigen::Vector3d(3.0, 6.0, 9.0).asDiagonal();
  model.R = 12.0 * MatrixXd::Identity(2, 2);
  return model;
}

const Gaussian start{Eigen::Vector3d(1.0, -2.0, 0.5), 0.3 * Eigen::Matrix3d::Identity()};

using Input = std::function<VectorXd(int sample)>;

/// Inputs that no process describes.
VectorXd step_and_sine(int k) { return Eigen::Vector2d(k > 10 ? 50.0 : 0.0, 20.0 * std::sin(0.7 * k)); }

/// Darouach's d = 10 sign(sin(2 pi t / 50)).
VectorXd square_wave(int k) {
  return VectorXd::Constant(1, std::copysign(10.0, std::sin(2.0 * std::numbers::pi * k / 50.0)));
}

std::vector<VectorXd> record_of(const UnknownInputModel& model, int samples, const Input& input = step_and_sine) {
  RandomStream random(5, "unknown input");
  const auto noise = [&](const MatrixXd& covariance) {
    VectorXd white(covariance.rows());
    for (double& value : white) value = random.normal();
    return VectorXd(covariance.llt().matrixL() * white);
  };
  VectorXd x = start.mean + noise(start.covariance);
  std::vector<VectorXd> record;
  for (int k = 0; k < samples; ++k) {
    const VectorXd d = input(k);
    record.emplace_back(model.C * x + model.D * d + noise(model.R));
    x = model.A * x + model.G * d + noise(model.Q);
  }
  return record;
}

/// Least squares of the rows weight (matrix [x_0 ... x_k d_0 ...] - value), gathered one block after the other.
class BatchLeastSquares {
public:
  explicit BatchLeastSquares(Index unknowns) : unknowns_(unknowns) {}

  /// The residual value - sum of blocks has this covariance.
  void add(const MatrixXd& covariance, const VectorXd& value, const std::vector<std::pair<Index, MatrixXd>>& blocks) {
    const Eigen::LLT<MatrixXd> factor(covariance);
    MatrixXd rows = MatrixXd::Zero(value.size(), unknowns_);
    for (const auto& [first, block] : blocks) rows.middleCols(first, block.cols()) += block;
    const Index before = matrix_.rows();
    matrix_.conservativeResize(before + value.size(), unknowns_);
    value_.conservativeResize(before + value.size());
    matrix_.bottomRows(value.size()) = factor.matrixL().solve(rows);
    value_.tail(value.size()) = factor.matrixL().solve(value);
  }

  /// Estimate of all unknowns with its covariance.
  [[nodiscard]] Gaussian solve() const {
    const Eigen::HouseholderQR<MatrixXd> columns(matrix_);
    const MatrixXd upper = columns.matrixQR().topRows(unknowns_).triangularView<Eigen::Upper>();
    const MatrixXd root = upper.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(unknowns_, unknowns_));
    return {columns.solve(value_), root * root.transpose()};
  }

private:
  Index unknowns_;
  MatrixXd matrix_;
  VectorXd value_;
};

/// State after the last sample, then the last input that the record shows.
Gaussian batch_estimate(const UnknownInputModel& model, const std::vector<VectorXd>& record) {
  const auto last = static_cast<Index>(record.size()) - 1;
  const Index p = model.G.cols(), inputs = last + (model.has_feedthrough() ? 1 : 0), x = 0, d = 3 * (last + 1);
  BatchLeastSquares batch(d + p * inputs);
  const MatrixXd one = MatrixXd::Identity(3, 3);
  batch.add(start.covariance, start.mean, {{x, one}});
  for (Index k = 0; k <= last; ++k) {
    std::vector<std::pair<Index, MatrixXd>> seen{{x + 3 * k, model.C}};
    if (model.has_feedthrough()) seen.emplace_back(d + p * k, model.D);
    batch.add(model.R, record[static_cast<std::size_t>(k)], seen);
    if (k < last)
      batch.add(model.Q, VectorXd::Zero(3), {{x + 3 * (k + 1), one}, {x + 3 * k, -model.A}, {d + p * k, -model.G}});
  }
  const Gaussian all = batch.solve();
  std::vector<Index> wanted{3 * last, 3 * last + 1, 3 * last + 2};
  for (Index i = p; i > 0; --i) wanted.push_back(d + p * inputs - i);
  return {all.mean(wanted), all.covariance(wanted, wanted)};
}

InputEstimate filtered(const UnknownInputModel& model, const std::vector<VectorXd>& record) {
  const UnknownInputFilter filter(model);
  InputEstimate estimate = model.has_feedthrough() ? filter.update(start, record.front()).value()
                                                   : filter.first_update(start, record.front());
  for (std::size_t k = 1; k < record.size(); ++k) estimate = filter.update(filter.predict(estimate), record[k]).value();
  return estimate;
}

Gaussian joint(const InputEstimate& estimate) {
  const Index size = 3 + estimate.input.mean.size();
  Gaussian all{VectorXd(size), MatrixXd(size, size)};
  all.mean << estimate.state.mean, estimate.input.mean;
  all.covariance << estimate.state.covariance, estimate.cross, estimate.cross.transpose(), estimate.input.covariance;
  return all;
}

void expect_least_squares(const UnknownInputModel& model, const Input& input, const std::vector<int>& sizes) {
  for (const int samples : sizes) {
    const auto record = record_of(model, samples, input);
    const Gaussian found = joint(filtered(model, record)), expected = batch_estimate(model, record);
    EXPECT_LT((found.mean - expected.mean).norm(), 1e-10 * expected.mean.norm()) << samples;
    EXPECT_LT((found.covariance - expected.covariance).norm(), 1e-10 * expected.covariance.norm()) << samples;
  }
}

TEST(UnknownInputFilter, IsLeastSquaresOverTheWholeRecord) {
  for (const bool feedthrough : {false, true})
    expect_least_squares(three_states(feedthrough), step_and_sine, {2, 3, 25});
}

TEST(UnknownInputFilter, IsLeastSquaresOnDarouachsCase) {
  expect_least_squares(darouachs_case(), square_wave, {2, 3, 100});
}

/// A Kalman filter whose input is white with a standard deviation s: it comes nearer as 1 / s^2.
Gaussian with_white_input(const UnknownInputModel& model, const std::vector<VectorXd>& record, double s) {
  const auto& [A, G, C, D, Q, R] = model;
  MatrixXd output(3, 5), transition = MatrixXd::Zero(5, 5), noise = MatrixXd::Zero(5, 5);
  output << C, D;
  transition.topRows(3) << A, G;
  noise.topLeftCorner(3, 3) = Q;
  noise.bottomRightCorner(2, 2) = s * s * MatrixXd::Identity(2, 2);
  VectorXd x(5);
  x << start.mean, 0.0, 0.0;
  MatrixXd P = noise;
  P.topLeftCorner(3, 3) = start.covariance;
  for (std::size_t k = 0; k < record.size(); ++k) {
    if (k > 0) {
      x = transition * x;
      P = transition * P * transition.transpose() + noise;
    }
    const MatrixXd S = output * P * output.transpose() + R, K = P * output.transpose() * S.inverse();
    x += K * (record[k] - output * x);
    const MatrixXd rest = MatrixXd::Identity(5, 5) - K * output;
    P = rest * P * rest.transpose() + K * R * K.transpose();
  }
  return {x, P};
}

TEST(UnknownInputFilter, IsTheLimitOfAFilterWithAWhiteInput) {
  for (const bool feedthrough : {false, true}) {
    const auto model = three_states(feedthrough);
    const auto record = record_of(model, 25);
    const auto found = filtered(model, record);
    const auto difference = [&](double s) {
      return (with_white_input(model, record, s).mean.head(3) - found.state.mean).norm();
    };
    EXPECT_LT(difference(1e4), 1e-5) << feedthrough;
    EXPECT_GT(difference(10.0), 1e3 * difference(1e4)) << feedthrough;
  }
}

TEST(UnknownInputFilter, InputsThatTheSensorsDoNotDetermineAreSaid) {
  auto model = three_states(false);
  EXPECT_TRUE(invertibility_of(model).instantaneous);
  model.G.col(1) = -2.0 * model.G.col(0);  // both act alike
  EXPECT_FALSE(invertibility_of(model).instantaneous);
  EXPECT_FALSE(UnknownInputFilter(model).update(start, VectorXd::Zero(3)).has_value());
  model = three_states(true);
  model.C = model.C.topRows(1).eval();  // one sensor for two inputs
  model.D = model.D.topRows(1).eval();
  EXPECT_FALSE(invertibility_of(model).instantaneous);
}

/// A mass on a spring under an unknown force: its acceleration alone does not see a constant one, both do.
TEST(UnknownInputFilter, AccelerationsAloneDoNotSeeConstants) {
  const double h = 0.01, w = 20.0, c = std::cos(w * h), s = std::sin(w * h);
  UnknownInputModel model;
  model.A.resize(2, 2);
  model.A << c, s / w, -w * s, c;
  model.G.resize(2, 1);
  model.G << (1 - c) / (w * w), s / w;
  model.C.resize(1, 2);
  model.C << -w * w, 0.0;
  model.D = MatrixXd::Ones(1, 1);
  model.Q = 1e-6 * MatrixXd::Identity(2, 2);
  model.R = MatrixXd::Identity(1, 1);
  auto found = invertibility_of(model);
  EXPECT_TRUE(found.instantaneous);
  EXPECT_FALSE(found.sees_constants);
  EXPECT_FALSE(found.stable);
  model.C.conservativeResize(2, 2);
  model.C.row(1) << 1.0, 0.0;
  model.D = Eigen::Vector2d(1.0, 0.0);
  model.R = MatrixXd::Identity(2, 2);
  found = invertibility_of(model);
  EXPECT_TRUE(found.instantaneous && found.sees_constants && found.stable);
}

/// y = A x + G phi(w), w = N x.
class Map final : public PartiallyLinearMap {
public:
  using Function = std::function<void(const Eigen::ArrayXXd& in, Eigen::ArrayXXd& out)>;
  Map(const MatrixXd& A, const MatrixXd& G, const MatrixXd& N, Function phi) : phi_(std::move(phi)) {
    linear_ = A;
    gain_ = G;
    selection_ = N;
    offset_ = VectorXd::Zero(A.rows());
    input_offset_ = VectorXd::Zero(N.rows());
  }
  bool evaluate(const Eigen::ArrayXXd& in, Eigen::ArrayXXd& out) override {
    phi_(in, out);
    return out.isFinite().all();
  }

private:
  Function phi_;
};

/// A linear map part of which passes through phi(w) = w.
Map linear_map(const MatrixXd& A) {
  const MatrixXd N = MatrixXd::Identity(2, A.cols()), G = A.leftCols(2);
  MatrixXd rest = A;
  rest.leftCols(2).setZero();
  return {rest, G, N, [](const auto& in, auto& out) { out = in; }};
}

TEST(UnscentedInputFilter, IsTheLinearFilterOnALinearModel) {
  for (const bool feedthrough : {false, true}) {
    const auto model = three_states(feedthrough);
    const auto record = record_of(model, 25);
    Map process = linear_map(model.A), measurement = linear_map(model.C);
    UnscentedInputFilter filter({process, measurement, model.G, model.D, model.Q, model.R});
    auto estimate = feedthrough ? filter.update(start, record.front()) : filter.first_update(start, record.front());
    for (std::size_t k = 1; k < record.size(); ++k) {
      ASSERT_TRUE(estimate.has_value());
      estimate = filter.update(filter.predict(*estimate).value(), record[k]);
    }
    const Gaussian found = joint(estimate.value()), expected = joint(filtered(model, record));
    EXPECT_LT((found.mean - expected.mean).norm(), 1e-10 * expected.mean.norm()) << feedthrough;
    EXPECT_LT((found.covariance - expected.covariance).norm(), 1e-10 * expected.covariance.norm()) << feedthrough;
  }
}

/// Two masses with a cubic spring between them, x = [z1, v1, z2, v2, k3], an unknown force on the first, accelerations
/// and the first displacement measured. Mass 2 has no unknown force: k3 follows from its motion.
TEST(UnscentedInputFilter, FindsInputStateAndParameterOfANonlinearModel) {
  const double h = 1e-3, k = 900.0, c = 2.0, truth = 5e4;
  const auto cubic = [](const Eigen::ArrayXXd& in, Eigen::ArrayXXd& out) {
    out = in.col(1) * 1e4 * (in.col(0) * in.col(0) * in.col(0));
  };
  MatrixXd rate = MatrixXd::Zero(5, 5), force(5, 1), direction(2, 5);
  rate.row(0)[1] = rate.row(2)[3] = 1.0;
  rate.row(1) << -2 * k, -2 * c, k, c, 0.0;
  rate.row(3) << k, c, -k, -c, 0.0;
  force << 0.0, -1.0, 0.0, 1.0, 0.0;
  direction << 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  const MatrixXd A = MatrixXd::Identity(5, 5) + h * rate + 0.5 * h * h * rate * rate, G_phi = h * force;
  MatrixXd C(3, 5), D = MatrixXd::Zero(3, 1), G = MatrixXd::Zero(5, 1), of_phi(3, 1);
  C << rate.row(1), rate.row(3), 1.0, 0.0, 0.0, 0.0, 0.0;
  of_phi << -1.0, 1.0, 0.0;
  D(0, 0) = 1.0;
  G << 0.5 * h * h, h, 0.0, 0.0, 0.0;
  Map process(A, G_phi, direction, cubic), measurement(C, of_phi, direction, cubic);
  const MatrixXd Q = Eigen::DiagonalMatrix<double, 5>(1e-14, 1e-10, 1e-14, 1e-10, 0.0);
  const MatrixXd R = Eigen::Vector3d(1e-2, 1e-2, 1e-9).asDiagonal();
  UnscentedInputFilter filter({process, measurement, G, D, Q, R});

  RandomStream random(11, "input, state and parameter");
  VectorXd x = VectorXd::Zero(5), input(3000), estimated(3000), deviation(3000);
  x[4] = truth / 1e4;
  Gaussian predicted{VectorXd::Zero(5), MatrixXd::Zero(5, 5)};
  predicted.mean[4] = 8.0;
  predicted.covariance.diagonal() << 1e-10, 1e-8, 1e-10, 1e-8, 9.0;
  std::optional<InputEstimate> estimate;
  for (Index step = 0; step < input.size(); ++step) {
    const double time = h * static_cast<double>(step);
    input[step] = 30.0 * std::sin(20.0 * time) + (time > 1.5 ? 40.0 : 0.0);  // a jump that no process expects
    Eigen::ArrayXXd out(1, 1);
    cubic((direction * x).transpose().array(), out);
    VectorXd y = C * x + of_phi * out(0, 0) + D * input[step];
    for (Index i = 0; i < 3; ++i) y[i] += std::sqrt(R(i, i)) * random.normal();
    estimate = filter.update(predicted, y);
    ASSERT_TRUE(estimate.has_value());
    estimated[step] = estimate->input.mean[0];
    deviation[step] = std::sqrt(estimate->input.covariance(0, 0));
    predicted = filter.predict(*estimate).value();
    x = (A * x + G_phi * out(0, 0) + G * input[step]).eval();
  }
  const Index tail = 2500;
  EXPECT_LT((estimated - input).tail(tail).norm(), 0.02 * input.tail(tail).norm());
  const Eigen::ArrayXd error = (estimated - input).tail(tail).array().abs() / deviation.tail(tail).array();
  const double coverage = (error < 1.96).cast<double>().mean();
  EXPECT_GT(coverage, 0.9);
  EXPECT_LT(coverage, 0.99);
  const double k3 = estimate->state.mean[4], band = std::sqrt(estimate->state.covariance(4, 4));
  EXPECT_NEAR(k3, truth / 1e4, 3.0 * band);
  EXPECT_LT(band, 0.05 * k3);
}

}  // namespace
}  // namespace kalfem
