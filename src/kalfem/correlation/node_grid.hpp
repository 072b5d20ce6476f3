// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <array>
#include <unordered_map>
#include <vector>

namespace kalfem {

/// Finds the two places of a set that are nearest to any place, by boxes of a regular grid.
class NodeGrid {
public:
  /// `size`: of a box, about the distance between neighbours [m].
  NodeGrid(const Eigen::Matrix3Xd& places, double size);

  struct Nearest {
    std::array<Eigen::Index, 2> index = {-1, -1};  ///< nearest, and the next
    std::array<double, 2> distance = {};           ///< [m]; infinite where there is none
  };
  /// The nearest places no farther away than about `reach`.
  [[nodiscard]] Nearest near(const Eigen::Vector3d& place, double reach) const;
  /// The nearest of all.
  [[nodiscard]] Nearest nearest(const Eigen::Vector3d& place) const;

private:
  using Box = std::array<int, 3>;
  struct Hash {
    std::size_t operator()(const Box& box) const {
      return static_cast<std::size_t>(box[0]) * 73856093u ^ static_cast<std::size_t>(box[1]) * 19349663u ^
             static_cast<std::size_t>(box[2]) * 83492791u;
    }
  };
  [[nodiscard]] Box box_of(const Eigen::Vector3d& place) const;
  static void enter(Nearest& nearest, Eigen::Index index, double distance);

  const Eigen::Matrix3Xd& places_;
  double size_;
  std::unordered_map<Box, std::vector<Eigen::Index>, Hash> boxes_;
};

}  // namespace kalfem
