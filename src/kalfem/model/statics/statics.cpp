// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/statics/statics.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/assembly/constraints.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/checks/single_checks.hpp"
#include "kalfem/model/statics/free_motions.hpp"
#include "kalfem/model/statics/geometric_stiffness.hpp"
#include "kalfem/model/statics/held_stiffness.hpp"
#include "kalfem/model/statics/rotation.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr const char* imposed_name = "imposed motion";

/// Degrees of freedom that supports or load cases hold: coordinates of their own although links may let them follow.
std::vector<NodalDof> prescribed_dofs(const std::vector<std::map<NodalDof, std::string>>& supported,
                                      const std::vector<LoadCase>& cases) {
  std::set<NodalDof> dofs;
  for (const auto& of_case : supported)
    for (const auto& [dof, support] : of_case) dofs.insert(dof);
  for (const auto& each : cases)
    for (const auto& motion : each.imposed) dofs.insert(motion.dof);
  return {dofs.begin(), dofs.end()};
}

/// Degrees of freedom that supports hold, with the supports' names.
std::map<NodalDof, std::string> supported_dofs(const std::vector<FixedNodes>& supports) {
  std::map<NodalDof, std::string> held;
  for (const auto& support : supports)
    for (const auto node : support.nodes)
      for (int direction = 0; direction < 6; ++direction)
        if (support.directions[static_cast<std::size_t>(direction)]) held.insert({{node, direction}, support.name});
  return held;
}

/// Of each load case: its own supports, or the model's.
std::vector<std::map<NodalDof, std::string>> supported_dofs(const FiniteElementModel& model,
                                                            const std::vector<LoadCase>& cases) {
  std::vector<std::map<NodalDof, std::string>> all;
  for (const auto& each : cases) all.push_back(supported_dofs(each.supports ? *each.supports : model.fixed));
  return all;
}

/// A prescribed degree of freedom: where it stands among those of the released model, who holds it, at what value.
struct Prescribed {
  Index place = 0;
  std::string by;
  double value = 0.0;
};

}  // namespace

// What a load case needs in turn: what it prescribes, its forces over the degrees of freedom of the released model, the
// displacements, and from these the forces of supports and grounds.
class StaticAnalysis::Solver {
public:
  Solver(const FiniteElementModel& model, std::vector<LoadCase> cases)
      : model_(model),
        cases_(std::move(cases)),
        supported_(supported_dofs(model, cases_)),
        assembled_(assemble(model, {.independent = prescribed_dofs(supported_, cases_), .release_supports = true})),
        stiffness_(evaluate(assembled_.stiffness, assembled_.parameters)) {
    IssueList issues;
    for (std::size_t i = 0; i < cases_.size(); ++i) {
      const LoadCase& each = cases_[i];
      nodal_.push_back(nodal_forces(model_, each));
      check_loads(nodal_.back(), each, issues);
      if (each.rotation) nodal_.back() += centrifugal_forces(model_, *each.rotation);
      preloads_.push_back(preload(each));
      prescribed_.push_back(prescribed_by(each, supported_[i], issues));
      if (issues.empty()) require_effect(each, nodal_.back(), prescribed_.back(), issues);
    }
    issues.raise();
    for (std::size_t i = 0; i < cases_.size(); ++i) factor(i);
  }

  [[nodiscard]] const FiniteElementModel& model() const { return model_; }
  [[nodiscard]] const std::vector<LoadCase>& cases() const { return cases_; }

  [[nodiscard]] StaticSolution solve(std::size_t index) const {
    const LoadCase& load_case = cases_.at(index);
    const auto& prescribed = prescribed_[index];
    const VectorXd forces = forces_of(load_case, nodal_[index]), held_values = values_of(prescribed);
    const SparseMatrix& stiffness = stiffness_of(index);
    const VectorXd z = held_.at({preloads_[index], places_of(prescribed)}).solve(forces, held_values);
    StaticSolution solution;
    solution.load_case = load_case.name;
    solution.preload = preloads_[index];
    solution.displacements = assembled_.expansion * z;
    solution.applied = applied(nodal_[index], load_case.gravity);
    add_reactions(prescribed, stiffness * z - forces, solution);
    const double largest = (stiffness.cwiseAbs() * z.cwiseAbs()).maxCoeff();
    judge_balance(nodal_[index], preload_forces(index, solution.displacements), largest, solution);
    return solution;
  }

