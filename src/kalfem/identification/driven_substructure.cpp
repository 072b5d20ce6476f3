// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/driven_substructure.hpp"

#include <algorithm>

#include "kalfem/linalg/sparse_operations.hpp"
#include "kalfem/model/node_points.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Place = DrivenSubstructure::Place;

/// The boundary of a finite-element substructure, or the degrees of freedom that connectors touch.
std::vector<Index> boundary_of(const StructureModel& structure, const CoupledModel& model, const Place& place) {
  std::vector<Index> boundary;
  const auto& dofs = place.part.model->dofs;
  for (const auto& elements : structure.finite_elements)
    if (elements.part->name == place.part.name)
      for (const auto& name : elements.part->boundary) boundary.push_back(std::ranges::find(dofs, name) - dofs.begin());
  if (!boundary.empty()) return boundary;
  for (Index i = 0; i < place.part.model->size(); ++i)
    if (std::ranges::any_of(model.system().connectors, [&](const auto& connector) {
          return connector.deformation[place.dofs[static_cast<std::size_t>(i)]] != 0.0;
        }))
      boundary.push_back(i);
  return boundary;
}

/// Qualified name under which the motion of a degree of freedom is reported.
std::string reported_name(const Place& place, Index dof) {
  const LinearModel& model = *place.part.model;
  const std::string& name = model.dofs[static_cast<std::size_t>(dof)];
  if (model.points_only)
    for (const auto& [point, combination] : model.points)
      if (!is_numbered_node(point) && combination.size() == 1 && combination.contains(name) &&
          combination.at(name) == 1.0)
        return place.part.name + "." + point;
  return place.part.name + "." + name;
}

/// Inputs that act on the substructure itself: moving grounds, forces at points.
std::vector<AppliedInput> applied_inputs(const StructureModel& structure, const CoupledModel& model,
                                         const Place& place) {
  std::vector<AppliedInput> applied;
  const auto& inputs = model.system().inputs;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    Input own = inputs[i];
    bool acts = false;
    for (auto* load : {&own.value, &own.rate, &own.acceleration}) {
      *load = VectorXd((*load)(place.dofs));
      acts = acts || !load->isZero();
    }
    if (acts) applied.push_back({own, structure.signals[i]});
  }
  return applied;
}

/// The substructure with its diagonal block of the global modal damping.
LinearModel damped_part(const CoupledModel& model, const Place& place) {
  LinearModel part = *place.part.model;
  const auto& system = model.system();
  part.damping = select(system.damping, place.dofs, place.dofs);
  part.modal_damping = system.modal_damping;
  part.modal_damping.modes.shapes = system.modal_damping.modes.shapes(place.dofs, Eigen::all);
  return part;
}

/// Degrees of freedom of other substructures whose motion is estimated individually.
std::vector<Index> outside(const CoupledModel& model, const Place& place) {
  std::vector<Index> dofs;
  for (const auto& part : model.substructures())
    if (part.name != place.part.name && !part.model->points_only)
      for (const Index dof : model.find_substructure(part.name).dofs) dofs.push_back(dof);
  return dofs;
}

/// C_m between the substructure and these degrees of freedom.
MatrixXd cross_damping_of(const CoupledModel& model, const Place& place, const std::vector<Index>& dofs) {
  const auto& [modes, rates] = model.system().modal_damping;
  const MatrixXd mass_weighted_modes = model.system().mass * modes.shapes;
  return mass_weighted_modes(place.dofs, Eigen::all) * rates.asDiagonal() *
         MatrixXd(mass_weighted_modes(dofs, Eigen::all)).transpose();
}

Place place_of(const CoupledModel& model, const std::string& substructure) {
  const auto found = model.find_substructure(substructure);
  return {found.part, found.dofs};
}

BaseDrivenSubstructure driven_part(const CoupledModel& model, const Place& place, std::vector<Index> boundary) {
  if (!model.global_modal_damping()) return {*place.part.model, std::move(boundary)};
  return {damped_part(model, place), std::move(boundary), cross_damping_of(model, place, outside(model, place))};
}

}  // namespace

// With global modal damping, degrees of freedom outside the substructure act on it too, through their cross damping.
// Their motion is therefore an input like that of the boundary.
DrivenSubstructure::DrivenSubstructure(const StructureModel& structure, const CoupledModel& model,
                                       const std::string& substructure)
    : place_(place_of(model, substructure)),
      driven_(driven_part(model, place_, boundary_of(structure, model, place_))),
      applied_(applied_inputs(structure, model, place_)) {
  for (const Index dof : driven_.boundary()) points_.push_back(reported_name(place_, dof));
  if (model.global_modal_damping())
    for (const Index dof : outside(model, place_))
      points_.push_back(model.system().dofs[static_cast<std::size_t>(dof)]);
}

}  // namespace kalfem
