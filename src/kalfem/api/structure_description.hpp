// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "kalfem/api/structure.hpp"
#include "kalfem/identification/parameter_set.hpp"
#include "kalfem/identification/structure.hpp"

namespace kalfem {

/// Where a structure was read from; whoever reads it derives from this.
struct StructureOrigin {
  virtual ~StructureOrigin() = default;
};

/// What a structure keeps of the case that it was read from.
struct ReadStructure {
  std::vector<FiniteElementSubstructure> finite_elements;  ///< assembled and reduced
  std::shared_ptr<const StructureOrigin> origin;
  NamedValues set = {};  ///< that Structure::at() gave since, the last one counts
};

/// The contents of a Structure: descriptions, from which models are made on demand.
struct StructureDescription {
  StructureParts parts;  ///< without finite elements
  std::vector<FiniteElements> finite_elements;
  std::vector<SignalPtr> signals;               ///< one per input of the parts; nullptr if its values come online
  std::vector<std::string> by_velocity = {};    ///< inputs that move a ground by samples of its velocity
  std::map<std::string, Samples> samples = {};  ///< of the inputs whose signals go through samples
  ReadStructure read = {};
};

/// The use of a model of the structure.
struct ModelUse {
  std::vector<std::string> parameters = {};                           ///< that vary
  double sensor_bandwidth = std::numeric_limits<double>::infinity();  ///< [Hz]
};

/// The structure as the library's own types, its finite elements assembled and reduced. Throws InvalidInput with
/// everything that does not fit.
StructurePtr make_structure_model(const StructureDescription& description, const ModelUse& use = {});

/// Signals that a run over a record needs. Throws InvalidInput with every input that has none.
void require_signals(const StructureDescription& description);

/// The parameter with that name. Throws InvalidInput, with `what` before the message, if there is none.
Parameter find_parameter(const ParameterSet& all, const std::string& name, const std::string& what);

}  // namespace kalfem
