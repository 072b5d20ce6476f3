// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <array>
#include <vector>

namespace kalfem {

/// A straight piece of a contour, from one point to another.
using ContourPiece = std::array<Eigen::Vector2d, 2>;

/// Contour about the smallest region with this share of the weight of points in a plane, 2 x n. Density: a Gaussian
/// kernel of Scott's width, n_eff^(-1/6), in coordinates without correlation. Empty where the points do not spread
/// in two directions. `weights` sum to one.
std::vector<ContourPiece> density_contour(const Eigen::Matrix2Xd& points, const Eigen::VectorXd& weights, double share);

}  // namespace kalfem
