// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "kalfem/model/elements/beam.hpp"

namespace kalfem {

/// A load along part of a beam's line, or at one place of it.
struct LineLoad {
  std::array<double, 2> places = {0.0, 1.0};  ///< where it begins and ends, shares of the length of the line
  /// Force and moment per length at both places, linear between them [N/m, N]; global axes.
  Eigen::Matrix<double, 6, 2> values = Eigen::Matrix<double, 6, 2>::Zero();
};

/// Forces and moments at the two nodes of a beam, global axes, that move them as a force and moment at the share `at`
/// of the beam's line does: f = N(at)^T p with the shapes N of the beam without load between its ends, those of its
/// stiffness. They come from two beams that meet there, f = -K_ei K_ii^-1 p of the ends e and the meeting i; hinges of
/// the ends and offsets as in beam(). Throws ElementShapeError as beam() does.
Eigen::Matrix<double, 12, 1> nodal_forces_of_point_load(const Eigen::Matrix<double, 3, 2>& ends,
                                                        const BeamProperty& property, const BeamPlacement& placement,
                                                        double poissons_ratio, double at,
                                                        const Eigen::Matrix<double, 6, 1>& load);

/// The same of a load along the line: int N^T p ds by Gauss's rule, exactly.
Eigen::Matrix<double, 12, 1> nodal_forces_of_line_load(const Eigen::Matrix<double, 3, 2>& ends,
                                                       const BeamProperty& property, const BeamPlacement& placement,
                                                       double poissons_ratio, const LineLoad& load);

/// Local axes of a beam's line, rows x, y, z.
Eigen::Matrix3d beam_axes(const Eigen::Matrix<double, 3, 2>& ends, const BeamPlacement& placement);

}  // namespace kalfem
