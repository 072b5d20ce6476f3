// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/identification/finite_element_part.hpp"
#include "kalfem/steps/correlation/outcome.hpp"
#include "kalfem/steps/modes/outcome.hpp"

namespace kalfem {

/// A measured shape m in the scale and phase of the model's a at the same points and directions: s m with
/// s = (m . a) / (m . m), which makes |s m - a| least.
struct ShapeOverMode {
  std::string name;               ///< "measured 34.88 Hz over mode 9, 34.95 Hz, MAC 0.952"
  Eigen::Index mode = 0;          ///< column of the model's shapes
  Eigen::Matrix3Xd displacement;  ///< at the measured nodes, 0 in directions that were not measured
};

/// Nodes at which a comparison measured a translation.
std::vector<Eigen::Index> measured_nodes(const CorrelatedComparison& comparison, const FiniteElementPart& part);

/// The shapes of a comparison on the mesh of a substructure.
struct MeasuredShapes {
  std::vector<Eigen::Index> nodes;   ///< at which something was measured
  std::vector<ShapeOverMode> pairs;  ///< of the measured modes that the correlation paired
};

/// `modes`: those of the part at the same values as the correlation. Points that are no single degree of freedom of a
/// node in x, y or z are left out, and pairs with modes beyond those given.
MeasuredShapes measured_shapes(const CorrelatedComparison& comparison, const FiniteElementPart& part,
                               const SubstructureModes& modes);

}  // namespace kalfem
