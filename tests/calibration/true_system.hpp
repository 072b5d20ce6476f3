// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <vector>

namespace kalfem::calibration {

/// A force along b, f(d, v, z) of the deformation d = b^T x, its rate v and a state z of its own with z' = g(d, v, z).
struct LocalForce {
  Eigen::VectorXd shape;  ///< b
  std::function<double(double d, double v, double z)> force;
  std::function<double(double d, double v, double z)> flow = {};  ///< g; empty: no state
};

/// M x'' + C x' + K x + sum_j b_j f_j = p(t), written down without any code of the library.
struct TrueSystem {
  Eigen::MatrixXd mass, damping, stiffness;
  std::vector<LocalForce> local = {};
  std::function<Eigen::VectorXd(double t)> load;

  [[nodiscard]] Eigen::Index dofs() const { return mass.rows(); }
};

/// The motion from rest at time 0, one column a sample at k / rate.
struct TrueMotion {
  Eigen::MatrixXd displacement, velocity, acceleration;
  Eigen::MatrixXd force;  ///< one row a local force
};

/// By the Radau IIA method of three stages, of order 5 and L-stable (Hairer and Wanner, Solving Ordinary Differential
/// Equations II, section IV.5), with so many equal steps a sample.
TrueMotion integrate(const TrueSystem& system, double rate, Eigen::Index samples, int steps);

/// Undamped natural frequencies [Hz], ascending.
Eigen::VectorXd frequencies(const TrueSystem& system);

}  // namespace kalfem::calibration
