#pragma once

#include "kalfem/model/elements/element.hpp"

namespace kalfem {

/// Four-node shell (MITC4+).
ElementMatrices shell4(const Eigen::Matrix<double, 3, 4>& corners, double poissons_ratio, double thickness,
                       MassKind mass_kind);

}  // namespace kalfem
