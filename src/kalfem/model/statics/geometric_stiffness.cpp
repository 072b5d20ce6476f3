// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/statics/geometric_stiffness.hpp"

#include <array>
#include <cmath>

#include "kalfem/model/elements/solid.hpp"
#include "kalfem/model/statics/bar_preload.hpp"
#include "kalfem/model/statics/rotation.hpp"
#include "kalfem/model/statics/statics.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

Eigen::Matrix3d tensor(const Stress& s) {
  return Eigen::Matrix3d{{s[0], s[3], s[5]}, {s[3], s[1], s[4]}, {s[5], s[4], s[2]}};
}

/// sum_p V_p grad N_i . sigma_p grad N_j, nodes x nodes: the same for the motions along x, y and z. The stress is
/// linear between the corners, and so are its values at the nodes.
MatrixXd solid_shares(CellShape shape, const Eigen::Matrix3Xd& places, const LayerStress& stress) {
  const auto& rule = integration_rule(shape, RulePurpose::strain);
  const auto points = solid_points(rule, places);
  MatrixXd shares = MatrixXd::Zero(places.cols(), places.cols());
  for (std::size_t i = 0; i < rule.size(); ++i) {
    const Stress here = stress.at_nodes * rule[i].functions.values;
    shares += points[i].volume * points[i].gradients * tensor(here) * points[i].gradients.transpose();
  }
  return shares;
}

/// int grad N_i . n grad N_j dA of a flat triangle or a quadrilateral, whose corners stand in its plane, 2 x corners.
MatrixXd shell_shares(const Eigen::Matrix2Xd& corners, const Eigen::Matrix2d& forces) {
  const double g = 1.0 / std::sqrt(3.0);
  const bool is_triangle = corners.cols() == 3;
  const std::vector<Eigen::Vector2d> points = is_triangle
                                                  ? std::vector<Eigen::Vector2d>{{0.0, 0.0}}
                                                  : std::vector<Eigen::Vector2d>{{-g, -g}, {g, -g}, {g, g}, {-g, g}};
  MatrixXd shares = MatrixXd::Zero(corners.cols(), corners.cols());
  for (const auto& at : points) {
    const double r = at.x(), s = at.y();
    Eigen::MatrixX2d slopes(corners.cols(), 2);
    if (is_triangle)
      slopes << -1.0, -1.0, 1.0, 0.0, 0.0, 1.0;
    else
      slopes << s - 1.0, r - 1.0, 1.0 - s, -1.0 - r, 1.0 + s, 1.0 + r, -1.0 - s, 1.0 - r;
    if (!is_triangle) slopes *= 0.25;
    const Eigen::Matrix2d jacobian = corners * slopes;
    const Eigen::MatrixX2d gradients = slopes * jacobian.inverse();
    const double area = (is_triangle ? 0.5 : 1.0) * std::abs(jacobian.determinant());
    shares += area * gradients * forces * gradients.transpose();
  }
  return shares;
}

/// The same shares for x, y and z of nodes with so many motions.
MatrixXd in_three_directions(const MatrixXd& shares, Index motions) {
  MatrixXd all = MatrixXd::Zero(motions * shares.rows(), motions * shares.cols());
  for (Index i = 0; i < shares.rows(); ++i)
    for (Index j = 0; j < shares.cols(); ++j)
      all.block<3, 3>(motions * i, motions * j).diagonal().setConstant(shares(i, j));
  return all;
}

double offset_of(const RegionProperty& property) {
  if (const auto* shell = std::get_if<ShellProperty>(&property)) return shell->offset;
  return std::get<LaminateProperty>(property).offset;
}

/// Adds up the elements of a model.
class Sum {
public:
  explicit Sum(const FiniteElementModel& model) : model_(model) {}

  void add_solid(const CellStress& stress) {
    const auto& own = cell(stress.cell);
    add(own, in_three_directions(solid_shares(own.shape, places(own), stress.layers.front()), 3), 3);
  }

  void add_shell(const ShellResultants& resultants, double offset) {
    const auto& own = cell(resultants.cell);
    const Eigen::Matrix2Xd corners = resultants.axes.topRows<2>() * places(own);
    const auto& n = resultants.values;
    const Eigen::Matrix2d forces{{n[0], n[2]}, {n[2], n[1]}};
    ElementMatrices matrices{.stiffness = {{{}, in_three_directions(shell_shares(corners, forces), 6)}}, .mass = {}};
    const Eigen::Vector3d arm = offset * resultants.axes.row(2).transpose();
    if (offset != 0.0) carry_to_nodes(matrices, arm.replicate(1, corners.cols()));
    add(own, matrices.stiffness.front().matrix, 6);
  }

