#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// The entries of a vector, as a series of a chart holds them.
inline std::vector<double> series_values(const Eigen::VectorXd& vector) { return {vector.begin(), vector.end()}; }

}  // namespace kalfem
