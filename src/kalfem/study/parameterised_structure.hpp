#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/study/study.hpp"

namespace kalfem {

/// Nothing where there is no such parameter.
std::optional<StructureParameter> find_structure_parameter(const Study& study, const std::string& name);
std::vector<std::string> structure_parameter_names(const Study& study);

/// What is wrong with `damping.modal` as one parameter where the substructure's ratios differ: it would make them one
/// number. Nothing for other parameters.
std::optional<Issue> unlike_ratios(const Study& study, const StructureParameter& parameter,
                                   const description::Name& name);

/// The linear substructures of a case as functions of theta. The case must outlive it.
class ParameterisedStructure {
public:
  ParameterisedStructure(const Study& study, const std::vector<StructureBinding>& bindings, Eigen::Index count);

  /// The matrices of one substructure, at full order.
  [[nodiscard]] std::shared_ptr<const ParameterisedModel> model_of(const std::string& substructure) const;
  /// Every finite-element substructure is reduced anew, with as many modes as the case's own reduction has.
  [[nodiscard]] StructureAtParameters at(const Eigen::VectorXd& parameters) const;
  /// The parts at another theta, their finite elements in the bases of `structure`: what sensitivities need, for next
  /// to nothing.
  [[nodiscard]] StructureParts near(const StructureAtParameters& structure, const Eigen::VectorXd& parameters) const;

private:
  [[nodiscard]] StructureParts with_lumped_at(const Eigen::VectorXd& parameters) const;
  [[nodiscard]] std::shared_ptr<const ParameterisedModel> reduced_at(std::size_t index,
                                                                     const Eigen::VectorXd& parameters) const;

  const Study& study_;
  std::vector<std::shared_ptr<const ParameterisedLumped>> lumped_;                   ///< one a lumped substructure
  std::vector<std::shared_ptr<const ParameterisedFiniteElements>> finite_elements_;  ///< one a finite-element one
};

/// The case's structure as a function of what its updating refines.
std::shared_ptr<const ParameterisedStructure> parameterised_structure(const Study& study);

}  // namespace kalfem
