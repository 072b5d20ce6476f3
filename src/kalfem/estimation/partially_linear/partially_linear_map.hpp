#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// A map that is linear but for a few channels,
///     y = A x + G phi(w) + b,     w = N x + e,
/// with w (q channels in) and phi (p channels out) small whatever the size of x. Transition and measurement of every
/// augmented model here have this form; the filters know nothing else of the model. b, e and the moving columns of G
/// may change from step to step; any other change of A, G or N takes another `revision`. phi is evaluated at many
/// points at once. An object belongs to one thread.
class PartiallyLinearMap {
public:
  virtual ~PartiallyLinearMap() = default;

  Eigen::MatrixXd linear;        ///< A, n_y x n_x
  Eigen::MatrixXd gain;          ///< G, n_y x p
  Eigen::MatrixXd selection;     ///< N, q x n_x
  Eigen::VectorXd offset;        ///< b, n_y
  Eigen::VectorXd input_offset;  ///< e, q
  Eigen::Index moving_gain = 0;  ///< so many last columns of G change with every step
  int revision = 0;              ///< of A, the other columns of G, and N

  /// phi at N points: `in` is N x q, `out` N x p. Returns false where a value is not finite or a solve did not
  /// converge.
  virtual bool evaluate(const Eigen::ArrayXXd& in, Eigen::ArrayXXd& out) = 0;
};

}  // namespace kalfem
