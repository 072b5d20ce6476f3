// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <complex>

#include "kalfem/dynamics/stepper.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;

constexpr double largest_step = 2.0;  ///< omega h; a period is two steps long at pi

/// [A, V, D] of the scheme's motion a_k = z^k.
Eigen::Vector3cd terms_of(const Complex& z, double h, const AlphaParameters& scheme) {
  const auto& [beta, gamma, alpha_m, alpha_f] = scheme;
  const Complex v = h * ((1.0 - gamma) + gamma * z) / (z - 1.0),
                d = (h * v + h * h * ((0.5 - beta) + beta * z)) / (z - 1.0);
  const Complex inertia = (1.0 - alpha_m) * z + alpha_m, rest = (1.0 - alpha_f) * z + alpha_f;
  return {inertia, rest * v, rest * d};
}

}  // namespace

void correct_periods(LocallyNonlinearSystem& system, Eigen::Index first, double step, const AlphaParameters& scheme) {
  for (Eigen::Index i = first; i < system.size(); ++i) {
    const double stiffness = system.stiffness.coeff(i, i), decay = 0.5 * system.damping.coeff(i, i);
    if (!(stiffness > 0.0) || std::sqrt(stiffness) * step > largest_step) continue;
    const Complex root = std::sqrt(Complex(decay * decay - stiffness));
    const Eigen::Vector3cd one = terms_of(std::exp(step * (-decay + root)), step, scheme),
                           other = terms_of(std::exp(step * (-decay - root)), step, scheme);
    // of a pair the second equation is the first's conjugate: their sum and difference are its two parts
    Eigen::Matrix<double, 2, 3> parts;
    if (root.imag() != 0.0)
      parts << one.real().transpose(), one.imag().transpose();
    else
      parts << one.real().transpose(), other.real().transpose();
    const Eigen::Vector2d mass_and_damping = parts.leftCols<2>().inverse() * (-stiffness * parts.col(2));
    system.mass.coeffRef(i, i) = mass_and_damping[0];
    system.damping.coeffRef(i, i) = mass_and_damping[1];
  }
}

}  // namespace kalfem
