// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/smoother/smoothed_outputs.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd smoothed_mean(const Gaussian& filtered, const Adjoint& adjoint) {
  return filtered.mean + filtered.covariance * adjoint.vector;
}

MatrixXd smoothed_covariance(const MatrixXd& rows, const Gaussian& filtered, const Adjoint& adjoint) {
  const MatrixXd products = rows * filtered.covariance;
  return products * rows.transpose() - products * adjoint.matrix * products.transpose();
}

bool smooth_outputs(MeasurementModel& map, const Gaussian& filtered, const Adjoint& adjoint, ArgumentMoments& moments,
                    VectorXd& mean, VectorXd* deviation) {
  const VectorXd state = smoothed_mean(filtered, adjoint);
  if (map.moving_gain() > 0) map.set_mean(state);
  const MatrixXd &A = map.linear(), &N = map.selection(), &G = map.gain();
  const Index q = N.rows(), outputs = deviation ? A.rows() : 0;
  MatrixXd rows(q + outputs, N.cols());
  rows.topRows(q) = N;
  if (deviation) rows.bottomRows(outputs) = A;
  const MatrixXd covariance = smoothed_covariance(rows, filtered, adjoint);
  if (!moments.evaluate(map, N * state + map.input_offset(), covariance.topLeftCorner(q, q))) return false;
  mean = A * state + G * moments.mean() + map.offset();
  if (!deviation) return true;
  const MatrixXd force = covariance.bottomLeftCorner(outputs, q) * moments.slopes() + 0.5 * G * moments.covariance();
  const VectorXd variance = covariance.diagonal().tail(outputs) + 2.0 * force.cwiseProduct(G).rowwise().sum();
  *deviation = variance.cwiseMax(0.0).cwiseSqrt();
  return true;
}

}  // namespace kalfem
