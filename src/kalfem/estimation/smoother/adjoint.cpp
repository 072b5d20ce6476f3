// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/smoother/adjoint.hpp"

namespace kalfem {

using Eigen::MatrixXd;

TransposedMap::TransposedMap(const PartiallyLinearMap& map)
    : linear(MatrixXd(map.linear().transpose()).sparseView()), selection(map.selection().transpose()) {}

MatrixXd LinearisedStep::transposed_times(const MatrixXd& matrix) const {
  MatrixXd product = map->linear * matrix;
  product.noalias() += map->selection * (gain_of_arguments * matrix);
  return product;
}

// lambda- = (I - K H)^T lambda + H^T S^-1 nu,  Lambda- = (I - K H)^T Lambda (I - K H) + H^T S^-1 H, with thin products
// only.
void Adjoint::pass(const LinearisedMeasurement& measurement) {
  const auto& [H, K, weighted, innovation] = measurement;
  if (H.rows() == 0) return;
  const MatrixXd seen = K.transpose() * matrix;  // K^T Lambda
  const MatrixXd added = 0.5 * ((seen * K) * H + weighted) - seen;
  vector += H.transpose() * (innovation - K.transpose() * vector);
  const MatrixXd half = H.transpose() * added;
  matrix += half;
  matrix += half.transpose();
}

void Adjoint::pass(const LinearisedStep& step) {
  vector = step.transposed_times(vector);
  const MatrixXd once = step.transposed_times(matrix).transpose();
  matrix = step.transposed_times(once);
  matrix = (0.5 * (matrix + matrix.transpose())).eval();
}

void Adjoint::transform(const MatrixXd& T) {
  vector = (T.transpose() * vector).eval();
  matrix = (T.transpose() * matrix * T).eval();
}

}  // namespace kalfem
