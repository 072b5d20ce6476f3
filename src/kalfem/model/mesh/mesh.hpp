// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace kalfem {

/// Shapes of cells. Nodes are ordered as Abaqus and, but for wedges, VTK order them: the corners (counter-clockwise; of
/// a solid the first face seen from inside, then the opposite one; of a tetrahedron the apex last), then the middles of
/// the sides: of the first face from its first corner on, of the opposite face, and last of the sides between them.
enum class CellShape {
  point1,
  line2,
  line3,
  triangle3,
  triangle6,
  quadrilateral4,
  quadrilateral8,
  tetrahedron4,
  tetrahedron10,
  wedge6,
  wedge15,
  hexahedron8,
  hexahedron20
};

int node_count(CellShape shape);
/// Nodes at corners, which come first.
int corner_count(CellShape shape);
int dimension(CellShape shape);
std::string to_string(CellShape shape);

/// One cell of a mesh. Its nodes stand in the mesh's connectivity from `first` on.
struct Cell {
  CellShape shape = CellShape::point1;
  std::int64_t id = 0;     ///< the file's number
  Eigen::Index first = 0;  ///< position in the connectivity
};

/// Nodes and cells with the numbers of the file they came from, and named groups of both.
struct Mesh {
  std::string source;                  ///< file, for messages
  std::vector<std::int64_t> node_ids;  ///< the file's numbers
  Eigen::Matrix3Xd nodes;              ///< coordinates [m]
  std::vector<Cell> cells;
  std::vector<Eigen::Index> connectivity;                              ///< indices of nodes, cell after cell
  std::map<std::string, std::vector<Eigen::Index>> regions;            ///< indices of cells
  std::map<std::string, std::vector<Eigen::Index>> node_sets;          ///< indices of nodes
  std::map<std::string, std::vector<Eigen::Index>> element_sets = {};  ///< indices of cells, beside the regions
  std::map<Eigen::Index, Eigen::Matrix3d> axes = {};  ///< of nodes whose motions are not along global axes: columns

  [[nodiscard]] Eigen::Matrix3d axes_of(Eigen::Index node) const {
    const auto own = axes.find(node);
    return own == axes.end() ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : own->second;
  }
  [[nodiscard]] Eigen::Index node_count() const { return nodes.cols(); }
  [[nodiscard]] std::span<const Eigen::Index> nodes_of(const Cell& cell) const {
    return {connectivity.data() + cell.first, static_cast<std::size_t>(kalfem::node_count(cell.shape))};
  }
  /// Appends a cell and returns its index.
  Eigen::Index add_cell(CellShape shape, std::int64_t id, std::span<const Eigen::Index> cell_nodes);
};

/// Finds nodes by the file's numbers.
class NodeFinder {
public:
  explicit NodeFinder(const Mesh& mesh);
  /// Index of the node, -1 where there is none.
  [[nodiscard]] Eigen::Index find(std::int64_t id) const;

private:
  std::unordered_map<std::int64_t, Eigen::Index> index_;
};

/// The node nearest to a place.
Eigen::Index nearest_node(const Mesh& mesh, const Eigen::Vector3d& place);

/// Size of the elements at each of the nodes: the largest distance from the node to another node of a cell that it is a
/// corner or a middle of [m]. A node without such a cell, as of matrices, a mass or the hub of a rigid link, has the
/// distance to the nearest node at another place. 0 where there is none.
std::vector<double> element_sizes(const Mesh& mesh, std::span<const Eigen::Index> nodes);

/// Corners of a face or a surface, by their places in the cell, in order around it.
struct CornerRing {
  std::array<int, 4> corners = {};
  int count = 0;
  [[nodiscard]] std::span<const int> places() const { return {corners.data(), static_cast<std::size_t>(count)}; }
};

/// Faces of a cell by its corners: of a solid all, counter-clockwise seen from outside; of a surface itself; none of
/// lines and points.
std::span<const CornerRing> corner_rings(CellShape shape);

/// Sides between corners, each once.
std::span<const std::array<int, 2>> corner_sides(CellShape shape);

/// The three corners that sides of a solid lead to from each corner, so ordered that their edges have a positive triple
/// product in a cell that is not turned inside out. None of other cells.
std::span<const std::array<int, 3>> corner_neighbours(CellShape shape);

/// Places of the corners, 3 x corners.
Eigen::Matrix3Xd corner_places(const Mesh& mesh, const Cell& cell);

/// Length, area or volume of a cell by its corners; 0 of a point. The volume of a cell that is turned inside out is
/// negative.
double cell_measure(const Mesh& mesh, const Cell& cell);

}  // namespace kalfem