  [[nodiscard]] std::vector<std::string> ignored_springs(std::size_t index) const {
    return preloads_[index].empty() ? std::vector<std::string>{} : carried_.at(preloads_[index]).preload.ignored;
  }

private:
  /// What load cases with one preload share.
  struct Carried {
    Preload preload;
    SparseMatrix stiffness;  ///< K + K_g over the degrees of freedom of the released model
  };

  /// The preload's name, empty without one, after it is solved.
  std::string preload(const LoadCase& load_case) {
    if (load_case.preload.empty()) return {};
    const LoadCase& carried = load_case.preload.front();
    if (!carried_.contains(carried.name)) {
      Preload found = preload_of(model_, carried);
      SparseMatrix own =
          stiffness_ + SparseMatrix(assembled_.expansion.transpose() * found.stiffness * assembled_.expansion);
      carried_.emplace(carried.name, Carried{std::move(found), std::move(own)});
    }
    return carried.name;
  }

  [[nodiscard]] const SparseMatrix& stiffness_of(std::size_t index) const {
    return preloads_[index].empty() ? stiffness_ : carried_.at(preloads_[index]).stiffness;
  }

  /// K_g u over all degrees of freedom: stresses that turn with the structure, 0 without a preload.
  [[nodiscard]] VectorXd preload_forces(std::size_t index, const VectorXd& displacements) const {
    if (preloads_[index].empty()) return VectorXd::Zero(displacements.size());
    return carried_.at(preloads_[index]).preload.stiffness * displacements;
  }

  /// Positions of what is prescribed, ascending.
  [[nodiscard]] std::vector<Prescribed> prescribed_by(const LoadCase& load_case,
                                                      const std::map<NodalDof, std::string>& supported,
                                                      IssueList& issues) const {
    std::map<Index, Prescribed> all;
    for (const auto& [dof, support] : supported)
      if (const Index place = assembled_.find(dof); place >= 0) all[place] = {place, support, 0.0};
    for (const auto& [dof, value, of_support] : load_case.imposed) {
      const Index place = assembled_.find(dof);
      if (of_support && all.contains(place)) {
        all.at(place).value = value;
        continue;
      }
      if (of_support && place < 0) continue;  // nothing moves with it
      const std::string title = title_of(load_case) + " imposes a motion on " + dof_name(model_.mesh, dof);
      if (const auto support = supported.find(dof); support != supported.end())
        issues.add({}, title + ", which the support '" + support->second + "' holds", "it cannot be at two places",
                   "remove the imposed motion, or this direction from the support");
      else if (place < 0)
        issues.add({}, title + ", which nothing moves with",
                   "no element, spring or mass acts there, or links let it follow prescribed motions",
                   "choose a degree of freedom of the model");
      else if (!all.insert({place, {place, imposed_name, value}}).second)
        issues.add({}, title + " twice", "it has one value", "remove one of them");
    }
    std::vector<Prescribed> list;
    for (const auto& [place, each] : all) list.push_back(each);
    return list;
  }

  /// A force must act where an element, spring or mass does, itself or through a link; gravity and rotation, on mass.
  void check_loads(const VectorXd& nodal, const LoadCase& load_case, IssueList& issues) const {
    const Eigen::SparseMatrix<double, Eigen::RowMajor> rows = assembled_.expansion;
    std::vector<std::string> forces, moments;
    for (Index i = 0; i < nodal.size(); ++i)
      if (nodal[i] != 0.0 && rows.innerVector(i).nonZeros() == 0)
        (i % 6 < 3 ? forces : moments).push_back(dof_name(model_.mesh, {i / 6, static_cast<int>(i % 6)}));
    const auto add = [&](const std::vector<std::string>& dofs, const std::string& why) {
      if (!dofs.empty())
        issues.add({},
                   title_of(load_case) + " acts on " + report::listed(dofs, static_cast<Index>(dofs.size())) +
                       ", where there is nothing",
                   why, "load other nodes, or link these rigidly to others");
    };
    add(forces, "no element, spring or mass takes a force there");
    add(moments, "a solid's nodes have no rotations, so nothing takes a moment there");
    if ((load_case.rotation || !load_case.gravity.isZero(0.0)) && !(mass_properties(assembled_).mass > 0.0))
      issues.add({},
                 title_of(load_case) + (load_case.rotation ? " rotates it" : " has gravity") + ", but it has no mass",
                 "the load is zero", "give its materials a density, or add masses");
  }

