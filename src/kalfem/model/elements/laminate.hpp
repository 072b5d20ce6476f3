#pragma once

#include "kalfem/model/elements/element.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem {

/// Shell of any cross-section, 3 x 3 or 3 x 4 corners [m]: shell3() or shell4() of a LaminateProperty. Its x axis is
/// `direction` laid into the surface, or the first side where that is zero.
ElementMatrices laminate(const Eigen::Matrix3Xd& corners, const LaminateProperty& property,
                         const Eigen::Vector3d& direction, MassKind mass_kind);

}  // namespace kalfem
