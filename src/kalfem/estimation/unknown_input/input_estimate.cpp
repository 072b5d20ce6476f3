// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/unknown_input/input_estimate.hpp"

#include <cmath>
#include <utility>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double rank_tolerance = 1e-12;  ///< relative, of columns scaled to length one
constexpr double on_circle = 1e-9;

MatrixXd symmetric(const MatrixXd& matrix) { return 0.5 * (matrix + matrix.transpose()); }

bool has_full_column_rank(MatrixXd matrix) {
  if (matrix.cols() > matrix.rows()) return false;
  for (Index j = 0; j < matrix.cols(); ++j) {
    const double length = matrix.col(j).norm();
    if (length == 0.0) return false;
    matrix.col(j) /= length;
  }
  Eigen::ColPivHouseholderQR<MatrixXd> factor(matrix);
  factor.setThreshold(rank_tolerance);
  return factor.rank() == matrix.cols();
}

/// [A - z I, G; C, D].
MatrixXd system_matrix(const UnknownInputModel& model, double z) {
  const Index n = model.states(), l = model.C.rows(), p = model.G.cols();
  MatrixXd matrix(n + l, n + p);
  matrix << model.A - z * MatrixXd::Identity(n, n), model.G, model.C, model.D;
  return matrix;
}

/// Transmission zeros of a square model: generalised eigenvalues of its system matrix and diag(I, 0).
bool has_zero_beyond_circle(const UnknownInputModel& model) {
  const Index n = model.states();
  const MatrixXd pencil = system_matrix(model, 0.0);
  MatrixXd unit = MatrixXd::Zero(pencil.rows(), pencil.cols());
  unit.topLeftCorner(n, n).setIdentity();
  const Eigen::GeneralizedEigenSolver<MatrixXd> zeros(pencil, unit, false);
  for (Index i = 0; i < pencil.rows(); ++i) {
    const double alpha = std::abs(zeros.alphas()[i]), beta = std::abs(zeros.betas()[i]);
    const bool finite = beta > rank_tolerance * std::max(1.0, alpha);
    if (finite && alpha >= (1.0 - on_circle) * beta) return true;
  }
  return false;
}

}  // namespace

// With S = U^T U whitened, F and e become F_w and e_w, and d is an ordinary least-squares problem, solved by QR.
std::optional<InputEstimate> estimate_input(const InputMoments& moments) {
  const auto& [state, cross, innovation, innovation_covariance, G, F] = moments;
  if (!has_full_column_rank(F)) return std::nullopt;
  const Eigen::LLT<MatrixXd> factor(innovation_covariance);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const MatrixXd shape = factor.matrixL().solve(F), gain = factor.matrixL().solve(cross.transpose()).transpose();
  const VectorXd seen = factor.matrixL().solve(innovation);
  const Eigen::HouseholderQR<MatrixXd> columns(shape);
  const Index p = F.cols();
  const MatrixXd upper = columns.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  const MatrixXd root = upper.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(p, p));  // P_d = root root^T
  InputEstimate estimate;
  estimate.input = {columns.solve(seen), root * root.transpose()};
  const MatrixXd by_input = (G - gain * shape) * root;
  estimate.state.mean = state.mean + gain * (seen - shape * estimate.input.mean) + G * estimate.input.mean;
  estimate.state.covariance = symmetric(state.covariance - gain * gain.transpose() + by_input * by_input.transpose());
  estimate.cross = by_input * root.transpose();
  return estimate;
}

InputEstimate estimate_without_input(const InputMoments& moments) {
  const auto& [state, cross, innovation, innovation_covariance, G, F] = moments;
  const MatrixXd gain = innovation_covariance.ldlt().solve(cross.transpose()).transpose();
  const Index n = state.mean.size(), p = F.cols();
  return {{state.mean + gain * innovation, symmetric(state.covariance - gain * cross.transpose())},
          {VectorXd::Zero(p), MatrixXd::Zero(p, p)},
          MatrixXd::Zero(n, p)};
}

Invertibility invertibility_of(const UnknownInputModel& model) {
  Invertibility found;
  found.instantaneous = has_full_column_rank(model.has_feedthrough() ? model.D : MatrixXd(model.C * model.G));
  found.sees_constants = has_full_column_rank(system_matrix(model, 1.0));
  found.stable = found.sees_constants && (model.C.rows() > model.G.cols() || !has_zero_beyond_circle(model));
  return found;
}

UnknownInputFilter::UnknownInputFilter(UnknownInputModel model) : model_(std::move(model)) {
  const auto& [A, G, C, D, Q, R] = model_;
  const Index n = A.rows(), l = C.rows(), p = G.cols();
  const bool fits = A.cols() == n && G.rows() == n && C.cols() == n && D.rows() == l && D.cols() == p &&
                    Q.rows() == n && Q.cols() == n && R.rows() == l && R.cols() == l;
  if (!fits)
    throw InvalidInput("the matrices of a model with an unknown input do not fit each other",
                       "A is n x n, G n x p, C l x n, D l x p, Q n x n and R l x l", "");
}

InputMoments UnknownInputFilter::moments(const Gaussian& predicted, const VectorXd& y) const {
  const auto& [A, G, C, D, Q, R] = model_;
  const MatrixXd cross = predicted.covariance * C.transpose();
  const bool direct = model_.has_feedthrough();
  return {.state = predicted,
          .cross = cross,
          .innovation = y - C * predicted.mean,
          .innovation_covariance = symmetric(C * cross + R),
          .state_input = direct ? MatrixXd::Zero(G.rows(), G.cols()) : G,
          .output_input = direct ? D : MatrixXd(C * G)};
}

std::optional<InputEstimate> UnknownInputFilter::update(const Gaussian& predicted, const VectorXd& y) const {
  return estimate_input(moments(predicted, y));
}

InputEstimate UnknownInputFilter::first_update(const Gaussian& prior, const VectorXd& y) const {
  return estimate_without_input(moments(prior, y));
}

Gaussian UnknownInputFilter::predict(const InputEstimate& estimate) const {
  const auto& [A, G, C, D, Q, R] = model_;
  if (!model_.has_feedthrough())
    return {A * estimate.state.mean, symmetric(A * estimate.state.covariance * A.transpose() + Q)};
  const MatrixXd shared = A * estimate.cross * G.transpose();
  return {A * estimate.state.mean + G * estimate.input.mean,
          symmetric(A * estimate.state.covariance * A.transpose() + shared + shared.transpose() +
                    G * estimate.input.covariance * G.transpose() + Q)};
}

}  // namespace kalfem
