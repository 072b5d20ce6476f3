#pragma once

#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/model/lumped.hpp"
#include "kalfem/system/coupling.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

/// The parts of a case as the library's own types, ready to be coupled.
struct StructureParts {
  std::vector<LumpedSubstructure> substructures;
  std::vector<Substructure>
      finite_elements;  ///< as matrices: reduced for the augmented model, full or reduced for the record
  std::vector<ConnectorDescription> connectors;
  std::vector<InputDescription> inputs;
  std::optional<GlobalModalDamping> damping = {};
};

/// Translates what the case says. Problems go to `issues` with their place; what had one is left out.
/// `finite_elements`: the case's finite-element substructures.
StructureParts make_parts(const description::Case& given, std::vector<Substructure> finite_elements, IssueList& issues);

/// Qualified names of all grounds.
std::vector<std::string> ground_names(const StructureParts& parts);

/// Points of a substructure that connectors and forces touch, without its name.
std::vector<std::string> attached_points(const description::Case& given, const std::string& substructure);

/// Assembles every substructure and couples. Throws InvalidInput with everything that does not fit.
CoupledModel couple(const StructureParts& parts);

/// One signal an input. `duration` is the period of random signals that have none of their own. What the user should
/// know of them goes to `notes`.
std::vector<SignalPtr> make_signals(const description::Case& given, const std::vector<InputDescription>& inputs,
                                    double duration, IssueList& issues, std::vector<std::string>& notes);

/// Point of a spring that has no name: "from-to".
std::string spring_name(const description::Spring& spring);

}  // namespace kalfem