  /// Forces at supports alone go straight into these, and imposed motions of 0 move nothing. A rotation may have the
  /// speed 0, the first of several.
  void require_effect(const LoadCase& load_case, const VectorXd& nodal, const std::vector<Prescribed>& prescribed,
                      IssueList& issues) const {
    if (load_case.rotation || load_case.of_deck) return;
    VectorXd forces = forces_of(load_case, nodal);
    for (const auto& each : prescribed) forces[each.place] = 0.0;
    if (forces.isZero(0.0) && values_of(prescribed).isZero(0.0))
      issues.add({}, title_of(load_case) + " acts on supports alone", "it deforms nothing",
                 "load nodes that can move, or remove the load case");
  }

  /// Over the degrees of freedom of the released model, gravity among them.
  [[nodiscard]] VectorXd forces_of(const LoadCase& load_case, const VectorXd& nodal) const {
    return assembled_.expansion.transpose() * nodal + weight(load_case.gravity);
  }

  [[nodiscard]] VectorXd values_of(const std::vector<Prescribed>& prescribed) const {
    VectorXd values = VectorXd::Zero(assembled_.size());
    for (const auto& each : prescribed) values[each.place] = each.value;
    return values;
  }

  [[nodiscard]] std::string title_of(const LoadCase& load_case) const {
    return "load case '" + load_case.name + "' of '" + model_.name + "'";
  }

  /// M R g with the rigid translations R.
  [[nodiscard]] VectorXd weight(const Eigen::Vector3d& gravity) const {
    if (gravity.isZero(0.0)) return VectorXd::Zero(assembled_.size());
    return evaluate(assembled_.mass, assembled_.parameters) *
           VectorXd(rigid_body_modes(model_, assembled_).leftCols<3>() * gravity);
  }

  static std::vector<Index> places_of(const std::vector<Prescribed>& prescribed) {
    std::vector<Index> places;
    for (const auto& each : prescribed) places.push_back(each.place);
    return places;
  }

  /// Cases with the same preload that hold the same degrees of freedom share a factor.
  void factor(std::size_t index) {
    const auto held = places_of(prescribed_[index]);
    const std::string& preload = preloads_[index];
    if (held_.contains({preload, held})) return;
    try {
      held_.try_emplace({preload, held}, stiffness_of(index), held);
    } catch (const NotPositiveDefinite&) {
      if (preload.empty() || !is_held(held)) throw free_to_move(model_, assembled_, held);
      throw InvalidInput("the preload '" + preload + "' of " + title_of(cases_[index]) +
                             " is beyond its buckling load or critical speed",
                         "its stiffness under this load is not positive definite", "reduce the load or add supports");
    }
  }

  /// Whether supports at these places hold the structure without a preload.
  [[nodiscard]] bool is_held(const std::vector<Index>& held) const try {
    HeldStiffness(stiffness_, held);
    return true;
  } catch (const NotPositiveDefinite&) {
    return false;
  }

  [[nodiscard]] Resultant applied(const VectorXd& nodal, const Eigen::Vector3d& gravity) const {
    Resultant sum = resultant_of(model_.mesh, nonzero(nodal), middle());
    Matrix6 mass = Matrix6::Zero();
    for (const auto& part : assembled_.rigid_mass)
      mass += affine_factor(part.powers, assembled_.parameters) * part.matrix;
    const Eigen::Matrix<double, 6, 1> load = mass.leftCols<3>() * gravity;
    return sum += {load.head<3>(), load.tail<3>(), Eigen::Vector3d::Zero()};
  }

  [[nodiscard]] Eigen::Vector3d middle() const { return box_frame(model_.mesh).centre; }

  static std::vector<DofForce> nonzero(const VectorXd& nodal) {
    std::vector<DofForce> forces;
    for (Index i = 0; i < nodal.size(); ++i)
      if (nodal[i] != 0.0) forces.push_back({{i / 6, static_cast<int>(i % 6)}, nodal[i]});
    return forces;
  }

