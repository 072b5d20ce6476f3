// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/node_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kalfem {

constexpr double far_away = std::numeric_limits<double>::infinity();

NodeGrid::NodeGrid(const Eigen::Matrix3Xd& places, double size) : places_(places), size_(size) {
  for (Eigen::Index i = 0; i < places.cols(); ++i) boxes_[box_of(places.col(i))].push_back(i);
}

NodeGrid::Box NodeGrid::box_of(const Eigen::Vector3d& place) const {
  Box box{};
  for (std::size_t a = 0; a < 3; ++a)
    box[a] = static_cast<int>(std::clamp(std::floor(place[static_cast<Eigen::Index>(a)] / size_), -1e9, 1e9));
  return box;
}

void NodeGrid::enter(Nearest& nearest, Eigen::Index index, double distance) {
  if (distance < nearest.distance[0]) {
    nearest = {{index, nearest.index[0]}, {distance, nearest.distance[0]}};
  } else if (distance < nearest.distance[1]) {
    nearest.index[1] = index;
    nearest.distance[1] = distance;
  }
}

NodeGrid::Nearest NodeGrid::near(const Eigen::Vector3d& place, double reach) const {
  Nearest nearest{{-1, -1}, {far_away, far_away}};
  const int around = static_cast<int>(std::ceil(reach / size_));
  const Box centre = box_of(place);
  for (int x = -around; x <= around; ++x)
    for (int y = -around; y <= around; ++y)
      for (int z = -around; z <= around; ++z)
        if (const auto found = boxes_.find({centre[0] + x, centre[1] + y, centre[2] + z}); found != boxes_.end())
          for (const auto index : found->second) enter(nearest, index, (places_.col(index) - place).norm());
  return nearest;
}

// Boxes near the place first; where they hold fewer than two places, all are looked at.
NodeGrid::Nearest NodeGrid::nearest(const Eigen::Vector3d& place) const {
  for (const double reach : {size_, 3.0 * size_})
    if (const auto found = near(place, reach); found.index[1] >= 0 && found.distance[1] <= reach) return found;
  Nearest nearest{{-1, -1}, {far_away, far_away}};
  for (Eigen::Index i = 0; i < places_.cols(); ++i) enter(nearest, i, (places_.col(i) - place).norm());
  return nearest;
}

}  // namespace kalfem
