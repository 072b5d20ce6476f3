#include "kalfem/study/parameterised_structure.hpp"

#include <algorithm>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

namespace d = description;

const d::Damping& description_of_damping(const Study& study, const std::string& substructure) {
  return std::ranges::find(study.given.substructures, substructure, &std::pair<std::string, d::Substructure>::first)
      ->second.damping;
}

FiniteElementDamping damping_of(const Study& study, const std::string& substructure) {
  const d::Damping& given = description_of_damping(study, substructure);
  return {{given.mass_factor, given.stiffness_factor}, {given.modal, given.modal_up_to}};
}

const std::optional<Located<d::Reduction>>& reduction_of(const Study& study, const std::string& substructure) {
  return std::ranges::find(study.given.substructures, substructure, &std::pair<std::string, d::Substructure>::first)
      ->second.reduction;
}

/// A spring's stiffness is along a displacement or about an axis.
std::string unit_of(const FiniteElementModel& model, const FiniteElementParameter& parameter) {
  const std::string unit = kalfem::unit_of(parameter);
  if (!unit.empty()) return unit;
  for (const auto& spring : model.springs)
    if (parameter.name == spring.name + ".stiffness" && spring.from.direction >= 3) return "N m/rad";
  return "N/m";
}

/// Visits every parameter of every linear substructure.
template <class Visitor>
void visit_parameters(const Study& study, const Visitor& visit) {
  for (const auto& part : study.parts.substructures)
    for (const auto& [name, target] : parameters_of(part))
      visit(part.name + "." + name, StructureParameter{part.name + "." + name, part.name, target,
                                                       kalfem::unit_of(target.kind), value_of(part, target)});
  for (const auto& elements : study.finite_elements) {
    const auto damping = damping_of(study, elements.part->name);
    for (const auto& [name, target] : parameters_of(elements.part->assembled, damping))
      visit(elements.part->name + "." + name, StructureParameter{elements.part->name + "." + name, elements.part->name,
                                                                 target, unit_of(elements.part->elements, target),
                                                                 value_of(elements.part->assembled, damping, target)});
  }
}

/// The bindings of one substructure to its own kind of parameter.
template <class Target>
std::vector<ParameterBinding<Target>> bindings_of(const std::vector<StructureBinding>& all,
                                                  const std::string& substructure) {
  std::vector<ParameterBinding<Target>> own;
  for (const auto& [index, parameter] : all)
    if (parameter.substructure == substructure) own.push_back({index, std::get<Target>(parameter.target)});
  return own;
}

/// Ratios of all modes, one a mode: above their limit they fall as 1 / omega, as add_modal_damping() damps the modes of
/// a large model. None where no mode lies below it.
std::vector<double> ratios_of_all(const VectorXd& frequencies, const ModalRatios& ratios) {
  const Index below = (frequencies.array() <= ratios.up_to).count();
  if (below == 0) return {};
  std::vector<double> all;
  for (Index i = 0; i < frequencies.size(); ++i)
    all.push_back(i < below ? ratios.values[std::min(static_cast<std::size_t>(i), ratios.values.size() - 1)]
                            : all[static_cast<std::size_t>(below) - 1] * frequencies[below - 1] / frequencies[i]);
  return all;
}

LinearModel damped(ModelAtParameters at) {
  auto& [model, ratios] = at;
  if (ratios.empty()) return model;
  const NormalModes modes = normal_modes(model.mass, model.stiffness);
  const auto all = ratios_of_all(modes.frequencies, ratios);
  model.damping = SparseMatrix(model.damping + modal_damping(model.mass, modes, all));
  return model;
}

}  // namespace

std::optional<StructureParameter> find_structure_parameter(const Study& study, const std::string& name) {
  std::optional<StructureParameter> found;
  visit_parameters(study, [&](const std::string& candidate, StructureParameter&& parameter) {
    if (candidate == name) found = std::move(parameter);
  });
  return found;
}

