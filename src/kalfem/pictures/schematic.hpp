// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/identification/structure.hpp"

namespace kalfem {

/// What a schematic shows of a structure beside its parts.
struct SchematicOptions {
  std::vector<std::string> unknown_connectors = {};  ///< drawn as what is looked for
  Eigen::Index most_masses = 30;  ///< a substructure with more degrees of freedom is one box with its used points
};

/// Masses, springs, dashpots and connectors between grounds below and what stands on them above, with the names of
/// sensors to the right of what they measure, of forces to the left, and of moving grounds below. A finite-element
/// substructure is a box. One self-contained SVG element; empty where there is nothing to draw.
std::string schematic_svg(const StructureParts& parts, const std::vector<Sensor>& sensors,
                          const SchematicOptions& options = {});

}  // namespace kalfem
