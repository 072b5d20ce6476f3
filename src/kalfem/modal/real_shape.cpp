// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/real_shape.hpp"

#include <cmath>
#include <complex>

namespace kalfem {

RealShape real_shape(const Eigen::VectorXcd& shape, const Eigen::MatrixXd& covariance) {
  const Eigen::Index n = shape.size();
  std::complex<double> square = 0.0;
  for (const auto& entry : shape)
    if (std::isfinite(std::abs(entry))) square += entry * entry;
  const double angle = -0.5 * std::arg(square);
  const Eigen::VectorXcd turned = shape * std::polar(1.0, angle);
  RealShape real{.values = turned.real(), .covariance = {}};
  double whole = 0.0, across = 0.0;
  for (const auto& entry : turned)
    if (std::isfinite(std::abs(entry))) whole += std::norm(entry), across += entry.imag() * entry.imag();
  if (whole > 0.0) real.complexity = std::sqrt(across / whole);
  if (covariance.size() > 0) {
    Eigen::MatrixXd turn(n, 2 * n);
    turn << Eigen::MatrixXd::Identity(n, n) * std::cos(angle), Eigen::MatrixXd::Identity(n, n) * -std::sin(angle);
    real.covariance = turn * covariance * turn.transpose();
  }
  return real;
}

}  // namespace kalfem
