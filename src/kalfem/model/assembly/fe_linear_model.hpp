#pragma once

#include <optional>
#include <string>

#include "kalfem/model/assembly/assembly.hpp"

namespace kalfem {

/// A named place of a finite-element model.
struct NamedNode {
  std::string name;
  Eigen::Index node = 0;
  std::optional<double> distance = {};  ///< of the node from the place that the user gave, where one was given [m]
};

/// How a finite-element substructure is damped, beside its dashpots: C = C_dashpots + alpha M + beta K.
struct FeDamping {
  double mass_factor = 0.0;       ///< Rayleigh alpha [1/s]
  double stiffness_factor = 0.0;  ///< Rayleigh beta [s]
};

/// The assembled matrices as a LinearModel: degrees of freedom named "n<node id>.<direction>", each named node's six
/// motions as points "<name>.<direction>" through the expansion (a fixed one is left out). Rayleigh damping acts on the
/// motion relative to the shape in which the model follows slowly moving grounds, K s = k_g. Without modal damping.
/// Throws InvalidInput for factors that are negative, nodes that do not exist, and names given twice or that are taken
/// by another node.
LinearModel linear_model(const FiniteElementModel& model, const AssembledModel& assembled,
                         const std::vector<NamedNode>& points, const FeDamping& damping);

}  // namespace kalfem
