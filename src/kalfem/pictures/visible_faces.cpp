// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>

#include "kalfem/pictures/mesh_picture.hpp"

namespace kalfem {
namespace {

// Row by row: where a line through the pixels' centres enters and leaves the triangle, and the depth at each centre by
// its barycentric coordinates.
/// Calls visit(pixel, depth) for the pixels whose centre lies in a triangle.
template <typename Visit>
void scan_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, int width, int height,
                   const Visit& visit) {
  const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  if (std::abs(area) < 1e-9) return;
  const int top = std::max(0, static_cast<int>(std::ceil(std::min({a[1], b[1], c[1]}) - 0.5)));
  const int bottom = std::min(height - 1, static_cast<int>(std::floor(std::max({a[1], b[1], c[1]}) - 0.5)));
  for (int row = top; row <= bottom; ++row) {
    const double y = row + 0.5;
    double from = std::numeric_limits<double>::infinity(), to = -from;
    for (const auto& [p, q] : {std::pair{&a, &b}, std::pair{&b, &c}, std::pair{&c, &a}}) {
      if ((y - (*p)[1]) * (y - (*q)[1]) > 0.0 || (*p)[1] == (*q)[1]) continue;
      const double x = (*p)[0] + ((*q)[0] - (*p)[0]) * (y - (*p)[1]) / ((*q)[1] - (*p)[1]);
      from = std::min(from, x);
      to = std::max(to, x);
    }
    const int first = std::max(0, static_cast<int>(std::ceil(from - 0.5)));
    const int last = std::min(width - 1, static_cast<int>(std::ceil(to - 0.5)) - 1);
    for (int column = first; column <= last; ++column) {
      const double x = column + 0.5;
      const double u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area,
                   v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
      visit(static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column),
            a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]));
    }
  }
}

template <typename Visit>
void scan(const ScreenPolygon& polygon, int width, int height, const Visit& visit) {
  for (Eigen::Index i = 2; i < polygon.corners.cols(); ++i)
    scan_triangle(polygon.corners.col(0), polygon.corners.col(i - 1), polygon.corners.col(i), width, height, visit);
}

using Pair = std::pair<std::uint32_t, std::uint32_t>;

/// (farther, nearer) of visible polygons that follow one another over a pixel, each pair once.
std::vector<Pair> covering(const std::vector<ScreenPolygon>& polygons, const std::vector<bool>& visible, int width,
                           int height) {
  struct Layer {
    std::uint32_t pixel;
    float depth;
    std::uint32_t polygon;
  };
  std::vector<Layer> layers;
  for (std::size_t i = 0; i < polygons.size(); ++i)
    if (visible[i])
      scan(polygons[i], width, height, [&](std::size_t pixel, double depth) {
        layers.push_back({static_cast<std::uint32_t>(pixel), static_cast<float>(depth), static_cast<std::uint32_t>(i)});
      });
  std::ranges::sort(layers, [](const Layer& a, const Layer& b) {
    return a.pixel != b.pixel ? a.pixel < b.pixel : a.depth > b.depth;
  });
  std::vector<Pair> pairs;
  for (std::size_t i = 1; i < layers.size(); ++i)
    if (layers[i].pixel == layers[i - 1].pixel && layers[i].polygon != layers[i - 1].polygon)
      pairs.emplace_back(layers[i - 1].polygon, layers[i].polygon);
  std::ranges::sort(pairs);
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
  return pairs;
}

}  // namespace

double ScreenDepth::at(double x, double y) const {
  if (!(x >= 0.0 && y >= 0.0 && x < width && y < height)) return std::numeric_limits<double>::infinity();
  return nearest[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
}

// A depth buffer: per pixel the nearest polygon. Polygons that are nearest nowhere are hidden and need not be drawn.
ScreenDepth screen_depth(const std::vector<ScreenPolygon>& polygons, int width, int height) {
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  ScreenDepth screen{.visible = std::vector<bool>(polygons.size(), false),
                     .nearest = std::vector<double>(pixels, std::numeric_limits<double>::infinity()),
                     .width = width,
                     .height = height};
  std::vector<std::int64_t> owner(pixels, -1);
  for (std::size_t i = 0; i < polygons.size(); ++i)
    scan(polygons[i], width, height, [&](std::size_t pixel, double depth) {
      if (depth >= screen.nearest[pixel]) return;
      screen.nearest[pixel] = depth;
      owner[pixel] = static_cast<std::int64_t>(i);
    });
  for (const auto i : owner)
    if (i >= 0) screen.visible[static_cast<std::size_t>(i)] = true;
  return screen;
}

// An order from back to front in which nothing is painted over what lies before it. Over each pixel the polygons are
// sorted by depth, which gives pairs (farther, nearer); a topological sort of these takes the farthest polygon that
// waits for none. Polygons that overlap in a ring have no such order: the farthest of those left breaks it.
std::vector<std::size_t> painters_order(const std::vector<ScreenPolygon>& polygons, const ScreenDepth& depth) {
  const auto& visible = depth.visible;
  const auto pairs = covering(polygons, visible, depth.width, depth.height);  // sorted by the farther one
  std::vector<int> waiting(polygons.size(), 0);
  for (const auto& [far, near] : pairs) ++waiting[near];
  using Entry = std::pair<double, std::size_t>;  // farthest first
  std::priority_queue<Entry> ready;
  std::vector<Entry> by_depth;
  for (std::size_t i = 0; i < polygons.size(); ++i) {
    if (!visible[i]) continue;
    by_depth.emplace_back(polygons[i].corners.row(2).mean(), i);
    if (waiting[i] == 0) ready.push(by_depth.back());
  }
  std::ranges::sort(by_depth, std::greater{});
  std::vector<bool> painted(polygons.size(), false);
  std::vector<std::size_t> order;
  std::size_t next = 0;  // in by_depth, to break rings
  while (order.size() < by_depth.size()) {
    if (ready.empty()) {
      while (painted[by_depth[next].second]) ++next;
      ready.push(by_depth[next]);
    }
    const std::size_t i = ready.top().second;
    ready.pop();
    if (painted[i]) continue;
    painted[i] = true;
    order.push_back(i);
    auto pair = std::ranges::lower_bound(pairs, Pair{static_cast<std::uint32_t>(i), 0});
    for (; pair != pairs.end() && pair->first == i; ++pair)
      if (--waiting[pair->second] == 0) ready.push({polygons[pair->second].corners.row(2).mean(), pair->second});
  }
  return order;
}

}  // namespace kalfem
