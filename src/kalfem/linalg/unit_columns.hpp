#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// The columns divided by their lengths; one without a length becomes 0. The work is linear in the number of rows.
Eigen::MatrixXd unit_columns(const Eigen::MatrixXd& columns);

}  // namespace kalfem
