// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/coupling.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "kalfem/model/node_points.hpp"
#include "kalfem/system/laws/law_library.hpp"

namespace kalfem {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;
using Places = std::vector<Eigen::Index>;

void append_block(Triplets& triplets, const SparseMatrix& block, const Places& places) {
  const auto place = [&](Eigen::Index dof) { return places[static_cast<std::size_t>(dof)]; };
  for (Eigen::Index column = 0; column < block.outerSize(); ++column)
    for (SparseMatrix::InnerIterator it(block, column); it; ++it)
      triplets.emplace_back(place(it.row()), place(it.col()), it.value());
}

/// sum_s L_s^T A_s L_s, L_s the selection of the degrees of freedom of substructure s.
SparseMatrix assembled(const std::vector<Substructure>& parts, const std::vector<Places>& places, Eigen::Index dofs,
                       SparseMatrix LinearModel::*matrix) {
  Triplets triplets;
  for (std::size_t s = 0; s < parts.size(); ++s) append_block(triplets, (*parts[s].model).*matrix, places[s]);
  SparseMatrix result(dofs, dofs);
  result.setFromTriplets(triplets.begin(), triplets.end());
  return result;
}

/// Adds an issue for every name that stands twice in the list.
template <typename Named>
void require_unique(const std::vector<Named>& items, const std::string& what, IssueList& issues) {
  std::set<std::string> seen;
  for (const auto& item : items)
    if (!seen.insert(item.name).second)
      issues.add({}, "the " + what + " '" + item.name + "' is given twice", "names must be unique",
                 "rename one of them");
}

/// Numbers 0 ... size - 1 in disjoint sets, each known by its first (smallest) member.
class DisjointSets {
public:
  explicit DisjointSets(std::size_t size) : parents_(size) { std::iota(parents_.begin(), parents_.end(), 0); }

  Eigen::Index first(Eigen::Index number) {
    auto& parent = parents_[static_cast<std::size_t>(number)];
    if (parent != number) parent = first(parent);
    return parent;
  }
  void unite(Eigen::Index one, Eigen::Index other) {
    const auto [smaller, larger] = std::minmax({first(one), first(other)});
    parents_[static_cast<std::size_t>(larger)] = smaller;
  }

private:
  std::vector<Eigen::Index> parents_;
};

/// Damped modes of all substructures, each zero outside its own.
ModalDamping joined_modal_damping(const std::vector<Substructure>& parts, const std::vector<Places>& places,
                                  Eigen::Index dofs) {
  Eigen::Index modes = 0, column = 0;
  for (const auto& part : parts) modes += part.model->modal_damping.rates.size();
  if (modes == 0) return {};
  ModalDamping joined{{Eigen::VectorXd(modes), Eigen::MatrixXd::Zero(dofs, modes)}, Eigen::VectorXd(modes)};
  for (std::size_t s = 0; s < parts.size(); ++s) {
    const auto& own = parts[s].model->modal_damping;
    const Eigen::Index count = own.rates.size();
    joined.modes.frequencies.segment(column, count) = own.modes.frequencies;
    joined.rates.segment(column, count) = own.rates;
    if (count > 0) joined.modes.shapes(places[s], Eigen::seqN(column, count)) = own.modes.shapes;
    column += count;
  }
  return joined;
}

/// The grounds that a base displacement moves, each by its weight.
DofCombination moved_grounds(const InputDescription& input) {
  if (input.kind != InputKind::base_displacement) return {};
  return input.direction.empty() ? DofCombination{{input.target, 1.0}} : input.direction;
}

/// How far a point moves when every degree of freedom and every ground moves by 1.
double translation_of(const PointMotion& point) { return point.dofs.isZero() ? 1.0 : point.dofs.sum(); }

/// Whether the degrees of freedom of a finite-element model are translations along one axis: "n1.x", "n2.x".
bool along_one_axis(const LinearModel& model) {
  const auto axis_of = [](const std::string& dof) { return dof.substr(dof.rfind('.') + 1); };
  const std::string axis = model.dofs.empty() ? "x" : axis_of(model.dofs.front());
  return (axis == "x" || axis == "y" || axis == "z") &&
         std::ranges::all_of(model.dofs, [&](const auto& dof) { return axis_of(dof) == axis; });
}

/// Whether a part is not strained when its grounds and all its degrees of freedom move by 1: K 1 = sum_g k_g. The
/// supports of finite elements are no grounds and move with the base too.
bool follows_its_base(const LinearModel& model) {
  if (model.points_only) return along_one_axis(model);
  Eigen::VectorXd strain = model.stiffness * Eigen::VectorXd::Ones(model.size());
  const double size = model.stiffness.cwiseAbs().sum();
  for (const auto& ground : model.grounds) strain -= ground.stiffness;
  return strain.cwiseAbs().sum() <= 1e-6 * size;
}

std::vector<Eigen::Index> moving_grounds(const std::vector<InputDescription>& inputs) {
  std::vector<Eigen::Index> grounds;
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (inputs[i].kind == InputKind::base_displacement) grounds.push_back(static_cast<Eigen::Index>(i));
  return grounds;
}

}  // namespace

