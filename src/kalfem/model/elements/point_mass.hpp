#pragma once

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Mass of a body at a node, its centre off the node by o (parallel axes): with the cross-product matrix [o],
///     M = [m 1, -m [o]; m [o], J - m [o][o]],   6 x 6 in the node's degrees of freedom, global axes.
Eigen::Matrix<double, 6, 6> point_mass(const PointMass& mass);

}  // namespace kalfem
