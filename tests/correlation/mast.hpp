// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/linear_model.hpp"

namespace kalfem::test {

/// A lattice mast: levels of three joints, twisted and tapered so that no two axes are alike, bars between neighbours
/// and across. Degrees of freedom "n4.x", joints of the foot held.
struct Mast {
  std::vector<Eigen::Vector3d> joints;
  std::vector<std::pair<int, int>> bars;
};

inline Mast mast(int levels) {
  Mast made;
  for (int level = 0; level <= levels; ++level)
    for (int corner = 0; corner < 3; ++corner) {
      const double angle = 2.1 * corner + 0.15 * level, radius = 1.2 - 0.05 * level;
      made.joints.emplace_back(radius * std::cos(angle), 0.8 * radius * std::sin(angle), 1.1 * level + 0.1 * corner);
    }
  for (int level = 1; level <= levels; ++level)
    for (int corner = 0; corner < 3; ++corner) {
      const int joint = 3 * level + corner, next = 3 * level + (corner + 1) % 3;
      made.bars.insert(made.bars.end(), {{joint, next}, {joint, joint - 3}, {joint, next - 3}});
    }
  return made;
}

/// `factors`: one a bar, on a stiffness of 2e6 N over its length; 20 kg a joint.
inline LinearModel model_of(const Mast& mast, const std::vector<double>& factors = {}) {
  const auto size = 3 * (std::ssize(mast.joints) - 3);
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < mast.bars.size(); ++i) {
    const auto [from, to] = mast.bars[i];
    const Eigen::Vector3d along =
        mast.joints[static_cast<std::size_t>(to)] - mast.joints[static_cast<std::size_t>(from)];
    const Eigen::Vector3d n = along.normalized();
    const Eigen::Matrix3d k = (factors.empty() ? 1.0 : factors[i]) * 2e6 / along.norm() * n * n.transpose();
    const int a = 3 * (from - 3), b = 3 * (to - 3);
    if (a >= 0) stiffness.block<3, 3>(a, a) += k;
    if (b >= 0) stiffness.block<3, 3>(b, b) += k;
    if (a >= 0 && b >= 0) stiffness.block<3, 3>(a, b) -= k, stiffness.block<3, 3>(b, a) -= k;
  }
  LinearModel model;
  for (Eigen::Index i = 0; i < size; ++i) model.dofs.push_back("n" + std::to_string(i / 3 + 4) + "." + "xyz"[i % 3]);
  model.stiffness = SparseMatrix(stiffness.sparseView());
  model.mass = SparseMatrix(Eigen::MatrixXd(20.0 * Eigen::MatrixXd::Identity(size, size)).sparseView());
  model.damping = SparseMatrix(size, size);
  return model;
}

}  // namespace kalfem::test
