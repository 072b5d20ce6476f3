#include <Eigen/Eigenvalues>

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

}  // namespace

/// The sum of a a^T over what stiffens the translations (rotations) of a node has an eigenvalue below 1e-8 for a
/// direction without stiffness; that motion is held, where the node hangs on no link or constraint and it is not held
/// already.
void hold_singular_motions(Building& building) {
  if (!building.bulk.hold_singular) return;
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
    Eigen::Matrix3d held_sum = sum;
    for (int i = 0; i < 3; ++i)
      if (((fixed[static_cast<std::size_t>(node)] >> (3 * block + i)) & 1u) != 0) held_sum(i, i) += 1.0;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(held_sum);
    if (solver.eigenvalues()[0] > weakest) continue;
    building.note(building.bulk.grids[static_cast<std::size_t>(node)].where, "AUTOSPC",
                  "motions of nodes without any stiffness are held, as PARAM AUTOSPC does");
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

}  // namespace kalfem::nastran
