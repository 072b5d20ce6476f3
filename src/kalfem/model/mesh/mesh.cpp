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

double distance_to_nearest(const Mesh& mesh, Eigen::Index node) {
  double nearest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < mesh.node_count(); ++i)
    if (const double distance = (mesh.nodes.col(i) - mesh.nodes.col(node)).norm(); distance > 0.0)
      nearest = std::min(nearest, distance);
  return std::isfinite(nearest) ? nearest : 0.0;
}

}  // namespace

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

}  // namespace kalfem
