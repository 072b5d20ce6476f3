#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// A polygon on the screen: x and y [pixel] and the depth of its corners, larger farther away.
struct ScreenPolygon {
  Eigen::Matrix3Xd corners;
};

/// What is seen of polygons on a raster of width x height pixels.
struct ScreenDepth {
  std::vector<bool> visible;    ///< per polygon: it is the nearest one at any pixel
  std::vector<double> nearest;  ///< per pixel, row by row: depth of the nearest polygon, infinite where there is none
  int width = 0, height = 0;

  /// Depth of what is nearest at a place, infinite outside.
  [[nodiscard]] double at(double x, double y) const;
};
ScreenDepth screen_depth(const std::vector<ScreenPolygon>& polygons, int width, int height);

/// The visible polygons in the order in which they are to be painted so that nearer ones cover farther ones: per pixel
/// they are sorted by depth, and of each two that follow one another the farther is painted first. Where polygons cover
/// one another in a ring the farthest goes first.
std::vector<std::size_t> painters_order(const std::vector<ScreenPolygon>& polygons, const ScreenDepth& depth);

}  // namespace kalfem
