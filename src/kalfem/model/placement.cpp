// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/placement.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "kalfem/model/assembly/rigid_motion.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Directions = std::array<bool, 6>;

/// All or none of the translations, and all or none of the rotations: these are the same in any axes.
bool is_whole(const Directions& directions) {
  const auto alike = [&](std::size_t first) {
    return directions[first] == directions[first + 1] && directions[first] == directions[first + 2];
  };
  return alike(0) && alike(3);
}
bool is_whole(const RigidLink& link) { return is_whole(link.tied); }
bool is_whole(const WeightedLink& link) {
  return is_whole(link.tied) &&
         std::ranges::all_of(link.shares, [](const auto& share) { return is_whole(share.directions); });
}

/// What a link ties a degree of freedom to, as a constraint.
MultiPointConstraint constraint_of(const auto& link, const Mesh& mesh, const NodalDof& dof, const DofSum& motion) {
  MultiPointConstraint constraint{link.name + "." + dof_name(mesh, dof), {{dof, 1.0}}, link.where};
  for (const auto& [lead, share] : motion) constraint.terms.emplace_back(lead, -share);
  return constraint;
}

void add_constraints_of(const RigidLink& link, const Mesh& mesh, std::vector<MultiPointConstraint>& constraints) {
  for (const Index slave : link.slaves) {
    const Vector3d arm = mesh.nodes.col(slave) - mesh.nodes.col(link.master);
    for (int direction = 0; direction < 6; ++direction)
      if (link.tied[static_cast<std::size_t>(direction)])
        constraints.push_back(constraint_of(link, mesh, {slave, direction}, slave_motion(link.master, direction, arm)));
  }
}

void add_constraints_of(const WeightedLink& link, const Mesh& mesh, std::vector<MultiPointConstraint>& constraints) {
  const MeanMotion mean(mesh, link);
  for (int direction = 0; direction < 6; ++direction)
    if (link.tied[static_cast<std::size_t>(direction)])
      constraints.push_back(constraint_of(link, mesh, {link.follower, direction}, mean.follower_motion(direction)));
}

/// Links that tie single directions become constraints.
template <class Link>
void write_as_constraints(std::vector<Link>& links, const Mesh& mesh, std::vector<MultiPointConstraint>& constraints) {
  for (const auto& link : links)
    if (!is_whole(link)) add_constraints_of(link, mesh, constraints);
  std::erase_if(links, [](const Link& link) { return !is_whole(link); });
}

/// dof - shares . (translations or rotations of the leader) = 0, between a node and its local one.
MultiPointConstraint following(const Mesh& mesh, const NodalDof& dof, Index leader, const Vector3d& shares) {
  const NodalDof own{std::max(dof.node, leader), dof.direction};  // local nodes are behind all others
  MultiPointConstraint constraint{"axes." + dof_name(mesh, own), {{dof, 1.0}}};
  for (int along = 0; along < 3; ++along)
    if (shares[along] != 0.0) constraint.terms.push_back({{leader, dof.direction / 3 * 3 + along}, -shares[along]});
  return constraint;
}

// The steps, in this order:
//   1. links that tie single directions become constraints;
//   2. nodes that something names by single directions get a local node, to which these names are moved. The node's own
//      motions follow from those of the local node; where links lead them, it is the other way round;
//   3. vectors and tensors in global axes are turned, and places are moved.
class Placer {
public:
  Placer(FiniteElementModel& model, std::vector<LoadCase>& load_cases, const Placement& placement)
      : model_(model), placement_(placement), turn_(placement.rotation) {
    for (auto& load_case : load_cases) add(load_case);
    if (const auto set = model.mesh.node_sets.find(scalar_points); set != model.mesh.node_sets.end())
      scalars_.insert(set->second.begin(), set->second.end());
  }

