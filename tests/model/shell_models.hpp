// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/model/statics/statics.hpp"

namespace kalfem::test {

/// How the unit square (u, v) is cut into cells.
struct Cut {
  int count_u = 4;
  int count_v = 4;
  CellShape shape = CellShape::quadrilateral4;
  bool distorted = false;  ///< inner nodes moved by a fifth of a cell in a pattern of period three
};

/// A structured mesh of one region, "shell", over the image of the unit square.
struct GridMesh {
  Mesh mesh;
  Cut cut;

  [[nodiscard]] Eigen::Index node(int i, int j) const { return j * (cut.count_u + 1) + i; }
  /// Nodes at u = 0, u = 1, v = 0, v = 1.
  [[nodiscard]] std::vector<Eigen::Index> side(char coordinate, int end) const {
    std::vector<Eigen::Index> nodes;
    if (coordinate == 'u')
      for (int j = 0; j <= cut.count_v; ++j) nodes.push_back(node(end * cut.count_u, j));
    else
      for (int i = 0; i <= cut.count_u; ++i) nodes.push_back(node(i, end * cut.count_v));
    return nodes;
  }
  [[nodiscard]] std::vector<Eigen::Index> all() const {
    std::vector<Eigen::Index> nodes;
    for (Eigen::Index i = 0; i < mesh.node_count(); ++i) nodes.push_back(i);
    return nodes;
  }
};

inline std::pair<double, double> cut_place(const Cut& cut, int i, int j) {
  const bool inner = i > 0 && i < cut.count_u && j > 0 && j < cut.count_v;
  const double move = cut.distorted && inner ? 0.2 : 0.0;
  return {(i + move * ((i + 2 * j) % 3 - 1)) / cut.count_u, (j + move * ((2 * i + j + 1) % 3 - 1)) / cut.count_v};
}

using Surface = std::function<Eigen::Vector3d(double u, double v)>;

inline GridMesh grid_mesh(const Cut& cut, const Surface& surface) {
  GridMesh grid{{}, cut};
  Mesh& mesh = grid.mesh;
  mesh.source = "grid";
  mesh.nodes.resize(3, (cut.count_u + 1) * (cut.count_v + 1));
  for (int j = 0; j <= cut.count_v; ++j)
    for (int i = 0; i <= cut.count_u; ++i) {
      const auto [u, v] = cut_place(cut, i, j);
      mesh.nodes.col(grid.node(i, j)) = surface(u, v);
      mesh.node_ids.push_back(grid.node(i, j) + 1);
    }
  const auto add = [&](const std::vector<Eigen::Index>& nodes) {
    mesh.regions["shell"].push_back(mesh.add_cell(cut.shape, static_cast<std::int64_t>(mesh.cells.size()) + 1, nodes));
  };
  for (int j = 0; j < cut.count_v; ++j)
    for (int i = 0; i < cut.count_u; ++i) {
      const auto a = grid.node(i, j), b = grid.node(i + 1, j), c = grid.node(i + 1, j + 1), d = grid.node(i, j + 1);
      if (cut.shape == CellShape::quadrilateral4) {
        add({a, b, c, d});
      } else {
        add({a, b, c});
        add({a, c, d});
      }
    }
  return grid;
}

/// A shell of one material and thickness with supports and loads at nodes.
struct ShellProblem {
  GridMesh grid;
  FiniteElementModel model;
  std::vector<std::pair<NodalDof, double>> loads;

  ShellProblem(const Cut& cut, const Surface& surface, const IsotropicMaterial& material, double thickness)
      : grid(grid_mesh(cut, surface)) {
    model.name = "shell";
    model.mesh = grid.mesh;
    model.materials["material"] = material;
    model.properties["shell"] = ShellProperty{"material", thickness};
  }
  void fix(const std::vector<Eigen::Index>& nodes, const std::vector<int>& directions) {
    FixedNodes fixed{"support " + std::to_string(model.fixed.size() + 1), nodes, {}};
    fixed.directions.fill(false);
    for (const int direction : directions) fixed.directions[static_cast<std::size_t>(direction)] = true;
    model.fixed.push_back(fixed);
  }
  void load(Eigen::Index node, int direction, double value) { loads.push_back({{node, direction}, value}); }
  /// Spreads a force along a straight side of evenly spaced nodes.
  void load_side(const std::vector<Eigen::Index>& nodes, int direction, double total) {
    const double each = total / static_cast<double>(nodes.size() - 1);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      load(nodes[i], direction, i == 0 || i + 1 == nodes.size() ? 0.5 * each : each);
  }
  /// Gives each corner of a cell its part of a force per area.
  void load_area(int direction, double pressure) {
    for (const auto& cell : model.mesh.cells) {
      const auto nodes = model.mesh.nodes_of(cell);
      const auto corner = [&](std::size_t i) -> Eigen::Vector3d { return model.mesh.nodes.col(nodes[i]); };
      const std::size_t last = nodes.size() - 1;
      const Eigen::Vector3d one = corner(2) - corner(0), other = corner(last) - corner(1);
      for (const auto node : nodes)
        load(node, direction, pressure * 0.5 * one.cross(other).norm() / static_cast<double>(nodes.size()));
    }
  }
};

/// Displacements and rotations of all nodes, 6 to a node.
inline Eigen::VectorXd solve(const ShellProblem& problem) {
  LoadCase load{.name = "loads"};
  for (const auto& [dof, value] : problem.loads) {
    NodeLoad at{.node = dof.node};
    (dof.direction < 3 ? at.force : at.moment)[dof.direction % 3] = value;
    load.loads.push_back(at);
  }
  return solve_statics(problem.model, load).displacements;
}

inline double displacement(const ShellProblem& problem, Eigen::Index node, int direction) {
  return solve(problem)[6 * node + direction];
}

}  // namespace kalfem::test
