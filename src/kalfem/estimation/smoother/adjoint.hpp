// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <memory>

#include "kalfem/estimation/smoother/argument_moments.hpp"

namespace kalfem {

/// A^T and N^T of a map; they stay as they are while the map lives.
struct TransposedMap {
  explicit TransposedMap(const PartiallyLinearMap& map);
  Eigen::SparseMatrix<double> linear;  ///< A^T, n_x x n_y
  Eigen::MatrixXd selection;           ///< N^T, n_x x q
};

/// F = A + G Phi^T N, the statistically linearised process model of one step, Phi the slopes of phi. Products cost
/// O(n^2) where A is block diagonal.
struct LinearisedStep {
  std::shared_ptr<const TransposedMap> map;
  Eigen::MatrixXd gain_of_arguments;  ///< Phi G^T, q x n

  /// F^T M.
  [[nodiscard]] Eigen::MatrixXd transposed_times(const Eigen::MatrixXd& matrix) const;
};

/// One measurement of l channels about the predicted estimate.
struct LinearisedMeasurement {
  Eigen::MatrixXd output;      ///< H, l x n
  Eigen::MatrixXd gain;        ///< K, n x l
  Eigen::MatrixXd weighted;    ///< S^-1 H, l x n
  Eigen::VectorXd innovation;  ///< S^-1 (y - predicted y), l
};

/// What the record from some instant on says of the state there, in the form of Bryson and Frazier: with the filter's
/// estimate x, P at that instant the smoothed one is
///     x_s = x + P lambda,     P_s = P - P Lambda P.
/// docs/theory/smoother.md.
struct Adjoint {
  Eigen::VectorXd vector;  ///< lambda, n
  Eigen::MatrixXd matrix;  ///< Lambda, n x n, symmetric

  static Adjoint zero(Eigen::Index states) {
    return {Eigen::VectorXd::Zero(states), Eigen::MatrixXd::Zero(states, states)};
  }

  /// From after an update to before it.
  void pass(const LinearisedMeasurement& measurement);
  /// From the end of a step to its begin.
  void pass(const LinearisedStep& step);
  /// To other coordinates: x = T z.
  void transform(const Eigen::MatrixXd& T);
};

}  // namespace kalfem