std::string unit_of(InputKind kind) {
  switch (kind) {
    case InputKind::base_displacement:
      return "m";
    case InputKind::base_acceleration:
      return "m/s^2";
    case InputKind::force:
      return "N";
  }
  return "";
}

// How the coupled system is put together:
//   1. M, C, K of the substructures stand block by block on the diagonal, their damped modes side by side. Their names
//      become "substructure.dof". Shared degrees of freedom are one coordinate, at which the blocks overlap and add up.
//   2. An input adds a load. A force acts on a point's combination of degrees of freedom. A base displacement r acts
//      through the springs and dashpots to the ground, k_g r + c_g r'. A base acceleration a makes the coordinates
//      relative to the base, with the load -M d a and d the degrees of freedom that move with the base.
//   3. A connector is a rank-one force: with b the difference of its ends, deformation d = b^T z - base^T r, load -b f.
//      It leaves the linear part as it is.
//   4. Damping of the whole structure's modes comes last, because those modes include the connectors at rest.
// Every input and connector is tried, so that the user sees all mistakes at once.
CoupledModel::CoupledModel(std::vector<Substructure> substructures, const std::vector<ConnectorDescription>& connectors,
                           const std::vector<InputDescription>& inputs,
                           const std::optional<GlobalModalDamping>& damping, const std::vector<SharedDof>& shared)
    : substructures_(std::move(substructures)), inputs_(inputs), global_modal_damping_(damping.has_value()) {
  number_dofs(shared);
  assemble_linear_part();
  base_accelerations_ = Eigen::MatrixXd::Zero(system_.size(), static_cast<Eigen::Index>(inputs.size()));
  IssueList issues;
  require_unique(substructures_, "substructure", issues);
  require_unique(connectors, "connector", issues);
  require_unique(inputs, "input", issues);
  require_own_modes(shared, issues);
  for (std::size_t i = 0; i < inputs.size(); ++i) try {
      add_input(inputs[i], i);
    } catch (const InvalidInput& error) {
      for (const auto& issue : error.issues())
        issues.add(inputs[i].location, "input '" + inputs[i].name + "': " + issue.what, issue.why, issue.fix);
    }
  for (const auto& connector : connectors) add_connector(connector, issues);
  issues.raise();
  if (damping) add_global_modal_damping(system_, *damping, moving_grounds(inputs));
}

/// Numbers the coordinates of the system: one for each degree of freedom, or one for all that are shared with it, which
/// has the name of the first.
void CoupledModel::number_dofs(const std::vector<SharedDof>& shared) {
  std::vector<std::string> names;
  for (const auto& part : substructures_)
    for (const auto& dof : part.model->dofs) {
      dof_indices_.emplace(part.name + "." + dof, std::ssize(names));
      names.push_back(part.name + "." + dof);
    }
  DisjointSets sets(names.size());
  for (const auto& [first, second] : shared) sets.unite(existing_dof(first), existing_dof(second));
  std::vector<Eigen::Index> coordinates;
  for (Eigen::Index i = 0; i < std::ssize(names); ++i) {
    const auto first = static_cast<std::size_t>(sets.first(i));
    coordinates.push_back(first < coordinates.size() ? coordinates[first] : system_.size());
    if (coordinates.back() == system_.size()) system_.dofs.push_back(names[static_cast<std::size_t>(i)]);
  }
  for (auto& [name, index] : dof_indices_) index = coordinates[static_cast<std::size_t>(index)];
  for (auto next = coordinates.begin(); const auto& part : substructures_) {
    const auto end = next + part.model->size();
    places_.emplace_back(next, end);
    next = end;
  }
}

Eigen::Index CoupledModel::existing_dof(const std::string& name) const {
  if (const auto dof = dof_index(name); dof >= 0) return dof;
  throw InvalidInput("there is no degree of freedom '" + name + "' to share", "",
                     "keep it at the boundary of the substructure");
}