  void run() {
    if (!turn_.isIdentity(0.0)) {
      write_as_constraints(model_.links, model_.mesh, model_.constraints);
      write_as_constraints(model_.weighted_links, model_.mesh, model_.constraints);
      for (auto& [node, axes] : model_.mesh.axes) axes = turn_ * axes;
      move_to_local_nodes();
      for (auto& [region, property] : model_.properties) std::visit([&](auto& each) { turn(each); }, property);
      for (auto& mass : model_.masses) turn(mass);
      for (auto& joint : model_.joints) joint.deformation = turned(joint.deformation);
      for (auto& matrices : model_.matrices)
        if (hold_whole_nodes(matrices)) turn(matrices);
    }
    for (auto place : model_.mesh.nodes.colwise()) place = placement_.at(place);
    for (auto* load_case : load_cases_) turn(*load_case);
  }

private:
  /// A load case and, one within the other, the preloads that it is solved with.
  void add(LoadCase& load_case) {
    load_cases_.push_back(&load_case);
    for (auto& carried : load_case.preload) add(carried);
  }

  /// Calls `visit` with every node that is named by a single direction.
  void visit_single_directions(const auto& visit) {
    for (auto& support : model_.fixed)
      if (!is_whole(support.directions)) std::ranges::for_each(support.nodes, visit);
    for (auto& spring : model_.springs) {
      visit(spring.from.node);
      if (spring.to) visit(spring.to->node);
    }
    for (auto& constraint : model_.constraints)
      for (auto& [dof, coefficient] : constraint.terms) visit(dof.node);
    for (auto& matrices : model_.matrices)
      if (!hold_whole_nodes(matrices))
        for (auto& dof : matrices.dofs) visit(dof.node);
    for (auto* load_case : load_cases_) {
      for (auto& motion : load_case->imposed) visit(motion.dof.node);
      for (auto* support : supports_of(*load_case))
        if (!is_whole(support->directions)) std::ranges::for_each(support->nodes, visit);
    }
  }

  void move_to_local_nodes() {
    std::map<Index, Index> local;
    visit_single_directions([&](Index node) {
      if (!scalars_.contains(node) && !model_.mesh.axes.contains(node)) local[node] = -1;
    });
    for (auto& [node, own] : local) own = add_local_node(model_.mesh, node, turn_);
    const auto move = [&](Index& node) {
      if (const auto found = local.find(node); found != local.end()) node = found->second;
    };
    visit_single_directions(move);
    for (auto& support : model_.fixed)
      if (is_whole(support.directions)) std::ranges::for_each(support.nodes, move);
    for (auto* load_case : load_cases_)
      for (auto* support : supports_of(*load_case))
        if (is_whole(support->directions)) std::ranges::for_each(support->nodes, move);
    const auto led = dofs_led_by_links();
    for (const auto& [node, own] : local)
      for (int direction = 0; direction < 6; ++direction)
        model_.constraints.push_back(
            led.contains({node, direction})
                ? following(model_.mesh, {own, direction}, node, turn_.col(direction % 3))
                : following(model_.mesh, {node, direction}, own, turn_.row(direction % 3).transpose()));
  }

  static std::vector<FixedNodes*> supports_of(LoadCase& load_case) {
    std::vector<FixedNodes*> supports;
    if (load_case.supports)
      for (auto& support : *load_case.supports) supports.push_back(&support);
    return supports;
  }

  [[nodiscard]] std::set<NodalDof> dofs_led_by_links() const {
    std::set<NodalDof> dofs;
    const auto add = [&](Index node, const Directions& tied) {
      for (int direction = 0; direction < 6; ++direction)
        if (tied[static_cast<std::size_t>(direction)]) dofs.insert({node, direction});
    };
    for (const auto& link : model_.links)
      for (const Index slave : link.slaves) add(slave, link.tied);
    for (const auto& link : model_.weighted_links) add(link.follower, link.tied);
    return dofs;
  }

  /// Whether a turn mixes the matrices' own degrees of freedom only. Scalar points have none that it would mix.
  [[nodiscard]] bool hold_whole_nodes(const NodalMatrices& matrices) const {
    std::map<Index, Directions> directions;
    for (const auto& [node, direction] : matrices.dofs)
      if (!scalars_.contains(node))
        directions.try_emplace(node, Directions{}).first->second[static_cast<std::size_t>(direction)] = true;
    return std::ranges::all_of(directions, [](const auto& each) { return is_whole(each.second); });
  }

