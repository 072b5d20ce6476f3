// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "kalfem/model/linear_model.hpp"

namespace kalfem::lattice {

inline SparseMatrix from(Eigen::Index size, const std::vector<Eigen::Triplet<double>>& entries) {
  SparseMatrix matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// Masses 1 at the nodes of a columns x rows grid, each with motion across the plane; springs of stiffness k between
/// neighbours (a membrane), a little irregular so that no frequency is double, and dashpots 1e-4 k beside them.
/// Names "x_y". `support` is a spring to the ground "ground" at every node of the first column.
struct Membrane {
  Eigen::Index columns = 10, rows = 10;
  double stiffness = 1e4;
  double support = 0.0;
  std::string prefix = {};
};

inline LinearModel model(const Membrane& given) {
  LinearModel model;
  std::vector<Eigen::Triplet<double>> mass, damping, stiffness;
  const Eigen::Index n = given.columns * given.rows;
  const auto spring = [&](Eigen::Index a, Eigen::Index b) {
    const double k = given.stiffness * (1.0 + 0.3 * std::sin(1.7 * double(a) + 0.6 * double(b)));
    for (const auto& [i, j, sign] : {std::tuple{a, a, 1.0}, {b, b, 1.0}, {a, b, -1.0}, {b, a, -1.0}}) {
      stiffness.emplace_back(i, j, sign * k);
      damping.emplace_back(i, j, 1e-4 * sign * k);
    }
  };
  GroundCoupling ground{"ground", Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n)};
  for (Eigen::Index x = 0; x < given.columns; ++x)
    for (Eigen::Index y = 0; y < given.rows; ++y) {
      const Eigen::Index node = x * given.rows + y;
      model.dofs.push_back(given.prefix + std::to_string(x) + "_" + std::to_string(y));
      mass.emplace_back(node, node, 1.0 + 0.1 * std::cos(double(node)));
      if (x + 1 < given.columns) spring(node, node + given.rows);
      if (y + 1 < given.rows) spring(node, node + 1);
      if (x > 0 || given.support == 0.0) continue;
      stiffness.emplace_back(node, node, given.support);
      ground.stiffness[node] = given.support;
    }
  model.mass = from(n, mass);
  model.damping = from(n, damping);
  model.stiffness = from(n, stiffness);
  if (given.support > 0.0) model.grounds.push_back(ground);
  return model;
}

/// Free plane beam of Euler-Bernoulli elements with consistent mass: names "<node>.y" and "<node>.rz".
inline LinearModel beam(Eigen::Index elements) {
  const double l = 1.0 / double(elements), EI = 100.0, m = 2.0 * l;
  const Eigen::Matrix4d k = EI / (l * l * l) *
                            Eigen::Matrix4d{{12, 6 * l, -12, 6 * l},
                                            {6 * l, 4 * l * l, -6 * l, 2 * l * l},
                                            {-12, -6 * l, 12, -6 * l},
                                            {6 * l, 2 * l * l, -6 * l, 4 * l * l}};
  const Eigen::Matrix4d consistent = m / 420.0 *
                                     Eigen::Matrix4d{{156, 22 * l, 54, -13 * l},
                                                     {22 * l, 4 * l * l, 13 * l, -3 * l * l},
                                                     {54, 13 * l, 156, -22 * l},
                                                     {-13 * l, -3 * l * l, -22 * l, 4 * l * l}};
  std::vector<Eigen::Triplet<double>> mass, stiffness;
  for (Eigen::Index e = 0; e < elements; ++e)
    for (Eigen::Index i = 0; i < 4; ++i)
      for (Eigen::Index j = 0; j < 4; ++j) {
        stiffness.emplace_back(2 * e + i, 2 * e + j, k(i, j));
        mass.emplace_back(2 * e + i, 2 * e + j, consistent(i, j));
      }
  LinearModel model;
  for (Eigen::Index node = 0; node <= elements; ++node) {
    model.dofs.push_back(std::to_string(node) + ".y");
    model.dofs.push_back(std::to_string(node) + ".rz");
  }
  const Eigen::Index n = 2 * (elements + 1);
  model.mass = from(n, mass);
  model.stiffness = from(n, stiffness);
  model.damping = SparseMatrix(n, n);
  return model;
}

/// Names of the nodes of a column.
inline std::vector<std::string> edge(Eigen::Index column, Eigen::Index rows, const std::string& prefix = {}) {
  std::vector<std::string> names;
  for (Eigen::Index y = 0; y < rows; ++y) names.push_back(prefix + std::to_string(column) + "_" + std::to_string(y));
  return names;
}

}  // namespace kalfem::lattice
