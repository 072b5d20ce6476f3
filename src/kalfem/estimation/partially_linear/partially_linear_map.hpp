// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// A map that is linear but for a few scalars,
///     y = A x + G phi(w) + b,     w = N x + e,
/// with few nonlinear arguments w (q) and nonlinear outputs phi (p) whatever the size of x. Process model and
/// measurement model of every augmented model here have this form; the filters know nothing else of the model. A, N and
/// the first columns of G are constant once the map is made, so a filter may copy them. b, e and the moving columns of
/// G change from step to step. phi is evaluated at many points at once. An object belongs to one thread.
class PartiallyLinearMap {
public:
  virtual ~PartiallyLinearMap() = default;

  [[nodiscard]] const Eigen::MatrixXd& linear() const { return linear_; }              ///< A, n_y x n_x
  [[nodiscard]] const Eigen::MatrixXd& gain() const { return gain_; }                  ///< G, n_y x p
  [[nodiscard]] const Eigen::MatrixXd& selection() const { return selection_; }        ///< N, q x n_x
  [[nodiscard]] const Eigen::VectorXd& offset() const { return offset_; }              ///< b, n_y
  [[nodiscard]] const Eigen::VectorXd& input_offset() const { return input_offset_; }  ///< e, q
  /// So many last columns of G change with every step.
  [[nodiscard]] Eigen::Index moving_gain() const { return moving_gain_; }

  /// phi at N points: `in` is N x q, `out` N x p. Returns false where a value is not finite or a solve did not
  /// converge.
  virtual bool evaluate(const Eigen::ArrayXXd& in, Eigen::ArrayXXd& out) = 0;

protected:
  Eigen::MatrixXd linear_, gain_, selection_;
  Eigen::VectorXd offset_, input_offset_;
  Eigen::Index moving_gain_ = 0;
};

}  // namespace kalfem
