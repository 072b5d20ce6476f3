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

ModeSet mode_set(const ModalResult& result) {
  ModeSet set{.points = result.channels};
  for (const auto& mode : result.modes)
    set.modes.push_back({.frequency = mode.frequency,
                         .frequency_std = mode.frequency_std(),
                         .damping = mode.damping,
                         .damping_std = mode.damping_std(),
                         .shape = mode.shape,
                         .shape_covariance = mode.shape_covariance,
                         .degrees_of_freedom = mode.degrees_of_freedom});
  return set;
}

}  // namespace kalfem
