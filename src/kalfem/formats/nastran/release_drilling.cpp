#include <algorithm>
#include <cmath>
#include <set>

#include "kalfem/formats/nastran/model_building.hpp"
#include "kalfem/formats/shell_surfaces.hpp"

namespace kalfem::nastran {
namespace {

/// The shells' own node moves with the given one but for the turn about the normal n: u' = u, and
/// theta'_i - theta_i = (n_i / n_p) (theta'_p - theta_p) with the largest component p of n.
void tie(FiniteElementModel& model, Eigen::Index node, Eigen::Index own, const Eigen::Vector3d& normal) {
  int largest = 0;
  normal.cwiseAbs().maxCoeff(&largest);
  const auto name = "drilling.n" + std::to_string(model.mesh.node_ids[static_cast<std::size_t>(node)]);
  for (int i = 0; i < 6; ++i) {
    if (i == 3 + largest) continue;
    MultiPointConstraint constraint{name + "." + std::to_string(i + 1), {{{own, i}, 1.0}, {{node, i}, -1.0}}};
    const double share = i < 3 ? 0.0 : normal[i - 3] / normal[largest];
    if (std::abs(share) > 1e-9) {
      constraint.terms.push_back({{own, 3 + largest}, -share});
      constraint.terms.push_back({{node, 3 + largest}, share});
    }
    model.constraints.push_back(std::move(constraint));
  }
}

/// Rotations about the normal that the deck holds: released where the held direction is the normal, otherwise left to
/// the shells' own nodes.
void release_held(Building& building, const std::vector<NodalSurface>& surfaces, std::vector<bool>& turned) {
  const auto held = held_drilling(building.model, surfaces);
  if (held.empty()) return;
  std::vector<NodalDof> along;
  std::set<Eigen::Index> nodes;
  for (const auto& dof : held) {
    nodes.insert(dof.node);
    if (!turned[static_cast<std::size_t>(dof.node)] && is_along_normal(surfaces, dof))
      along.push_back(dof);
    else
      turned[static_cast<std::size_t>(dof.node)] = true;
  }
  release(building.model, along);
  building.note(building.bulk.grids[static_cast<std::size_t>(held.front().node)].where,
                "held rotations of shells about their normal",
                "shells of Nastran have next to no stiffness there: at " + std::to_string(nodes.size()) +
                    " nodes the shells turn freely, as they do in Nastran");
}

}  // namespace

/// Shells of Nastran have no stiffness against turns about their normal but PARAM K6ROT: what else stands on such a
/// node turns there almost freely. Shells here carry these turns. Where shells of one surface meet beams, springs or
/// links, they get a node of their own at the same place, which follows in all but the turn about the normal, and the
/// spring
///     k = 1e-6 K6ROT sum G t |J|
/// between both turns [Cab], J being the Jacobian of the shape functions: |J| = A / 4 of a quadrilateral and 2 A of a
/// triangle. Of a triangle no manual says it; with 2 A the modes of ribs that end in triangles are those that Nastran
/// prints (the Pazy wing).
///
/// Decks of plane shells hold these turns everywhere (GRDSET or SPC of 6), as the matrix is singular otherwise. Here
/// the turn of a node follows the turn of the surface, so that holding it would hold the surface itself against turning
/// in its plane: such turns are released. Nodes that are held in that plane, as at clamped edges and planes of
/// symmetry, keep theirs.
void release_drilling(Building& building) {
  auto& model = building.model;
  auto turned = turned_by_others(model);
  const auto surfaces = nodal_surfaces(model);
  release_held(building, surfaces, turned);
  std::vector<Eigen::Index> own(turned.size(), -1);
  std::vector<Eigen::Vector3d> places;
  auto& mesh = model.mesh;
  const std::int64_t largest =
      mesh.node_ids.empty() ? 0 : *std::max_element(mesh.node_ids.begin(), mesh.node_ids.end());
  MatrixGather springs;
  for (std::size_t i = 0; i < turned.size(); ++i) {
    const auto& surface = surfaces[i];
    if (!turned[i] || !surface.is_surface()) continue;
    const auto node = static_cast<Eigen::Index>(i);
    own[i] = static_cast<Eigen::Index>(turned.size() + places.size());
    places.emplace_back(mesh.nodes.col(node));
    mesh.node_ids.push_back(largest + static_cast<std::int64_t>(places.size()));
    const Eigen::Vector3d normal = surface.normal.normalized();
    tie(model, node, own[i], normal);
    DofSum turn;
    for (int k = 0; k < 3; ++k)
      if (std::abs(normal[k]) > 1e-9) {
        turn.push_back({{own[i], 3 + k}, normal[k]});
        turn.push_back({{node, 3 + k}, -normal[k]});
      }
    springs.add(MatrixGather::stiffness, turn, turn, 1e-6 * building.bulk.drilling * surface.shear_stiffness);
  }
  if (places.empty()) return;
  building.note({}, "rotations of shells about their normal (K6ROT)",
                "where shells meet beams, springs or links, " + std::to_string(places.size()) +
                    " nodes of their own leave these rotations nearly free, as Nastran does");
  mesh.nodes.conservativeResize(3, mesh.nodes.cols() + static_cast<Eigen::Index>(places.size()));
  mesh.nodes.rightCols(static_cast<Eigen::Index>(places.size())) =
      Eigen::Map<const Eigen::Matrix3Xd>(places.front().data(), 3, static_cast<Eigen::Index>(places.size()));
  for_each_shell(model, [&](const Cell& cell, const Eigen::Vector3d&, double) {
    for (int i = 0; i < node_count(cell.shape); ++i) {
      auto& node = mesh.connectivity[static_cast<std::size_t>(cell.first + i)];
      if (node < static_cast<Eigen::Index>(own.size()) && own[static_cast<std::size_t>(node)] >= 0)
        node = own[static_cast<std::size_t>(node)];
    }
  });
  if (building.bulk.drilling > 0.0) model.matrices.push_back(springs.finish("drilling"));
}

}  // namespace kalfem::nastran
