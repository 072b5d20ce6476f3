// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/linear_model.hpp"

namespace kalfem::test {

/// Lowest natural frequencies [Hz], ascending.
inline Eigen::VectorXd frequencies(const LinearModel& model, Eigen::Index count) {
  return lowest_modes(model.stiffness, model.mass, {.count = count}).values.cwiseMax(0.0).cwiseSqrt() /
         (2.0 * std::numbers::pi);
}

}  // namespace kalfem::test
