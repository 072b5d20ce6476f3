#include "kalfem/model/checks/model_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/model/mesh/cell_corners.hpp"

namespace kalfem {
namespace {

using Eigen::Vector3d;
using Corners = Eigen::Matrix3Xd;

constexpr double coinciding = 1e9;  ///< aspect ratio where a side has no length
constexpr std::size_t worst_cells_told = 5;

double degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

double angle_between(const Vector3d& a, const Vector3d& b) { return degrees(std::atan2(a.cross(b).norm(), a.dot(b))); }

/// Corners of a face that are different nodes, in order.
std::vector<Vector3d> distinct_corners(const Mesh& mesh, const Cell& cell, const CornerRing& ring) {
  const auto nodes = mesh.nodes_of(cell);
  std::vector<Eigen::Index> kept;
  for (const int place : ring.places()) {
    const auto node = nodes[static_cast<std::size_t>(place)];
    if (std::ranges::find(kept, node) == kept.end()) kept.push_back(node);
  }
  std::vector<Vector3d> places;
  for (const auto node : kept) places.emplace_back(mesh.nodes.col(node));
  return places;
}

double aspect_ratio(const Mesh& mesh, const Cell& cell) {
  const auto nodes = mesh.nodes_of(cell);
  double shortest = std::numeric_limits<double>::infinity(), longest = 0.0;
  for (const auto& [a, b] : corner_sides(cell.shape)) {
    const auto one = nodes[static_cast<std::size_t>(a)], other = nodes[static_cast<std::size_t>(b)];
    if (one == other) continue;
    const double length = (mesh.nodes.col(one) - mesh.nodes.col(other)).norm();
    shortest = std::min(shortest, length);
    longest = std::max(longest, length);
  }
  if (longest == 0.0) return coinciding;
  return std::min(longest / shortest, coinciding);
}

/// Angles at the corners of a face, widening the range.
void widen(const std::vector<Vector3d>& face, double& smallest, double& largest) {
  const std::size_t n = face.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3d next = face[(i + 1) % n] - face[i], last = face[(i + n - 1) % n] - face[i];
    const double angle = next.isZero(0.0) || last.isZero(0.0) ? 0.0 : angle_between(next, last);
    smallest = std::min(smallest, angle);
    largest = std::max(largest, angle);
  }
}

Vector3d corner_normal(const std::vector<Vector3d>& face, std::size_t corner) {
  const std::size_t n = face.size();
  return (face[(corner + 1) % n] - face[corner]).cross(face[(corner + n - 1) % n] - face[corner]);
}

double warp(const std::vector<Vector3d>& face) {
  if (face.size() < 4) return 0.0;
  return std::max(angle_between(corner_normal(face, 0), corner_normal(face, 2)),
                  angle_between(corner_normal(face, 1), corner_normal(face, 3)));
}

double taper(const std::vector<Vector3d>& face) {
  if (face.size() < 4) return 1.0;
  double least = std::numeric_limits<double>::infinity(), sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double area = corner_normal(face, i).norm();
    least = std::min(least, area);
    sum += area;
  }
  return sum > 0.0 ? 4.0 * least / sum : 0.0;
}

/// Of a surface, its corners seen from the side of its mean normal.
double surface_jacobian(const std::vector<Vector3d>& face) {
  const std::size_t n = face.size();
  if (n < 3) return 0.0;
  Vector3d normal = Vector3d::Zero();
  for (std::size_t i = 0; i < n; ++i) normal += corner_normal(face, i);
  normal.normalize();
  double least = 1.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double lengths = (face[(i + 1) % n] - face[i]).norm() * (face[(i + n - 1) % n] - face[i]).norm();
    least = std::min(least, lengths > 0.0 ? corner_normal(face, i).dot(normal) / lengths : 0.0);
  }
  return n == 3 ? least * 2.0 / std::numbers::sqrt3 : least;
}

