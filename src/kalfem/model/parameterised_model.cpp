// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/parameterised_model.hpp"

#include <algorithm>

#include "kalfem/model/assembly/matrix_sums.hpp"

namespace kalfem {

using Eigen::Index;
using Kind = LumpedParameter::Kind;

namespace {

/// The substructure with nothing in it but the parameter, at 1: its matrices are the derivatives.
LumpedSubstructure unit_substructure(LumpedSubstructure substructure, const LumpedParameter& parameter) {
  substructure.modal_damping.clear();
  substructure.rayleigh = {};
  substructure.matrices.damping = substructure.matrices.stiffness = SparseMatrix();
  for (auto& spring : substructure.springs) spring.stiffness = spring.damping = 0.0;
  set_value(substructure, parameter, 1.0);
  return substructure;
}

bool is_ratio(Kind kind) { return kind == Kind::modal_ratio || kind == Kind::all_modal_ratios; }

}  // namespace

// Lists the parameters by the names of a case file: spring.stiffness, spring.damping, dof.mass, damping.modal for all
// ratios at once, damping.modal.<i> for one, and both Rayleigh factors. The last exist even where they are zero, so
// that they can be estimated from a prior.
std::vector<std::pair<std::string, LumpedParameter>> parameters_of(const LumpedSubstructure& substructure) {
  std::vector<std::pair<std::string, LumpedParameter>> all;
  for (std::size_t i = 0; i < substructure.springs.size(); ++i) {
    all.push_back({substructure.springs[i].name + ".stiffness", {Kind::stiffness, i}});
    all.push_back({substructure.springs[i].name + ".damping", {Kind::damping, i}});
  }
  for (std::size_t i = 0; i < substructure.masses.size(); ++i)
    all.push_back({substructure.masses[i].dof + ".mass", {Kind::mass, i}});
  if (!substructure.modal_damping.empty()) all.push_back({"damping.modal", {Kind::all_modal_ratios, 0}});
  for (std::size_t i = 0; i < substructure.modal_damping.size(); ++i)
    all.push_back({"damping.modal." + std::to_string(i + 1), {Kind::modal_ratio, i}});
  all.push_back({"damping.mass_factor", {Kind::mass_factor, 0}});
  all.push_back({"damping.stiffness_factor", {Kind::stiffness_factor, 0}});
  return all;
}

std::string unit_of(Kind kind) {
  switch (kind) {
    case Kind::stiffness:
      return "N/m";
    case Kind::damping:
      return "N s/m";
    case Kind::mass:
      return "kg";
    case Kind::mass_factor:
      return "1/s";
    case Kind::stiffness_factor:
      return "s";
    case Kind::modal_ratio:
    case Kind::all_modal_ratios:
      break;
  }
  return "-";
}

double value_of(const LumpedSubstructure& substructure, const LumpedParameter& parameter) {
  return [&]() -> double {
    switch (parameter.kind) {
      case Kind::stiffness:
        return substructure.springs[parameter.element].stiffness;
      case Kind::damping:
        return substructure.springs[parameter.element].damping;
      case Kind::mass:
        return substructure.masses[parameter.element].mass;
      case Kind::mass_factor:
        return substructure.rayleigh.mass_factor;
      case Kind::stiffness_factor:
        return substructure.rayleigh.stiffness_factor;
      case Kind::modal_ratio:
      case Kind::all_modal_ratios:
        break;
    }
    return substructure.modal_damping[parameter.element];
  }();
}

void set_value(LumpedSubstructure& substructure, const LumpedParameter& parameter, double value) {
  switch (parameter.kind) {
    case Kind::stiffness:
      substructure.springs[parameter.element].stiffness = value;
      break;
    case Kind::damping:
      substructure.springs[parameter.element].damping = value;
      break;
    case Kind::mass:
      substructure.masses[parameter.element].mass = value;
      break;
    case Kind::mass_factor:
      substructure.rayleigh.mass_factor = value;
      break;
    case Kind::stiffness_factor:
      substructure.rayleigh.stiffness_factor = value;
      break;
    case Kind::modal_ratio:
      substructure.modal_damping[parameter.element] = value;
      break;
    case Kind::all_modal_ratios:
      std::ranges::fill(substructure.modal_damping, value);
      break;
  }
}

ParameterisedLumped::ParameterisedLumped(LumpedSubstructure substructure,
                                         std::vector<ParameterBinding<LumpedParameter>> bindings, Index count)
    : substructure_(std::move(substructure)), bindings_(std::move(bindings)), count_(count) {}

LumpedSubstructure ParameterisedLumped::substructure_at(const Eigen::VectorXd& parameters) const {
  LumpedSubstructure substructure = substructure_;
  for (const auto& [index, target] : bindings_) set_value(substructure, target, parameters[index]);
  return substructure;
}

// Modal ratios are taken out before the assembly, which would need the modes at every new value: who works in modes
// applies them there.
ModelAtParameters ParameterisedLumped::at(const Eigen::VectorXd& parameters) const {
  LumpedSubstructure substructure = substructure_at(parameters);
  ModalRatios ratios;
  std::swap(ratios.values, substructure.modal_damping);
  return {assemble(substructure), ratios};
}

// K, C and M are linear in springs, dashpots and masses, so a derivative is the assembly of the parameter alone at 1.
// Rayleigh damping follows by the chain rule: dC = alpha dM + beta dK, and dC = M or K for its factors. Several targets
// of one parameter add up.
std::vector<ModelDerivative> ParameterisedLumped::derivatives(const Eigen::VectorXd& parameters) const {
  const LumpedSubstructure present = substructure_at(parameters);
  const auto& [alpha, beta] = present.rayleigh;
  std::vector<ModelDerivative> all(static_cast<std::size_t>(count_));
  for (const auto& [index, target] : bindings_) {
    auto& derivative = all[static_cast<std::size_t>(index)];
    if (is_ratio(target.kind)) {
      derivative.modal_ratios.resize(present.modal_damping.size(), 0.0);
      for (std::size_t i = 0; i < present.modal_damping.size(); ++i)
        if (target.kind == Kind::all_modal_ratios || i == target.element) derivative.modal_ratios[i] = 1.0;
      continue;
    }
    const LinearModel unit = assemble(unit_substructure(present, target));
    if (target.kind == Kind::mass_factor) {
      add_to(derivative.damping, unit.mass);
    } else if (target.kind == Kind::stiffness_factor) {
      add_to(derivative.damping, at(parameters).model.stiffness);
    } else if (target.kind == Kind::mass) {
      SparseMatrix mass(unit.size(), unit.size());
      const Index row = std::ssize(present.matrices.dofs) + static_cast<Index>(target.element);
      mass.insert(row, row) = 1.0;
      add_to(derivative.mass, mass);
      if (alpha != 0.0) add_to(derivative.damping, alpha * mass);
    } else if (target.kind == Kind::stiffness) {
      add_to(derivative.stiffness, unit.stiffness);
      if (beta != 0.0) add_to(derivative.damping, beta * unit.stiffness);
    } else {
      add_to(derivative.damping, unit.damping);
    }
  }
  return all;
}

}  // namespace kalfem
