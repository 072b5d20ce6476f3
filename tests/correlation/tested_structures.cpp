// SPDX-License-Identifier: Apache-2.0
#include "correlation/tested_structures.hpp"

#include <cmath>

namespace kalfem::test {

using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

/// Numbers of degrees of freedom of nodes of which some are held; node n has those from `each` n on.
struct Numbering {
  int each;
  int held;  ///< nodes, the first ones
  [[nodiscard]] std::vector<int> of(const std::vector<int>& nodes) const {
    std::vector<int> dofs;
    for (const int node : nodes)
      for (int k = 0; k < each; ++k) dofs.push_back(node < held ? -1 : each * (node - held) + k);
    return dofs;
  }
};

std::vector<std::string> names_of(int held, int nodes, const std::vector<std::string>& motions) {
  std::vector<std::string> names;
  for (int node = held; node < nodes; ++node)
    for (const auto& motion : motions) names.push_back("n" + std::to_string(node + 1) + "." + motion);
  return names;
}

/// A beam of Euler and Bernoulli from one point to another of the plane: x, y and turn of its ends.
MatrixXd beam(const Eigen::Vector2d& along, double axial, double bending) {
  const double l = along.norm(), c = along.x() / l, s = along.y() / l, k = bending / (l * l * l);
  MatrixXd own(6, 6);
  const double e = axial / l;
  own << e, 0, 0, -e, 0, 0, 0, 12 * k, 6 * k * l, 0, -12 * k, 6 * k * l, 0, 6 * k * l, 4 * k * l * l, 0, -6 * k * l,
      2 * k * l * l, -e, 0, 0, e, 0, 0, 0, -12 * k, -6 * k * l, 0, 12 * k, -6 * k * l, 0, 6 * k * l, 2 * k * l * l, 0,
      -6 * k * l, 4 * k * l * l;
  MatrixXd turn = MatrixXd::Identity(6, 6);
  for (const int end : {0, 3}) turn.block<2, 2>(end, end) << c, s, -s, c;
  return turn.transpose() * own * turn;
}

/// w = sum p_i over the polynomial of the rectangle: 1, x, y, x^2, xy, y^2, x^3, x^2 y, x y^2, y^3, x^3 y, x y^3.
constexpr int powers[12][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2},
                               {3, 0}, {2, 1}, {1, 2}, {0, 3}, {3, 1}, {1, 3}};

/// The derivative of order (dx, dy) of each term at (x, y).
Eigen::RowVectorXd terms(double x, double y, int dx, int dy) {
  const auto one = [](double at, int power, int order) {
    double factor = 1.0;
    for (int k = 0; k < order; ++k) factor *= power - k;
    return power < order ? 0.0 : factor * std::pow(at, power - order);
  };
  Eigen::RowVectorXd row(12);
  for (int i = 0; i < 12; ++i) row[i] = one(x, powers[i][0], dx) * one(y, powers[i][1], dy);
  return row;
}

/// Corners (0, 0), (a, 0), (a, b), (0, b), each with w, w_y and -w_x: deflection and turns about x and y.
MatrixXd bent_rectangle(double a, double b, double rigidity, double poisson) {
  MatrixXd corners(12, 12), stiffness = MatrixXd::Zero(12, 12);
  const double x[] = {0, a, a, 0}, y[] = {0, 0, b, b};
  for (int i = 0; i < 4; ++i) {
    corners.row(3 * i) = terms(x[i], y[i], 0, 0);
    corners.row(3 * i + 1) = terms(x[i], y[i], 0, 1);
    corners.row(3 * i + 2) = -terms(x[i], y[i], 1, 0);
  }
  Eigen::Matrix3d D;
  D << 1, poisson, 0, poisson, 1, 0, 0, 0, 0.5 * (1.0 - poisson);
  const double gauss[] = {-std::sqrt(0.6), 0.0, std::sqrt(0.6)}, weights[] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double px = 0.5 * a * (1.0 + gauss[i]), py = 0.5 * b * (1.0 + gauss[j]);
      MatrixXd curvatures(3, 12);
      curvatures << terms(px, py, 2, 0), terms(px, py, 0, 2), 2.0 * terms(px, py, 1, 1);
      stiffness += 0.25 * a * b * weights[i] * weights[j] * rigidity * curvatures.transpose() * D * curvatures;
    }
  const MatrixXd inverse = corners.inverse();
  return inverse.transpose() * stiffness * inverse;
}

}  // namespace

LinearModel TestedStructure::model(const std::vector<double>& factors) const {
  const auto size = masses.size();
  MatrixXd stiffness = MatrixXd::Zero(size, size);
  for (std::size_t m = 0; m < members.size(); ++m) {
    const auto& [at, own] = members[m];
    for (std::size_t i = 0; i < at.size(); ++i)
      for (std::size_t j = 0; j < at.size(); ++j)
        if (at[i] >= 0 && at[j] >= 0)
          stiffness(at[i], at[j]) +=
              (factors.empty() ? 1.0 : factors[m]) * own(static_cast<int>(i), static_cast<int>(j));
  }
  LinearModel model;
  model.dofs = dofs;
  model.stiffness = SparseMatrix(stiffness.sparseView());
  model.mass = SparseMatrix(MatrixXd(masses.asDiagonal()).sparseView());
  model.damping = SparseMatrix(size, size);
  return model;
}