  void turn(ShellProperty& /*the same in all directions*/) const {}
  void turn(LaminateProperty& laminate) const {
    for (auto& direction : laminate.directions) direction = turn_ * direction;
  }
  void turn(BeamProperty& beam) const {
    for (auto& placement : beam.placements) {
      placement.up = turn_ * placement.up;
      placement.offsets = turn_ * placement.offsets;
    }
  }
  void turn(SolidProperty& solid) const {
    if (solid.elasticity) solid.elasticity = in_global_axes(*solid.elasticity, turn_);
  }

  void turn(PointMass& mass) const {
    mass.inertia = turn_ * mass.inertia * turn_.transpose();
    mass.offset = turn_ * mass.offset;
  }

  /// B A B^T with the turn B of all translations and of all rotations of a node together.
  void turn(NodalMatrices& matrices) const {
    std::map<NodalDof, int> places;
    for (const auto& dof : matrices.dofs) places.try_emplace(dof, static_cast<int>(places.size()));
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t column = 0; column < matrices.dofs.size(); ++column)
      for (const auto& [dof, share] : turned(matrices.dofs[column]))
        entries.emplace_back(places.at(dof), static_cast<int>(column), share);
    const auto size = static_cast<Index>(matrices.dofs.size());
    Eigen::SparseMatrix<double> turn(size, size);
    turn.setFromTriplets(entries.begin(), entries.end());
    for (auto* matrix : {&matrices.stiffness, &matrices.mass, &matrices.damping})
      if (matrix->size() > 0) *matrix = turn * Eigen::SparseMatrix<double>(*matrix * turn.transpose());
  }

  /// The motion along a direction of the model's own axes, in global ones.
  [[nodiscard]] DofSum turned(const NodalDof& dof) const {
    if (scalars_.contains(dof.node) || model_.mesh.axes.contains(dof.node)) return {{dof, 1.0}};
    DofSum sum;
    for (int along = 0; along < 3; ++along)
      if (const double share = turn_(along, dof.direction % 3); share != 0.0)
        sum.push_back({{dof.node, dof.direction / 3 * 3 + along}, share});
    return sum;
  }

  [[nodiscard]] DofSum turned(const DofSum& given) const {
    std::map<NodalDof, double> sum;
    for (const auto& [dof, coefficient] : given)
      for (const auto& [global, share] : turned(dof)) sum[global] += coefficient * share;
    return {sum.begin(), sum.end()};
  }

  void turn(LoadCase& load_case) const {
    for (auto& load : load_case.loads) {
      load.force = turn_ * load.force;
      load.moment = turn_ * load.moment;
    }
    for (auto& beam : load_case.beam_loads)
      for (const Index i : {0, 3, 6, 9}) beam.forces.segment<3>(i) = (turn_ * beam.forces.segment<3>(i)).eval();
    load_case.gravity = turn_ * load_case.gravity;
    if (auto& rotation = load_case.rotation) {
      rotation->axis = turn_ * rotation->axis;
      rotation->about = placement_.at(rotation->about);
    }
  }

  FiniteElementModel& model_;
  std::vector<LoadCase*> load_cases_;
  const Placement& placement_;
  const Matrix3d& turn_;
  std::set<Index> scalars_;  ///< scalar points, which have no directions
};

}  // namespace

Matrix3d turn_about(const Vector3d& axis, double angle) {
  const Matrix3d turn = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  return (turn.array().abs() < 1e-15).select(0.0, turn);
}

void place(FiniteElementModel& model, std::vector<LoadCase>& load_cases, const Placement& placement) {
  Placer(model, load_cases, placement).run();
}

Index add_local_node(Mesh& mesh, Index node, const Matrix3d& axes) {
  const Index local = mesh.node_count();
  const Vector3d place = mesh.nodes.col(node);
  mesh.nodes.conservativeResize(Eigen::NoChange, local + 1);
  mesh.nodes.col(local) = place;
  mesh.node_ids.push_back(std::ranges::max(mesh.node_ids) + 1);
  mesh.axes[local] = axes;
  return local;
}

std::vector<MultiPointConstraint> local_motions(const Mesh& mesh, Index node, Index local) {
  const Matrix3d axes = mesh.axes_of(local);
  std::vector<MultiPointConstraint> constraints;
  for (int direction = 0; direction < 6; ++direction)
    constraints.push_back(following(mesh, {node, direction}, local, axes.row(direction % 3).transpose()));
  return constraints;
}

}  // namespace kalfem