double solid_jacobian(const Mesh& mesh, const Cell& cell) {
  const auto nodes = mesh.nodes_of(cell);
  const auto neighbours = corner_neighbours(cell.shape);
  const double ideal = neighbours.size() == 4   ? std::numbers::sqrt2
                       : neighbours.size() == 6 ? 2.0 / std::numbers::sqrt3
                                                : 1.0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t corner = 0; corner < neighbours.size(); ++corner) {
    Eigen::Matrix3d edges;
    bool collapsed = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto other = nodes[static_cast<std::size_t>(neighbours[corner][i])];
      collapsed |= other == nodes[corner];
      edges.col(static_cast<Eigen::Index>(i)) = mesh.nodes.col(other) - mesh.nodes.col(nodes[corner]);
    }
    // Two sides that lead to one node span nothing either.
    for (std::size_t i = 0; i < 3; ++i)
      collapsed |= nodes[static_cast<std::size_t>(neighbours[corner][i])] ==
                   nodes[static_cast<std::size_t>(neighbours[corner][(i + 1) % 3])];
    if (collapsed) continue;
    const double lengths = edges.colwise().norm().prod();
    least = std::min(least, lengths > 0.0 ? ideal * edges.determinant() / lengths : 0.0);
  }
  return std::isfinite(least) ? least : 0.0;
}

}  // namespace

std::string to_string(QualityMeasure measure) {
  constexpr std::array names = {"aspect ratio", "smallest angle", "largest angle", "warp", "taper", "scaled Jacobian"};
  return names[static_cast<std::size_t>(measure)];
}

bool is_worse_when_larger(QualityMeasure measure) {
  return measure == QualityMeasure::aspect_ratio || measure == QualityMeasure::largest_angle ||
         measure == QualityMeasure::warp;
}

CellQuality cell_quality(const Mesh& mesh, const Cell& cell) {
  double smallest = 180.0, largest = 0.0, most_warped = 0.0, most_tapered = 1.0, jacobian = 0.0;
  for (const auto& ring : corner_rings(cell.shape)) {
    const auto face = distinct_corners(mesh, cell, ring);
    if (face.size() < 3) continue;
    widen(face, smallest, largest);
    most_warped = std::max(most_warped, warp(face));
    most_tapered = std::min(most_tapered, taper(face));
    if (dimension(cell.shape) == 2) jacobian = surface_jacobian(face);
  }
  if (dimension(cell.shape) == 3) jacobian = solid_jacobian(mesh, cell);
  return {aspect_ratio(mesh, cell), std::min(smallest, largest), largest, most_warped, most_tapered, jacobian};
}

RegionQuality region_quality(const Mesh& mesh, const std::string& region, const QualityLimits& limits) {
  RegionQuality quality{.region = region, .cells = {}, .measures = {}};
  std::array<std::vector<std::pair<double, Eigen::Index>>, quality_measures> bad;
  for (int m = 0; m < quality_measures; ++m)
    quality.measures[static_cast<std::size_t>(m)].measure = static_cast<QualityMeasure>(m);
  const auto cells = mesh.regions.find(region);
  if (cells == mesh.regions.end()) return quality;
  for (const auto index : cells->second) {
    const Cell& cell = mesh.cells[static_cast<std::size_t>(index)];
    ++quality.cells[cell.shape];
    if (dimension(cell.shape) < 2) continue;
    const CellQuality values = cell_quality(mesh, cell);
    for (std::size_t m = 0; m < values.size(); ++m) {
      auto& of = quality.measures[m];
      const double sign = is_worse_when_larger(of.measure) ? 1.0 : -1.0;
      if (quality.measured == 0 || sign * values[m] > sign * of.worst) of.worst = values[m];
      of.mean += values[m];
      if (sign * values[m] <= sign * limits.limits[m]) continue;
      ++of.beyond;
      bad[m].emplace_back(-sign * values[m], index);
    }
    ++quality.measured;
  }
  for (std::size_t m = 0; m < bad.size(); ++m) {
    auto& of = quality.measures[m];
    if (quality.measured > 0) of.mean /= static_cast<double>(quality.measured);
    const auto told = std::min(worst_cells_told, bad[m].size());
    std::ranges::partial_sort(bad[m], bad[m].begin() + static_cast<std::ptrdiff_t>(told));
    for (std::size_t i = 0; i < told; ++i) of.worst_cells.push_back(bad[m][i].second);
  }
  return quality;
}

}  // namespace kalfem
