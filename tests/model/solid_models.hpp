// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/elements/solid.hpp"

namespace kalfem::test {

inline constexpr std::array solid_shapes = {CellShape::tetrahedron4, CellShape::tetrahedron10, CellShape::wedge6,
                                            CellShape::wedge15,      CellShape::hexahedron8,   CellShape::hexahedron20};
inline constexpr std::array solid_kinds = {SolidKind::standard, SolidKind::full, SolidKind::mean_dilatation,
                                           SolidKind::reduced};

inline std::string name_of(CellShape shape) {
  static const std::map<CellShape, std::string> names = {{CellShape::tetrahedron4, "tetrahedron4"},
                                                         {CellShape::tetrahedron10, "tetrahedron10"},
                                                         {CellShape::wedge6, "wedge6"},
                                                         {CellShape::wedge15, "wedge15"},
                                                         {CellShape::hexahedron8, "hexahedron8"},
                                                         {CellShape::hexahedron20, "hexahedron20"}};
  return names.at(shape);
}

inline std::string name_of(SolidKind kind) {
  static const std::map<SolidKind, std::string> names = {{SolidKind::standard, "standard"},
                                                         {SolidKind::full, "full"},
                                                         {SolidKind::mean_dilatation, "mean_dilatation"},
                                                         {SolidKind::reduced, "reduced"}};
  return names.at(kind);
}

/// Corners at the ends of a middle node, or twice the corner itself.
inline std::pair<int, int> ends_of(CellShape shape, int node) {
  const int corners = corner_count(shape);
  if (node < corners) return {node, node};
  const SolidNodes natural = natural_nodes(shape);
  for (int a = 0; a < corners; ++a)
    for (int b = 0; b < a; ++b)
      if ((0.5 * (natural.col(a) + natural.col(b)) - natural.col(node)).norm() < 1e-12) return {b, a};
  return {-1, -1};
}

/// How the unit cube (u, v, w) is cut: into boxes, each of one hexahedron, two wedges along w or six tetrahedra.
struct BoxCut {
  int u = 2, v = 2, w = 2;
  CellShape shape = CellShape::hexahedron8;
  double distortion = 0.0;  ///< shift of the inner nodes in parts of a box, in a pattern of period three
};

using Placement = std::function<Eigen::Vector3d(const Eigen::Vector3d& cube)>;

/// A mesh of one region, "solid", over the image of the unit cube, with the place of each node in the cube.
struct BoxMesh {
  BoxCut cut;
  Mesh mesh;
  Eigen::Matrix3Xd cube;

  /// Nodes with u, v or w = 0 or 1: axis 0 .. 2, end 0 or 1.
  [[nodiscard]] std::vector<Eigen::Index> side(int axis, double end) const {
    std::vector<Eigen::Index> nodes;
    for (Eigen::Index i = 0; i < cube.cols(); ++i)
      if (std::abs(cube(axis, i) - end) < 1e-9) nodes.push_back(i);
    return nodes;
  }
  [[nodiscard]] Eigen::Index at(double u, double v, double w) const {
    Eigen::Index nearest = 0;
    (cube.colwise() - Eigen::Vector3d(u, v, w)).colwise().squaredNorm().minCoeff(&nearest);
    return nearest;
  }
};

/// Cells of a box by its corners, numbered as those of a hexahedron.
inline std::vector<std::vector<int>> cells_of_box(CellShape shape) {
  switch (corner_count(shape)) {
    case 8:
      return {{0, 1, 2, 3, 4, 5, 6, 7}};
    case 6:
      return {{0, 1, 2, 4, 5, 6}, {0, 2, 3, 4, 6, 7}};
    default:
      return {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
  }
}

inline BoxMesh box_mesh(const BoxCut& cut, const Placement& placement) {
  using Key = std::array<int, 3>;  // twice the number of boxes before the node
  BoxMesh box{cut, {}, {}};
  box.mesh.source = "box";
  std::map<Key, Eigen::Index> known;
  std::vector<Eigen::Vector3d> cube;
  const auto corner = [&](const Key& key) {
    const std::array<int, 3> counts = {2 * cut.u, 2 * cut.v, 2 * cut.w};
    Eigen::Vector3d place;
    bool inner = true;
    for (std::size_t a = 0; a < 3; ++a) inner = inner && key[a] > 0 && key[a] < counts[a];
    const int i = key[0] / 2, j = key[1] / 2, k = key[2] / 2;
    const Key shift = {(i + 2 * j + k) % 3 - 1, (2 * i + j + k + 1) % 3 - 1, (i + j + 2 * k) % 3 - 1};
    for (std::size_t a = 0; a < 3; ++a)
      place[static_cast<Eigen::Index>(a)] = (key[a] + (inner ? 2.0 * cut.distortion * shift[a] : 0.0)) / counts[a];
    return place;
  };
  const auto node = [&](const Key& a, const Key& b) {
    const Key key = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
    const auto [place, is_new] = known.try_emplace(key, static_cast<Eigen::Index>(cube.size()));
    if (is_new) cube.push_back(0.5 * (corner(a) + corner(b)));
    return place->second;
  };
  for (int k = 0; k < cut.w; ++k)
    for (int j = 0; j < cut.v; ++j)
      for (int i = 0; i < cut.u; ++i)
        for (const auto& corners : cells_of_box(cut.shape)) {
          const auto key = [&](int own) -> Key {
            static constexpr Key bits[] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0},
                                           {0, 0, 2}, {2, 0, 2}, {2, 2, 2}, {0, 2, 2}};
            const Key& bit = bits[corners[static_cast<std::size_t>(own)]];
            return {2 * i + bit[0], 2 * j + bit[1], 2 * k + bit[2]};
          };
          std::vector<Eigen::Index> nodes;
          for (int n = 0; n < node_count(cut.shape); ++n) {
            const auto [a, b] = ends_of(cut.shape, n);
            nodes.push_back(node(key(a), key(b)));
          }
          const auto id = static_cast<std::int64_t>(box.mesh.cells.size()) + 1;
          box.mesh.regions["solid"].push_back(box.mesh.add_cell(cut.shape, id, nodes));
        }
  box.cube.resize(3, static_cast<Eigen::Index>(cube.size()));
  box.mesh.nodes.resize(3, box.cube.cols());
  for (Eigen::Index i = 0; i < box.cube.cols(); ++i) {
    box.cube.col(i) = cube[static_cast<std::size_t>(i)];
    box.mesh.nodes.col(i) = placement(box.cube.col(i));
    box.mesh.node_ids.push_back(i + 1);
  }
  return box;
}