  /// Of supports and imposed motions from what is left of the equilibrium there, of grounds from their springs.
  void add_reactions(const std::vector<Prescribed>& prescribed, const VectorXd& left, StaticSolution& solution) const {
    std::map<std::string, std::vector<DofForce>> by_name;
    for (const auto& [place, by, value] : prescribed)
      by_name[by].push_back({assembled_.dofs[static_cast<std::size_t>(place)], left[place]});
    for (const auto& spring : model_.springs)
      if (!spring.to)
        by_name[spring.ground].push_back(
            {spring.from, -spring.stiffness * solution.displacements[all_index(spring.from)]});
    for (const auto& joint : model_.joints)
      if (is_grounded(joint)) add_forces_of(joint, solution.displacements, by_name[joint.name]);
    solution.reaction_sum.centre = middle();
    for (const auto& [name, forces] : by_name) {
      Eigen::Vector3d centre = Eigen::Vector3d::Zero();
      for (const auto& force : forces)
        centre += model_.mesh.nodes.col(force.dof.node) / static_cast<double>(forces.size());
      solution.reactions.push_back({name, resultant_of(model_.mesh, forces, centre)});
      solution.reaction_sum += solution.reactions.back().sum;
      solution.support_forces.insert(solution.support_forces.end(), forces.begin(), forces.end());
    }
  }

  /// Whether a rigid motion of the model deforms the joint, as one of an oblique spring to the ground.
  [[nodiscard]] bool is_grounded(const JointSpring& joint) const {
    std::vector<DofForce> unit;
    for (const auto& [dof, coefficient] : joint.deformation) unit.push_back({dof, coefficient});
    const Resultant sum = resultant_of(model_.mesh, unit, middle());
    return relative_imbalance(model_.mesh, sum, unit) > 1e-9;
  }

  /// -k d c_i with the deformation d = sum c_i z_i.
  static void add_forces_of(const JointSpring& joint, const VectorXd& displacements, std::vector<DofForce>& forces) {
    double deformation = 0.0;
    for (const auto& [dof, coefficient] : joint.deformation) deformation += coefficient * displacements[all_index(dof)];
    for (const auto& [dof, coefficient] : joint.deformation)
      forces.push_back({dof, -joint.stiffness * deformation * coefficient});
  }

  /// Loads and reactions are in equilibrium with the forces of a preload that turns with the structure. `largest`:
  /// internal force, whose rounding is no load: there are none where supports move the whole alike.
  void judge_balance(const VectorXd& nodal, const VectorXd& of_preload, double largest,
                     StaticSolution& solution) const {
    constexpr double rounding = 1e-11;
    auto forces = nonzero(nodal);
    const auto turned = nonzero(-of_preload);
    forces.insert(forces.end(), turned.begin(), turned.end());
    forces.insert(forces.end(), solution.support_forces.begin(), solution.support_forces.end());
    if (std::ranges::all_of(forces, [&](const auto& force) { return std::abs(force.value) <= rounding * largest; }))
      return;
    Resultant sum = solution.applied;
    sum += solution.reaction_sum;
    sum += resultant_of(model_.mesh, turned, middle());
    solution.imbalance = relative_imbalance(model_.mesh, sum, forces);
  }

  const FiniteElementModel& model_;
  std::vector<LoadCase> cases_;
  std::vector<std::map<NodalDof, std::string>> supported_;  ///< by load case
  AssembledModel assembled_;                                ///< without supports
  SparseMatrix stiffness_;
  std::vector<VectorXd> nodal_;                                               ///< forces, by load case
  std::vector<std::string> preloads_;                                         ///< names, by load case; empty: none
  std::map<std::string, Carried> carried_;                                    ///< by these names
  std::vector<std::vector<Prescribed>> prescribed_;                           ///< by load case
  std::map<std::pair<std::string, std::vector<Index>>, HeldStiffness> held_;  ///< by preload and places prescribed
};

StaticAnalysis::StaticAnalysis(const FiniteElementModel& model, std::vector<LoadCase> cases)
    : solver_(std::make_unique<const Solver>(model, std::move(cases))) {}
StaticAnalysis::~StaticAnalysis() = default;

const FiniteElementModel& StaticAnalysis::model() const { return solver_->model(); }
const std::vector<LoadCase>& StaticAnalysis::cases() const { return solver_->cases(); }
StaticSolution StaticAnalysis::solve(std::size_t load_case) const { return solver_->solve(load_case); }
std::vector<std::string> StaticAnalysis::ignored_springs(std::size_t load_case) const {
  return solver_->ignored_springs(load_case);
}

StaticSolution solve_statics(const FiniteElementModel& model, const LoadCase& load_case) {
  return StaticAnalysis(model, {load_case}).solve(0);
}

}  // namespace kalfem
