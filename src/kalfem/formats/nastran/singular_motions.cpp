// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "kalfem/formats/held_turns.hpp"
#include "kalfem/formats/nastran/model_building.hpp"
#include "kalfem/model/assembly/constraint_elimination.hpp"

namespace kalfem::nastran {
namespace {

/// Stiffness below this share of that along another direction counts as none.
constexpr double weakest = 1e-8;

/// What stiffens a node, per triple of motions: every direction, or a sum of a a^T over directions a.
class NodalStiffening {
public:
  explicit NodalStiffening(Eigen::Index nodes) : full_(static_cast<std::size_t>(2 * nodes), 0) {}

  void fill(Eigen::Index node, int block) { full_[static_cast<std::size_t>(2 * node + block)] = 1; }
  void add(Eigen::Index node, int block, const Eigen::Vector3d& direction) {
    auto& sum = partial_.try_emplace({node, block}, Eigen::Matrix3d::Zero()).first->second;
    if (direction.norm() > 0.0) sum += direction.normalized() * direction.normalized().transpose();
  }
  /// A motion that something moves with, stiff or not.
  void touch(Eigen::Index node, int block) { add(node, block, Eigen::Vector3d::Zero()); }

  [[nodiscard]] bool is_full(Eigen::Index node, int block) const {
    return full_[static_cast<std::size_t>(2 * node + block)] != 0;
  }
  [[nodiscard]] const auto& partial() const { return partial_; }

private:
  std::vector<char> full_;
  std::map<std::pair<Eigen::Index, int>, Eigen::Matrix3d> partial_;
};

void add_beam(NodalStiffening& stiffening, const FiniteElementModel& model, const Cell& cell,
              const BeamPlacement& placement) {
  const auto nodes = model.mesh.nodes_of(cell);
  bool hinged = false;
  for (const bool released : placement.released) hinged = hinged || released;
  const Eigen::Vector3d x = (model.mesh.nodes.col(nodes[1]) + placement.offsets.col(1) -
                             model.mesh.nodes.col(nodes[0]) - placement.offsets.col(0))
                                .normalized();
  const Eigen::Vector3d y = placement.up.cross(x).normalized(), z = x.cross(y);
  const std::array axes = {x, y, z};
  const auto& released = placement.released;
  // Without moments at both ends there is no force across.
  const bool no_moments = released[4] && released[10] && released[5] && released[11];
  for (std::size_t end = 0; end < 2; ++end) {
    if (!hinged || !placement.offsets.isZero(0.0)) {
      stiffening.fill(nodes[end], 0);
      stiffening.fill(nodes[end], 1);
      continue;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const bool pulls = i == 0 ? !released[0] && !released[6] : !no_moments && !released[6 * end + i];
      const bool turns = i == 0 ? !released[3] && !released[9] : !released[6 * end + 3 + i];
      stiffening.add(nodes[end], 0, pulls ? axes[i] : Eigen::Vector3d::Zero());
      stiffening.add(nodes[end], 1, turns ? axes[i] : Eigen::Vector3d::Zero());
    }
  }
}

void add_terms(NodalStiffening& stiffening, const DofSum& terms, bool stiff) {
  std::map<std::pair<Eigen::Index, int>, Eigen::Vector3d> parts;
  for (const auto& [dof, coefficient] : terms)
    parts.try_emplace({dof.node, dof.direction / 3}, Eigen::Vector3d::Zero()).first->second[dof.direction % 3] +=
        coefficient;
  for (const auto& [place, part] : parts)
    stiffening.add(place.first, place.second, stiff ? part : Eigen::Vector3d::Zero());
}

NodalStiffening stiffening_of(const FiniteElementModel& model) {
  NodalStiffening stiffening(model.mesh.node_count());
  for (const auto& [region, property] : model.properties) {
    const auto& cells = model.mesh.regions.at(region);
    const auto* beam = std::get_if<BeamProperty>(&property);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto& cell = model.mesh.cells[static_cast<std::size_t>(cells[i])];
      if (beam != nullptr)
        add_beam(stiffening, model, cell, beam->placement(i));
      else
        for (const auto node : model.mesh.nodes_of(cell))
          for (int block = 0; block < motions_per_node(property) / 3; ++block) stiffening.fill(node, block);
    }
  }
  for (const auto& mass : model.masses) {
    stiffening.touch(mass.node, 0);
    if (!mass.inertia.isZero(0.0) || !mass.offset.isZero(0.0)) stiffening.touch(mass.node, 1);
  }
  for (const auto& joint : model.joints) add_terms(stiffening, joint.deformation, joint.stiffness > 0.0);
  // Matrices are taken to stiffen what they reach, but for those of mass alone.
  for (const auto& item : model.matrices)
    for (std::size_t i = 0; i < item.dofs.size(); ++i) {
      const auto place = static_cast<Eigen::Index>(i);
      const bool stiff = item.stiffness.size() > 0 && item.stiffness.coeff(place, place) != 0.0;
      add_terms(stiffening, {{item.dofs[i], 1.0}}, stiff);
    }
  return stiffening;
}

/// Nodes that follow or lead others: their links may stiffen them.
std::vector<bool> linked_nodes(const FiniteElementModel& model) {
  std::vector<bool> linked(static_cast<std::size_t>(model.mesh.node_count()), false);
  const auto mark = [&](Eigen::Index node) { linked[static_cast<std::size_t>(node)] = true; };
  for (const auto& link : model.links) {
    mark(link.master);
    for (const auto slave : link.slaves) mark(slave);
  }
  for (const auto& link : model.weighted_links) {
    mark(link.follower);
    for (const auto& share : link.shares) mark(share.node);
  }
  for (const auto& constraint : model.constraints)
    for (const auto& [dof, coefficient] : constraint.terms) mark(dof.node);
  return linked;
}

/// A direction without stiffness that the model's supports hold is held in load cases with other supports too.
void hold_elsewhere(const Eigen::Matrix3d& sum, Eigen::Index node, int block, unsigned fixed,
                    const OtherSupports& others) {
  for (int i = 0; i < 3; ++i) {
    if (((fixed >> (3 * block + i)) & 1u) == 0 || !(sum.col(i).norm() <= weakest)) continue;
    FixedNodes held{"autospc", {node}, {}};
    held.directions[static_cast<std::size_t>(3 * block + i)] = true;
    for (auto* supports : others) supports->push_back(held);
  }
}

}  // namespace

