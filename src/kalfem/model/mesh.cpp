#include "kalfem/model/mesh.hpp"

namespace kalfem {

int node_count(CellShape shape) {
  switch (shape) {
    case CellShape::point1:
      return 1;
    case CellShape::line2:
      return 2;
    case CellShape::triangle3:
      return 3;
    case CellShape::quadrilateral4:
      return 4;
  }
  return 0;
}

int dimension(CellShape shape) {
  switch (shape) {
    case CellShape::point1:
      return 0;
    case CellShape::line2:
      return 1;
    case CellShape::triangle3:
    case CellShape::quadrilateral4:
      return 2;
  }
  return 0;
}

std::string to_string(CellShape shape) {
  switch (shape) {
    case CellShape::point1:
      return "point";
    case CellShape::line2:
      return "line";
    case CellShape::triangle3:
      return "triangle";
    case CellShape::quadrilateral4:
      return "quadrilateral";
  }
  return "";
}

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

}  // namespace kalfem
