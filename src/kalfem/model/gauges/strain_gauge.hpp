// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/linear_model.hpp"
#include "kalfem/model/statics/stresses.hpp"

namespace kalfem {

/// A strain gauge on one cell of a finite-element model: it measures the normal strain along its direction d at one
/// place, d^T epsilon d, as the stiffness of the element assumes it.
struct StrainGauge {
  std::string name;
  Eigen::Index cell = 0;
  Eigen::Vector3d natural = Eigen::Vector3d::Zero();    ///< place in the cell, see CellPlace
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< in global axes; of a beam its axis, whatever stands here
  Layer surface = Layer::solid;                         ///< of a shell: top, middle or bottom
  Eigen::Vector2d fibre = Eigen::Vector2d::Zero();      ///< of a beam: local y and z from the centroid [m]
};

/// Coefficients of the strain over the motions of the cell's nodes [1/m, 1/rad]. By the kind of the property:
///     solid  d^T epsilon d of solid_strains(), linear between the corners;
///     shell  with a = d laid into the surface, a^T (e + z k) a of shell_strains(), bilinear between the corners, and z
///            half the thickness at the top, less it at the bottom;
///     beam   (N / A + bending stress of the fibre) / E of beam_forces(), linear between the ends.
/// Throws InvalidInput where the direction is nearly normal to the shell, or the layer of a laminate is not its middle.
DofSum strain_row(const FiniteElementModel& model, const StrainGauge& gauge);

/// The same over the independent degrees of freedom of the assembled model, by gauge. Throws InvalidInput with every
/// gauge whose element cannot deform, as its nodes are fixed or belong to one rigid body.
std::map<std::string, DofCombination> gauge_combinations(const FiniteElementModel& model,
                                                         const AssembledModel& assembled,
                                                         const std::vector<StrainGauge>& gauges);

}  // namespace kalfem