std::optional<Issue> unlike_ratios(const Study& study, const StructureParameter& parameter, const d::Name& name) {
  if (!parameter.name.ends_with(".damping.modal")) return std::nullopt;
  const auto& ratios = std::ranges::find(study.given.substructures, parameter.substructure,
                                         &std::pair<std::string, d::Substructure>::first)
                           ->second.damping.modal;
  if (std::ranges::adjacent_find(ratios, std::ranges::not_equal_to{}) == ratios.end()) return std::nullopt;
  std::string listed;
  for (const double ratio : ratios) listed += (listed.empty() ? "" : ", ") + shortest(100.0 * ratio) + " %";
  return name.issue(
      "'" + parameter.name + "' stands for all modal ratios as one number, and the case gives [" + listed + "]",
      "these would all become the same",
      "name single ratios, " + parameter.name + ".1 and so on; several share a value by applies_to");
}

std::vector<std::string> structure_parameter_names(const Study& study) {
  std::vector<std::string> names;
  visit_parameters(study, [&](const std::string& name, StructureParameter&&) { names.push_back(name); });
  for (const auto& elements : study.finite_elements)
    for (const auto& [factor, value] : beam_factors(elements.part->elements))
      names.push_back(elements.part->name + "." + factor);
  return names;
}

ParameterisedStructure::ParameterisedStructure(const Study& study, const std::vector<StructureBinding>& bindings,
                                               Index count)
    : study_(study) {
  for (const auto& part : study.parts.substructures)
    lumped_.push_back(
        std::make_shared<const ParameterisedLumped>(part, bindings_of<LumpedParameter>(bindings, part.name), count));
  for (const auto& elements : study.finite_elements) {
    const auto& part = elements.part;
    finite_elements_.push_back(std::make_shared<const ParameterisedFiniteElements>(
        std::shared_ptr<const AssembledModel>(part, &part->assembled),
        std::shared_ptr<const LinearModel>(part, &part->full), damping_of(study, part->name),
        bindings_of<FiniteElementParameter>(bindings, part->name), count));
  }
}

std::shared_ptr<const ParameterisedModel> ParameterisedStructure::model_of(const std::string& substructure) const {
  for (std::size_t i = 0; i < lumped_.size(); ++i)
    if (study_.parts.substructures[i].name == substructure) return lumped_[i];
  for (std::size_t i = 0; i < finite_elements_.size(); ++i)
    if (study_.finite_elements[i].part->name == substructure) return finite_elements_[i];
  return nullptr;
}

StructureParts ParameterisedStructure::with_lumped_at(const VectorXd& parameters) const {
  StructureParts parts = study_.parts;
  for (std::size_t i = 0; i < lumped_.size(); ++i) parts.substructures[i] = lumped_[i]->substructure_at(parameters);
  parts.finite_elements.clear();
  return parts;
}

std::shared_ptr<const ParameterisedModel> ParameterisedStructure::reduced_at(std::size_t index,
                                                                             const VectorXd& parameters) const {
  const auto& elements = study_.finite_elements[index];
  if (!elements.reduced) return finite_elements_[index];
  const auto reduced = reduce_again(*elements.part, finite_elements_[index]->at(parameters).model,
                                    reduction_of(study_, elements.part->name), elements.reduced->error_indicators);
  return std::make_shared<const ParameterisedFiniteElements>(
      finite_elements_[index]->in_basis(reduced.basis, reduced.model, parameters));
}

StructureAtParameters ParameterisedStructure::at(const VectorXd& parameters) const {
  StructureAtParameters structure;
  for (std::size_t i = 0; i < finite_elements_.size(); ++i) structure.in_basis.push_back(reduced_at(i, parameters));
  structure.parts = near(structure, parameters);
  return structure;
}

StructureParts ParameterisedStructure::near(const StructureAtParameters& structure, const VectorXd& parameters) const {
  StructureParts parts = with_lumped_at(parameters);
  for (std::size_t i = 0; i < structure.in_basis.size(); ++i) {
    const std::string& name = study_.finite_elements[i].part->name;
    parts.finite_elements.push_back({name, damped(structure.in_basis[i]->at(parameters))});
  }
  return parts;
}

std::shared_ptr<const ParameterisedStructure> parameterised_structure(const Study& study) {
  const auto& [parameters, bindings, truth] = *study.updating;
  return std::make_shared<const ParameterisedStructure>(study, bindings, static_cast<Index>(parameters.size()));
}

}  // namespace kalfem