/// Modes that are damped in a substructure alone are none of the assembled structure where it shares coordinates.
void CoupledModel::require_own_modes(const std::vector<SharedDof>& shared, IssueList& issues) const {
  for (const auto& part : substructures_) {
    const auto belongs = [&](const std::string& dof) { return dof.starts_with(part.name + "."); };
    if (part.model->modal_damping.rates.size() > 0 &&
        std::ranges::any_of(shared, [&](const auto& each) { return belongs(each.first) || belongs(each.second); }))
      issues.add({},
                 "substructure '" + part.name + "' has modal damping and shares degrees of freedom with another one",
                 "its own modes are none of the whole structure", "damp the modes of the whole structure by `damping`");
  }
}

void CoupledModel::assemble_linear_part() {
  const auto add_up = [&](SparseMatrix LinearModel::*matrix) {
    return assembled(substructures_, places_, system_.size(), matrix);
  };
  system_.mass = add_up(&LinearModel::mass);
  system_.damping = add_up(&LinearModel::damping);
  system_.stiffness = add_up(&LinearModel::stiffness);
  coordinate_scale_ = Eigen::VectorXd::Ones(system_.size());
  for (std::size_t s = 0; s < substructures_.size(); ++s)
    if (const auto& scale = substructures_[s].model->coordinate_scale; scale.size() > 0)
      coordinate_scale_(places_[s]) = scale;
  system_.modal_damping = joined_modal_damping(substructures_, places_, system_.size());
}

void CoupledModel::add_input(const InputDescription& description, std::size_t index) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(system_.size());
  Input input{description.name, unit_of(description.kind), zero, zero, zero};
  if (description.kind == InputKind::force) {
    input.value = motion(description.target).dofs;
    if (input.value.isZero())
      throw InvalidInput("force '" + description.name + "' acts on the ground '" + description.target + "'",
                         "a force cannot move a ground", "name a point of a substructure");
  } else if (description.kind == InputKind::base_displacement) {
    for (const auto& [ground, weight] : moved_grounds(description)) add_ground_load(ground, weight, input);
  } else {
    Eigen::VectorXd direction = Eigen::VectorXd::Ones(system_.size());
    if (description.direction.empty())
      require_translation(description);
    else
      direction.setZero();
    for (const auto& [dof, value] : description.direction) direction += value * motion(dof).dofs;
    base_accelerations_.col(static_cast<Eigen::Index>(index)) = direction;
    input.value = -(system_.mass * direction);
  }
  system_.inputs.push_back(std::move(input));
}

/// What a ground's motion does to the substructure that it holds.
void CoupledModel::add_ground_load(const std::string& ground, double weight, Input& input) const {
  bool found = false;
  for (std::size_t s = 0; s < substructures_.size(); ++s)
    for (const auto& coupling : substructures_[s].model->grounds)
      if (substructures_[s].name + "." + coupling.ground == ground) {
        found = true;
        input.value(places_[s]) += weight * coupling.stiffness;
        input.rate(places_[s]) += weight * coupling.damping;
      }
  if (!found)
    throw InvalidInput("base displacement '" + input.name + "' moves '" + ground + "', which is not a ground" +
                           did_you_mean(ground, point_names()),
                       "only a ground can be moved", "write it as substructure.ground");
}

void CoupledModel::require_translation(const InputDescription& description) const {
  for (const auto& part : substructures_)
    if (!follows_its_base(*part.model))
      throw InvalidInput("base acceleration '" + description.name +
                             "' moves every degree of freedom equally, which deforms substructure '" + part.name + "'",
                         "it has rotations, several directions or modes, which do not move with its base",
                         "accelerate its grounds by name, or give a weight for each degree of freedom that moves");
}

void CoupledModel::add_connector(const ConnectorDescription& description, IssueList& issues) {
  try {
    const PointMotion from = end_motion(description.from), to = end_motion(description.to);
    const Eigen::VectorXd deformation = to.dofs - from.dofs, base = from.base - to.base;
    if (deformation.isZero() && base.isZero())
      issues.add(
          description.location,
          "connector '" + description.name + "' connects '" + description.from + "' and '" + description.to + "'",
          "there is no relative motion between them", "connect two different points, at least one of which moves");
    if (moves_alike_by_all() && std::abs(translation_of(to) - translation_of(from)) > 1e-9)
      throw InvalidInput("accelerating all degrees of freedom equally deforms it",
                         "one of its ends is a sum of degrees of freedom that do not all move with the base",
                         "give a weight for each degree of freedom that moves with the base");
    if (!description.law) throw InvalidInput("it has no law", "its force is unknown", "choose one of the laws");
    for (const auto& issue : validate_parameters(*description.law, description.parameters))
      issues.add(description.location, "connector '" + description.name + "': " + issue.what, issue.why, issue.fix);
    system_.connectors.push_back({description.name, description.law, description.parameters, deformation, base});
  } catch (const InvalidInput& error) {
    for (const auto& issue : error.issues())
      issues.add(description.location, "connector '" + description.name + "': " + issue.what, issue.why, issue.fix);
  }
}

