// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/modal_result.hpp"

#include <cmath>

#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

double IdentifiedMode::frequency_std() const { return std::sqrt(covariance(0, 0)); }
double IdentifiedMode::damping_std() const { return std::sqrt(covariance(1, 1)); }

Eigen::VectorXcd IdentifiedMode::shape_std() const {
  const Eigen::VectorXd deviation = shape_covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  Eigen::VectorXcd of_entries(shape.size());
  of_entries.real() = deviation.head(shape.size());
  of_entries.imag() = deviation.tail(shape.size());
  return of_entries;
}

double IdentifiedMode::coverage_factor() const { return student_t_quantile(0.975, degrees_of_freedom); }

}  // namespace kalfem
