// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/shape_measures.hpp"

namespace kalfem {

double mac(const Eigen::VectorXcd& one, const Eigen::VectorXcd& other) {
  const double size = one.squaredNorm() * other.squaredNorm();
  return size > 0.0 ? std::norm(one.dot(other)) / size : 0.0;
}

double phase_collinearity(const Eigen::VectorXcd& shape) {
  const double real = shape.real().squaredNorm(), imaginary = shape.imag().squaredNorm(),
               mixed = shape.real().dot(shape.imag()), sum = real + imaginary;
  if (sum == 0.0) return 0.0;
  return ((real - imaginary) * (real - imaginary) + 4.0 * mixed * mixed) / (sum * sum);
}

}  // namespace kalfem