  void add_beam(const BeamStress& stress, const BeamProperty& property, std::size_t place) {
    const auto& own = cell(stress.cell);
    const double nu = model_.materials.at(property.material).poissons_ratio;
    const double axial = 0.5 * (stress.ends[0][0] + stress.ends[1][0]);
    add(own, beam_geometric_stiffness(places(own), property, property.placement(place), nu, axial), 6);
  }

  [[nodiscard]] Eigen::SparseMatrix<double> matrix() const {
    Eigen::SparseMatrix<double> sum(6 * model_.mesh.node_count(), 6 * model_.mesh.node_count());
    sum.setFromTriplets(entries_.begin(), entries_.end());
    return sum;
  }

private:
  [[nodiscard]] const Cell& cell(Index index) const { return model_.mesh.cells[static_cast<std::size_t>(index)]; }
  [[nodiscard]] Eigen::Matrix3Xd places(const Cell& own) const {
    return model_.mesh.nodes(Eigen::all, model_.mesh.nodes_of(own));
  }

  void add(const Cell& own, const MatrixXd& matrix, Index motions) {
    const auto nodes = model_.mesh.nodes_of(own);
    const auto row = [&](Index i) {
      return static_cast<int>(6 * nodes[static_cast<std::size_t>(i / motions)] + i % motions);
    };
    for (Index i = 0; i < matrix.rows(); ++i)
      for (Index j = 0; j < matrix.cols(); ++j)
        if (matrix(i, j) != 0.0) entries_.emplace_back(row(i), row(j), 0.5 * (matrix(i, j) + matrix(j, i)));
  }

  const FiniteElementModel& model_;
  std::vector<Eigen::Triplet<double>> entries_;
};

}  // namespace

Eigen::SparseMatrix<double> geometric_stiffness(const FiniteElementModel& model,
                                                const std::vector<RegionStress>& stresses) {
  Sum sum(model);
  for (const auto& region : stresses) {
    const auto& property = model.properties.at(region.region);
    if (std::holds_alternative<SolidProperty>(property))
      for (const auto& cell : region.cells) sum.add_solid(cell);
    for (const auto& resultants : region.resultants) sum.add_shell(resultants, offset_of(property));
    for (std::size_t i = 0; i < region.beams.size(); ++i)
      sum.add_beam(region.beams[i], std::get<BeamProperty>(property), i);
  }
  return sum.matrix();
}

Preload preload_of(const FiniteElementModel& model, const LoadCase& load_case) {
  const auto solution = solve_statics(model, load_case);
  const auto stresses = recover_stresses(model, solution.displacements, load_case.field(), load_case.beam_loads);
  Preload preload{
      .stiffness = geometric_stiffness(model, stresses) + bar_preload_stiffness(model, solution.displacements),
      .ignored = springs_without_preload(model, solution.displacements)};
  if (load_case.rotation) preload.stiffness += spin_softening(model, *load_case.rotation);
  return preload;
}

NodalMatrices preload_matrices(const FiniteElementModel& model, const LoadCase& load_case) {
  const SparseMatrix all = preload_of(model, load_case).stiffness;
  NodalMatrices matrices{.name = "preload", .dofs = {}, .stiffness = {}, .mass = {}, .damping = {}};
  std::vector<int> place(static_cast<std::size_t>(all.cols()), -1);
  std::vector<Eigen::Triplet<double>> entries;
  for (Index j = 0; j < all.cols(); ++j)
    if (SparseMatrix::InnerIterator(all, j)) {
      place[static_cast<std::size_t>(j)] = static_cast<int>(matrices.dofs.size());
      matrices.dofs.push_back({j / 6, static_cast<int>(j % 6)});
    }
  for (Index j = 0; j < all.cols(); ++j)
    for (SparseMatrix::InnerIterator it(all, j); it; ++it)
      entries.emplace_back(place[static_cast<std::size_t>(it.row())], place[static_cast<std::size_t>(j)], it.value());
  const auto size = static_cast<Index>(matrices.dofs.size());
  matrices.stiffness.resize(size, size);
  matrices.stiffness.setFromTriplets(entries.begin(), entries.end());
  return matrices;
}

SparseMatrix preload_stiffness(const FiniteElementModel& model, const LoadCase& load_case) {
  return preload_of(model, load_case).stiffness;
}

std::string ignored_preload(const std::string& load_case, const std::vector<std::string>& springs) {
  const std::string more = springs.size() > 1 ? " and " + std::to_string(springs.size() - 1) + " more" : "";
  return "the preload '" + load_case + "' leaves a force in the spring '" + springs.front() + "'" + more +
         ", which is ignored: the spring acts along a direction that does not turn with its nodes, so its force "
         "stiffens nothing; a truss or rod (T3D2, SPRINGA, CROD) in its place turns with them";
}

}  // namespace kalfem