PointMotion CoupledModel::zero_motion() const {
  return {Eigen::VectorXd::Zero(system_.size()), Eigen::VectorXd::Zero(static_cast<Eigen::Index>(inputs_.size()))};
}

bool CoupledModel::moves_alike_by_all() const {
  return std::ranges::any_of(
      inputs_, [](const auto& input) { return input.kind == InputKind::base_acceleration && input.direction.empty(); });
}

PointMotion CoupledModel::end_motion(const std::string& end) const {
  return end == fixed_ground ? zero_motion() : motion(end);
}

/// A name is looked up as a degree of freedom, then as a point of the substructure (a combination of degrees of
/// freedom), then as a ground, which moves by the inputs that drive it.
PointMotion CoupledModel::motion(const std::string& point) const {
  PointMotion motion = zero_motion();
  if (const auto dof = dof_index(point); dof >= 0) {
    motion.dofs[dof] = 1.0;
    return motion;
  }
  for (const auto& part : substructures_) {
    const std::string prefix = part.name + ".";
    if (!point.starts_with(prefix)) continue;
    if (const auto found = part.model->points.find(point.substr(prefix.size())); found != part.model->points.end()) {
      for (const auto& [dof, coefficient] : found->second) motion.dofs[dof_index(prefix + dof)] += coefficient;
      return motion;
    }
    for (const auto& ground : part.model->grounds)
      if (part.name + "." + ground.ground == point) {
        for (std::size_t i = 0; i < inputs_.size(); ++i) {
          const DofCombination moved = moved_grounds(inputs_[i]);
          if (const auto weight = moved.find(point); weight != moved.end())
            motion.base[static_cast<Eigen::Index>(i)] = weight->second;
        }
        return motion;
      }
  }
  throw InvalidInput("there is no point '" + point + "'" + did_you_mean(point, point_names()),
                     "write points as substructure.name", "name a mass, point or ground of the substructure");
}

std::vector<std::string> CoupledModel::reported_points() const {
  std::vector<std::string> names;
  const auto add = [&](const Substructure& part, const std::string& name) { names.push_back(part.name + "." + name); };
  for (const auto& part : substructures_)
    if (!part.model->points_only)
      for (const auto& dof : part.model->dofs) add(part, dof);
  for (const auto& part : substructures_) {
    for (const auto& [name, combination] : part.model->points)
      if (!part.model->points_only || !is_numbered_node(name)) add(part, name);
    if (part.model->size() == 0)
      for (const auto& ground : part.model->grounds) add(part, ground.ground);
  }
  return names;
}

std::vector<std::string> CoupledModel::point_names() const {
  std::vector<std::string> names = system_.dofs;
  for (const auto& part : substructures_) {
    for (const auto& [name, combination] : part.model->points) names.push_back(part.name + "." + name);
    for (const auto& ground : part.model->grounds) names.push_back(part.name + "." + ground.ground);
  }
  return names;
}

Eigen::VectorXd CoupledModel::strain(const std::string& gauge) const {
  for (const auto& part : substructures_) {
    const std::string prefix = part.name + ".";
    if (!gauge.starts_with(prefix)) continue;
    const auto found = part.model->gauges.find(gauge.substr(prefix.size()));
    if (found == part.model->gauges.end()) continue;
    Eigen::VectorXd row = Eigen::VectorXd::Zero(system_.size());
    for (const auto& [dof, coefficient] : found->second) row[dof_index(prefix + dof)] += coefficient;
    return row;
  }
  throw InvalidInput("there is no strain gauge '" + gauge + "'" + did_you_mean(gauge, gauges()),
                     "write gauges as substructure.name", "define it under `gauges` of the finite elements");
}

std::vector<std::string> CoupledModel::gauges() const {
  std::vector<std::string> names;
  for (const auto& part : substructures_)
    for (const auto& [name, combination] : part.model->gauges) names.push_back(part.name + "." + name);
  return names;
}

CoupledModel::Placed CoupledModel::find_substructure(const std::string& name) const {
  std::vector<std::string> known;
  for (std::size_t s = 0; s < substructures_.size(); ++s) {
    if (substructures_[s].name == name) return {substructures_[s], places_[s]};
    known.push_back(substructures_[s].name);
  }
  throw InvalidInput("there is no substructure '" + name + "'" + did_you_mean(name, known), "", "name an existing one");
}

Eigen::Index CoupledModel::dof_index(const std::string& dof) const {
  const auto found = dof_indices_.find(dof);
  return found == dof_indices_.end() ? -1 : found->second;
}

}  // namespace kalfem
