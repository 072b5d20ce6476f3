// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/mesh/mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace kalfem {

namespace {

struct ShapeTraits {
  int nodes, corners, dimension;
  const char* name;
};

const ShapeTraits& traits(CellShape shape) {
  static constexpr std::array<ShapeTraits, 13> all = {{{1, 1, 0, "point"},
                                                       {2, 2, 1, "line"},
                                                       {3, 2, 1, "3-node line"},
                                                       {3, 3, 2, "triangle"},
                                                       {6, 3, 2, "6-node triangle"},
                                                       {4, 4, 2, "quadrilateral"},
                                                       {8, 4, 2, "8-node quadrilateral"},
                                                       {4, 4, 3, "tetrahedron"},
                                                       {10, 4, 3, "10-node tetrahedron"},
                                                       {6, 6, 3, "wedge"},
                                                       {15, 6, 3, "15-node wedge"},
                                                       {8, 8, 3, "hexahedron"},
                                                       {20, 8, 3, "20-node hexahedron"}}};
  return all[static_cast<std::size_t>(shape)];
}

}  // namespace

int node_count(CellShape shape) { return traits(shape).nodes; }
int corner_count(CellShape shape) { return traits(shape).corners; }
int dimension(CellShape shape) { return traits(shape).dimension; }
std::string to_string(CellShape shape) { return traits(shape).name; }

Eigen::Index Mesh::add_cell(CellShape shape, std::int64_t id, std::span<const Eigen::Index> cell_nodes) {
  cells.push_back({shape, id, static_cast<Eigen::Index>(connectivity.size())});
  connectivity.insert(connectivity.end(), cell_nodes.begin(), cell_nodes.end());
  return static_cast<Eigen::Index>(cells.size()) - 1;
}

NodeFinder::NodeFinder(const Mesh& mesh) {
  index_.reserve(mesh.node_ids.size());
  for (std::size_t i = 0; i < mesh.node_ids.size(); ++i) index_[mesh.node_ids[i]] = static_cast<Eigen::Index>(i);
}

Eigen::Index NodeFinder::find(std::int64_t id) const {
  const auto found = index_.find(id);
  return found == index_.end() ? -1 : found->second;
}

Eigen::Index nearest_node(const Mesh& mesh, const Eigen::Vector3d& place) {
  Eigen::Index nearest = 0;
  (mesh.nodes.colwise() - place).colwise().squaredNorm().minCoeff(&nearest);
  return nearest;
}

namespace {

// Coincident nodes are passed over: they would give the size 0.
double distance_to_nearest(const Mesh& mesh, Eigen::Index node) {
  double nearest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < mesh.node_count(); ++i)
    if (const double distance = (mesh.nodes.col(i) - mesh.nodes.col(node)).norm(); distance > 0.0)
      nearest = std::min(nearest, distance);
  return std::isfinite(nearest) ? nearest : 0.0;
}

}  // namespace

// The size at a node is the longest distance to another node of the cells that meet there. Nodes of point cells or of
// none have no such distance and take that to the nearest node at another place.
std::vector<double> element_sizes(const Mesh& mesh, std::span<const Eigen::Index> nodes) {
  std::unordered_map<Eigen::Index, double> sizes;
  for (const auto node : nodes) sizes.emplace(node, 0.0);
  for (const auto& cell : mesh.cells) {
    const auto corners = mesh.nodes_of(cell);
    for (const auto corner : corners) {
      const auto wanted = sizes.find(corner);
      if (wanted == sizes.end()) continue;
      for (const auto other : corners)
        wanted->second = std::max(wanted->second, (mesh.nodes.col(other) - mesh.nodes.col(corner)).norm());
    }
  }
  for (auto& [node, size] : sizes)
    if (size == 0.0) size = distance_to_nearest(mesh, node);
  std::vector<double> result;
  for (const auto node : nodes) result.push_back(sizes.at(node));
  return result;
}