/// Faces of a shape by their corners; a triangle has its last corner twice.
inline std::vector<std::array<int, 4>> faces_of(CellShape shape) {
  switch (corner_count(shape)) {
    case 8:
      return {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    case 6:
      return {{0, 2, 1, 1}, {3, 4, 5, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
    default:
      return {{0, 2, 1, 1}, {0, 1, 3, 3}, {1, 2, 3, 3}, {2, 0, 3, 3}};
  }
}

/// A solid of one material with supports and loads at nodes.
struct SolidProblem {
  BoxMesh box;
  FiniteElementModel model;
  Eigen::VectorXd forces;  ///< 6 to a node

  SolidProblem(const BoxCut& cut, const Placement& placement, const IsotropicMaterial& material,
               SolidKind kind = SolidKind::standard)
      : box(box_mesh(cut, placement)), forces(Eigen::VectorXd::Zero(6 * box.cube.cols())) {
    model.name = "solid";
    model.mesh = box.mesh;
    model.materials["material"] = material;
    model.properties["solid"] = SolidProperty{"material", kind};
  }

  void fix(const std::vector<Eigen::Index>& nodes, const std::vector<int>& directions) {
    FixedNodes fixed{"support " + std::to_string(model.fixed.size() + 1), nodes, {}};
    fixed.directions.fill(false);
    for (const int direction : directions) fixed.directions[static_cast<std::size_t>(direction)] = true;
    model.fixed.push_back(fixed);
  }

  /// Adds int N_i p dA over the faces that lie on a side of the cube; the traction p by place and outward normal [Pa].
  void load_side(int axis, double end,
                 const std::function<Eigen::Vector3d(const Eigen::Vector3d& x, const Eigen::Vector3d& normal)>& p) {
    for (const auto& cell : model.mesh.cells)
      for (const auto& face : faces_of(cell.shape)) {
        const auto nodes = model.mesh.nodes_of(cell);
        bool on_side = true;
        for (const int corner : face)
          on_side = on_side && std::abs(box.cube(axis, nodes[static_cast<std::size_t>(corner)]) - end) < 1e-9;
        if (on_side) load_face(cell, face, p);
      }
  }

private:
  template <typename Traction>
  void load_face(const Cell& cell, const std::array<int, 4>& face, const Traction& traction) {
    const auto nodes = model.mesh.nodes_of(cell);
    const SolidNodes places = model.mesh.nodes(Eigen::all, nodes), natural = natural_nodes(cell.shape);
    const SolidNodes corners = natural(Eigen::all, face);
    const std::array<double, 3> abscissae = {-std::sqrt(0.6), 0.0, std::sqrt(0.6)}, weights = {5 / 9., 8 / 9., 5 / 9.};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        const double a = abscissae[i], b = abscissae[j];
        const Eigen::Vector4d shape(0.25 * (1 - a) * (1 - b), 0.25 * (1 + a) * (1 - b), 0.25 * (1 + a) * (1 + b),
                                    0.25 * (1 - a) * (1 + b));
        const Eigen::Vector4d slope_a(-0.25 * (1 - b), 0.25 * (1 - b), 0.25 * (1 + b), -0.25 * (1 + b));
        const Eigen::Vector4d slope_b(-0.25 * (1 - a), -0.25 * (1 + a), 0.25 * (1 + a), 0.25 * (1 - a));
        const ShapeFunctions own = solid_shape_functions(cell.shape, corners * shape);
        const Eigen::Matrix3d tangents = places * own.slopes;
        const Eigen::Vector3d along_a = tangents * (corners * slope_a), along_b = tangents * (corners * slope_b);
        const Eigen::Vector3d area = weights[i] * weights[j] * along_a.cross(along_b);
        const Eigen::Vector3d force = area.norm() * traction(places * own.values, area.normalized());
        for (std::size_t n = 0; n < nodes.size(); ++n)
          forces.segment<3>(6 * nodes[n]) += own.values[static_cast<Eigen::Index>(n)] * force;
      }
  }
};

/// Displacements of all nodes, 6 to a node.
inline Eigen::VectorXd solve(const SolidProblem& problem) {
  const AssembledModel model = assemble(problem.model);
  const SparseFactor factor(evaluate(model.stiffness, model.parameters));
  return model.expansion * Eigen::VectorXd(factor.solve(Eigen::VectorXd(model.expansion.transpose() * problem.forces)));
}

}  // namespace kalfem::test
