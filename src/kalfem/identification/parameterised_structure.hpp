// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/identification/parameter_set.hpp"

namespace kalfem {

/// The parts of a structure at some theta, its finite elements reduced there.
struct StructureAtParameters {
  StructureParts parts;
  /// The finite-element substructures as functions of theta, in the bases of their reduction.
  std::vector<std::shared_ptr<const ParameterisedModel>> in_basis;
};

/// The linear substructures of a structure as functions of theta. Immutable; it shares the structure.
class ParameterisedStructure {
public:
  /// `count`: length of theta. Parameters of connectors among the bindings are left to the caller, who couples the
  /// parts.
  ParameterisedStructure(StructurePtr structure, const std::vector<StructureBinding>& bindings, Eigen::Index count);

  /// The matrices of one substructure at full order; nullptr if there is none with that name.
  [[nodiscard]] std::shared_ptr<const ParameterisedModel> model_of(const std::string& substructure) const;
  /// Every finite-element substructure is reduced anew, with as many modes as the structure's own reduction has.
  [[nodiscard]] StructureAtParameters at(const Eigen::VectorXd& parameters) const;
  /// The parts at another theta, their finite elements in the bases of `structure`: a cheap model for sensitivities.
  [[nodiscard]] StructureParts near(const StructureAtParameters& structure, const Eigen::VectorXd& parameters) const;

private:
  [[nodiscard]] StructureParts with_lumped_at(const Eigen::VectorXd& parameters) const;
  [[nodiscard]] std::shared_ptr<const ParameterisedModel> reduced_at(std::size_t index,
                                                                     const Eigen::VectorXd& parameters) const;

  StructurePtr structure_;
  std::vector<std::shared_ptr<const ParameterisedLumped>> lumped_;                   ///< one per lumped substructure
  std::vector<std::shared_ptr<const ParameterisedFiniteElements>> finite_elements_;  ///< one per finite-element one
};

}  // namespace kalfem