namespace {

// Faces of cells counter-clockwise from outside, sides between corners once each, and
// for a solid's corner its three neighbours in right-handed order.
constexpr std::array<CornerRing, 1> triangle = {{{{0, 1, 2}, 3}}};
constexpr std::array<CornerRing, 1> quadrilateral = {{{{0, 1, 2, 3}, 4}}};
constexpr std::array<CornerRing, 4> tetrahedron = {{{{0, 2, 1}, 3}, {{0, 1, 3}, 3}, {{1, 2, 3}, 3}, {{2, 0, 3}, 3}}};
constexpr std::array<CornerRing, 5> wedge = {
    {{{0, 2, 1}, 3}, {{3, 4, 5}, 3}, {{0, 1, 4, 3}, 4}, {{1, 2, 5, 4}, 4}, {{2, 0, 3, 5}, 4}}};
constexpr std::array<CornerRing, 6> hexahedron = {
    {{{0, 3, 2, 1}, 4}, {{4, 5, 6, 7}, 4}, {{0, 1, 5, 4}, 4}, {{1, 2, 6, 5}, 4}, {{2, 3, 7, 6}, 4}, {{3, 0, 4, 7}, 4}}};

using Side = std::array<int, 2>;
constexpr std::array<Side, 1> line_sides = {{{0, 1}}};
constexpr std::array<Side, 3> triangle_sides = {{{0, 1}, {1, 2}, {2, 0}}};
constexpr std::array<Side, 4> quadrilateral_sides = {{{0, 1}, {1, 2}, {2, 3}, {3, 0}}};
constexpr std::array<Side, 6> tetrahedron_sides = {{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
constexpr std::array<Side, 9> wedge_sides = {{{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}};
constexpr std::array<Side, 12> hexahedron_sides = {
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

using Three = std::array<int, 3>;
constexpr std::array<Three, 4> tetrahedron_neighbours = {{{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {0, 2, 1}}};
constexpr std::array<Three, 6> wedge_neighbours = {{{1, 2, 3}, {2, 0, 4}, {0, 1, 5}, {5, 4, 0}, {3, 5, 1}, {4, 3, 2}}};
constexpr std::array<Three, 8> hexahedron_neighbours = {
    {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7}, {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}}};

}  // namespace

// Corners come first in the connectivity of every shape, so a quadratic cell shares the tables of its linear one.
// The key joins dimension and number of corners: 23 is a triangle, 36 a wedge.
std::span<const CornerRing> corner_rings(CellShape shape) {
  switch (10 * dimension(shape) + corner_count(shape)) {
    case 23:
      return triangle;
    case 24:
      return quadrilateral;
    case 34:
      return tetrahedron;
    case 36:
      return wedge;
    case 38:
      return hexahedron;
    default:
      return {};
  }
}

std::span<const std::array<int, 2>> corner_sides(CellShape shape) {
  switch (10 * dimension(shape) + corner_count(shape)) {
    case 12:
      return line_sides;
    case 23:
      return triangle_sides;
    case 24:
      return quadrilateral_sides;
    case 34:
      return tetrahedron_sides;
    case 36:
      return wedge_sides;
    case 38:
      return hexahedron_sides;
    default:
      return {};
  }
}

std::span<const std::array<int, 3>> corner_neighbours(CellShape shape) {
  if (dimension(shape) != 3) return {};
  switch (corner_count(shape)) {
    case 4:
      return tetrahedron_neighbours;
    case 6:
      return wedge_neighbours;
    case 8:
      return hexahedron_neighbours;
    default:
      return {};
  }
}

Eigen::Matrix3Xd corner_places(const Mesh& mesh, const Cell& cell) {
  Eigen::Matrix3Xd places(3, corner_count(cell.shape));
  for (Eigen::Index i = 0; i < places.cols(); ++i)
    places.col(i) = mesh.nodes.col(mesh.nodes_of(cell)[static_cast<std::size_t>(i)]);
  return places;
}

// By the corners alone: a surface by triangles about the middle of its corners, a solid by pyramids from its centre
// over its faces.
double cell_measure(const Mesh& mesh, const Cell& cell) {
  const Eigen::Matrix3Xd places = corner_places(mesh, cell);
  if (dimension(cell.shape) == 1) return (places.col(1) - places.col(0)).norm();
  const Eigen::Vector3d centre = places.rowwise().mean();
  double sum = 0.0;
  for (const auto& ring : corner_rings(cell.shape)) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero(), area = Eigen::Vector3d::Zero();
    for (const int place : ring.places()) middle += places.col(place) / ring.count;
    for (int i = 0; i < ring.count; ++i) {
      const Eigen::Vector3d a = places.col(ring.corners[static_cast<std::size_t>(i)]) - middle,
                            b = places.col(ring.corners[static_cast<std::size_t>((i + 1) % ring.count)]) - middle;
      const Eigen::Vector3d part = 0.5 * a.cross(b);
      area += part;
      if (dimension(cell.shape) == 2) sum += part.norm();
    }
    if (dimension(cell.shape) == 3) sum += area.dot(middle - centre) / 3.0;
  }
  return sum;
}

}  // namespace kalfem
