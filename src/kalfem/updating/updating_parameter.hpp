#pragma once

#include <Eigen/Dense>
#include <limits>
#include <string>
#include <vector>

namespace kalfem {

/// A parameter that the updating changes.
struct UpdatingParameter {
  std::string name;                                         ///< "frame.rails.thickness"
  std::string unit;                                         ///< SI
  double initial = 0.0;                                     ///< start and, with a prior, its mean
  double lower = -std::numeric_limits<double>::infinity();  ///< initial lies between the bounds
  double upper = std::numeric_limits<double>::infinity();
  double deviation = std::numeric_limits<double>::infinity();  ///< standard deviation of the prior; infinite: no prior

  /// A step of this size changes the parameter noticeably: |initial|, or the width of the bounds where it is 0, or 1.
  [[nodiscard]] double scale() const;
};

/// Initial values, one a parameter.
Eigen::VectorXd initial_values(const std::vector<UpdatingParameter>& parameters);

}  // namespace kalfem