TestedStructure mast(int levels) {
  const int nodes = 3 * (levels + 1);
  const Numbering numbers{3, 3};
  TestedStructure made{.dofs = names_of(3, nodes, {"x", "y", "z"}), .axes = {"x", "y", "z"}};
  made.masses = Eigen::VectorXd::Constant(std::ssize(made.dofs), 20.0);
  std::vector<Vector3d> joints;
  for (int level = 0; level <= levels; ++level)
    for (int corner = 0; corner < 3; ++corner) {
      const double angle = 2.1 * corner + 0.15 * level, radius = 1.2 - 0.05 * level;
      joints.emplace_back(radius * std::cos(angle), 0.8 * radius * std::sin(angle), 1.1 * level + 0.1 * corner);
    }
  const auto bar = [&](int from, int to) {
    const Vector3d along = joints[static_cast<std::size_t>(to)] - joints[static_cast<std::size_t>(from)];
    Eigen::VectorXd stretch(6);
    stretch << -along.normalized(), along.normalized();
    made.members.push_back({numbers.of({from, to}), 2e6 / along.norm() * stretch * stretch.transpose()});
  };
  for (int level = 1; level <= levels; ++level)
    for (int corner = 0; corner < 3; ++corner) {
      const int joint = 3 * level + corner, next = 3 * level + (corner + 1) % 3;
      bar(joint, next);
      bar(joint, joint - 3);
      bar(joint, next - 3);
    }
  return made;
}

TestedStructure plane_frame(int storeys, int bays) {
  constexpr double EI = 20e6, EA = 2e9, of_beams = 200.0, of_columns = 80.0, inertia = 10.0;
  const int columns = bays + 1;
  std::vector<Eigen::Vector2d> nodes;
  for (int level = 0; level <= storeys; ++level)
    for (int column = 0; column < columns; ++column) nodes.emplace_back(5.0 * column, 3.0 * level);
  std::vector<std::array<int, 3>> parts;  // two nodes, and whether it is a beam
  const auto member = [&](int from, int to, bool is_beam) {
    const auto middle = static_cast<int>(nodes.size());
    nodes.emplace_back(0.5 * (nodes[static_cast<std::size_t>(from)] + nodes[static_cast<std::size_t>(to)]));
    parts.push_back({from, middle, is_beam});
    parts.push_back({middle, to, is_beam});
  };
  for (int level = 1; level <= storeys; ++level)
    for (int column = 0; column < columns; ++column) {
      member(columns * (level - 1) + column, columns * level + column, false);
      if (column < bays) member(columns * level + column, columns * level + column + 1, true);
    }
  const auto count = static_cast<int>(nodes.size());
  const Numbering numbers{3, columns};
  TestedStructure made{.dofs = names_of(columns, count, {"x", "y", "rz"}), .axes = {"x", "y"}};
  made.masses = Eigen::VectorXd::Zero(std::ssize(made.dofs));
  for (const auto& [from, to, is_beam] : parts) {
    const Eigen::Vector2d along = nodes[static_cast<std::size_t>(to)] - nodes[static_cast<std::size_t>(from)];
    made.members.push_back({numbers.of({from, to}), beam(along, EA, EI)});
    const double half = 0.5 * along.norm() * (is_beam ? of_beams : of_columns);
    for (const int node : {from, to})
      if (node >= columns) made.masses.segment<3>(3 * (node - columns)) += Vector3d(half, half, inertia);
  }
  return made;
}

TestedStructure plate(int along, int across) {
  constexpr double length = 1.2, width = 0.9, thickness = 0.01, E = 210e9, poisson = 0.3, density = 7850.0;
  const double rigidity = E * std::pow(thickness, 3) / (12.0 * (1.0 - poisson * poisson));
  const double a = length / along, b = width / across;
  const int row = across + 1, count = (along + 1) * row;
  const Numbering numbers{3, row};
  TestedStructure made{.dofs = names_of(row, count, {"z", "rx", "ry"}), .axes = {"z"}};
  made.masses = Eigen::VectorXd::Zero(std::ssize(made.dofs));
  const double quarter = 0.25 * density * thickness * a * b;
  const Vector3d of_corner = quarter * Vector3d(1.0, b * b / 12.0, a * a / 12.0);
  const MatrixXd own = bent_rectangle(a, b, rigidity, poisson);
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < across; ++j) {
      const std::vector<int> corners = {i * row + j, (i + 1) * row + j, (i + 1) * row + j + 1, i * row + j + 1};
      made.members.push_back({numbers.of(corners), own});
      for (const int node : corners)
        if (node >= row) made.masses.segment<3>(3 * (node - row)) += of_corner;
    }
  return made;
}

}  // namespace kalfem::test