/// The sum of a a^T over what stiffens the translations (rotations) of a node has an eigenvalue below 1e-8 for a
/// direction without stiffness; that motion is held, where the node hangs on no link or constraint and it is not held
/// already.
void apply_autospc(Building& building, const OtherSupports& others) {
  if (!building.bulk.autospc) return;
  auto& model = building.model;
  const auto stiffening = stiffening_of(model);
  const auto linked = linked_nodes(model);
  std::vector<unsigned char> fixed(linked.size(), 0);
  for (const auto& support : model.fixed)
    for (const auto node : support.nodes)
      for (std::size_t i = 0; i < 6; ++i)
        if (support.directions[i]) fixed[static_cast<std::size_t>(node)] |= static_cast<unsigned char>(1u << i);
  for (const auto& [place, sum] : stiffening.partial()) {
    const auto [node, block] = place;
    if (linked[static_cast<std::size_t>(node)] || stiffening.is_full(node, block) || building.is_scalar(node)) continue;
    hold_elsewhere(sum, node, block, fixed[static_cast<std::size_t>(node)], others);
    Eigen::Matrix3d held_sum = sum;
    for (int i = 0; i < 3; ++i)
      if (((fixed[static_cast<std::size_t>(node)] >> (3 * block + i)) & 1u) != 0) held_sum(i, i) += 1.0;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(held_sum);
    if (solver.eigenvalues()[0] > weakest) continue;
    building.note(building.bulk.grids[static_cast<std::size_t>(node)].where, "AUTOSPC",
                  "degrees of freedom without stiffness are fixed, as by PARAM AUTOSPC", DeckNoteKind::unused);
    ReducedEquations equations;
    for (int i = 0; i < 3; ++i) {
      if (solver.eigenvalues()[i] > weakest) continue;
      const Eigen::Vector3d direction = solver.eigenvectors().col(i);
      DofSum terms;
      for (int k = 0; k < 3; ++k)
        if (std::abs(direction[k]) > 1e-9) terms.push_back({NodalDof{node, 3 * block + k}, direction[k]});
      equations.add("autospc.n" + std::to_string(model.mesh.node_ids[static_cast<std::size_t>(node)]) + "." +
                        std::to_string(3 * block + i + 1),
                    terms);
    }
    equations.store(model);
  }
}

namespace {

/// Rotations about the normal that another subcase holds: released where the held direction is the normal, otherwise
/// left to the shells' own nodes. Returns how many.
std::size_t release_held(FiniteElementModel& model, const std::vector<NodalSurface>& surfaces,
                         std::vector<bool>& turned) {
  std::vector<NodalDof> along;
  for (const auto& dof : held_drilling(model, surfaces))
    if (!turned[static_cast<std::size_t>(dof.node)] && is_along_normal(surfaces, dof))
      along.push_back(dof);
    else
      turned[static_cast<std::size_t>(dof.node)] = true;
  release(model, along);
  return along.size();
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
void apply_k6rot(Building& building, const OtherSupports& others) {
  auto& model = building.model;
  auto turned = turned_by_others(model);
  const auto surfaces = nodal_surfaces(model);
  std::size_t released = release_turns_about_normal(model, surfaces, turned);
  for (auto* supports : others) {
    std::swap(model.fixed, *supports);
    released = std::max(released, release_held(model, surfaces, turned));
    std::swap(model.fixed, *supports);
  }
  if (released > 0)
    building.note({}, "fixed rotations of shells about their normal",
                  "Nastran shells have almost no stiffness there: at " + std::to_string(released) +
                      " nodes these rotations are left free, as in Nastran",
                  DeckNoteKind::unused);
  const auto own = separate_shells(model, surfaces, turned);
  MatrixGather springs;
  std::size_t count = 0;
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (own[i] < 0) continue;
    const DofSum turn = turn_between(static_cast<Eigen::Index>(i), own[i], surfaces[i]);
    springs.add(MatrixGather::stiffness, turn, turn, 1e-6 * building.bulk.drilling * surfaces[i].shear_stiffness);
    ++count;
  }
  if (count == 0) return;
  building.note({}, "rotations of shells about their normal (K6ROT)",
                "where shells meet beams, springs or links, " + std::to_string(count) +
                    " separate nodes leave these rotations nearly free, as in Nastran",
                DeckNoteKind::unused);
  if (building.bulk.drilling > 0.0) model.matrices.push_back(springs.finish("drilling"));
}

}  // namespace kalfem::nastran
