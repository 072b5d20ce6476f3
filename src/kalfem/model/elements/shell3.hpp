#pragma once

#include "kalfem/model/elements/element.hpp"

namespace kalfem {

/// Three-node shell (MITC3+).
ElementMatrices shell3(const Eigen::Matrix<double, 3, 3>& corners, double poissons_ratio, double thickness,
                       MassKind mass_kind);

}  // namespace kalfem
