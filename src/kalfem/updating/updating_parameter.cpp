#include "kalfem/updating/updating_parameter.hpp"

#include <cmath>

namespace kalfem {

double UpdatingParameter::scale() const {
  if (initial != 0.0) return std::abs(initial);
  const double width = upper - lower;
  return std::isfinite(width) && width > 0.0 ? width : 1.0;
}

Eigen::VectorXd initial_values(const std::vector<UpdatingParameter>& parameters) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i) values[static_cast<Eigen::Index>(i)] = parameters[i].initial;
  return values;
}

}  // namespace kalfem
