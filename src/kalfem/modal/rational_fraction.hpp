// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <complex>
#include <vector>

#include "kalfem/modal/state_space_poles.hpp"

namespace kalfem {

/// FRFs as they are fitted: each output in units of its own root mean square over lines and inputs, each line with a
/// weight.
struct FittedResponses {
  Eigen::VectorXd omega;                 ///< [rad/s], ascending
  std::vector<Eigen::MatrixXcd> values;  ///< one an input, lines x outputs
  Eigen::VectorXd weights;               ///< of the equation errors, one a line
  Eigen::VectorXd scale;                 ///< root mean square of each output [its unit]

  [[nodiscard]] Eigen::Index lines() const { return omega.size(); }
  [[nodiscard]] Eigen::Index outputs() const { return scale.size(); }
  [[nodiscard]] Eigen::Index inputs() const { return static_cast<Eigen::Index>(values.size()); }
};

/// Poly-reference least-squares complex frequency-domain method (p-LSCF, "PolyMAX") [GVVP03, PVGL04]: a right matrix
/// fraction
///     H(omega) = B(omega) A(omega)^-1,   A = sum_r z^r A_r (inputs x inputs),   B_o = sum_r z^r B_or,   r = 0 .. n,
/// with complex coefficients in z = exp(i theta), where the band of omega is mapped to most of the unit circle. The
/// equation errors w_k (B_o - H_o A) are least for B_o = R^-1 S_o A, which leaves the reduced normal equations
///     M A = 0,   M = sum_o (T_o - S_o^H R^-1 S_o),   A_0 = 1.
/// All sums over lines are of products with powers z^d, d = -n .. n, so that they are made once for all orders. With
/// A_0 fixed, poles of noise have a negative damping and physical ones a positive [CGVV04], which makes clear diagrams.
class RationalFraction {
public:
  /// `max_degree`: the largest n.
  RationalFraction(const FittedResponses& responses, Eigen::Index max_degree);

  /// Poles of the model of one degree in the band with a positive damping, where A x = 0, with the shapes B x. Their
  /// deviations are nominal: a twentieth of half the bandwidth, and of the damping.
  [[nodiscard]] std::vector<StatePole> poles(Eigen::Index degree) const;

private:
  using Coefficients = std::vector<Eigen::MatrixXcd>;  ///< A_1 ... A_n

  [[nodiscard]] Eigen::MatrixXcd basis_gram(Eigen::Index degree) const;
  [[nodiscard]] Eigen::MatrixXcd cross(Eigen::Index degree, Eigen::Index output) const;
  [[nodiscard]] Eigen::MatrixXcd gram(Eigen::Index degree) const;
  [[nodiscard]] StatePole pole_at(std::complex<double> z, const Eigen::MatrixXcd& numerators, Eigen::Index degree,
                                  const Eigen::VectorXcd& null_vector) const;

  Eigen::Index outputs_ = 0, inputs_ = 0, max_degree_ = 0;
  double first_ = 0.0, last_ = 0.0, angle_per_omega_ = 0.0;
  Eigen::VectorXcd basis_sums_;  ///< sum_k w^2 z^d, d = -n .. n
  Eigen::MatrixXcd cross_sums_;  ///< sum_k w^2 z^d H, (2 n + 1) x (outputs inputs), an input after the other
  Eigen::MatrixXcd power_sums_;  ///< sum_k w^2 z^d conj(H_i) H_j summed over outputs, (2 n + 1) x inputs^2
};

}  // namespace kalfem
