#include "kalfem/updating/residual.hpp"

#include <cmath>

namespace kalfem {

using Eigen::Index;

Index ResidualSum::size() const {
  Index sum = 0;
  for (const auto& term : terms_) sum += term.residual->size();
  return sum;
}

std::optional<ResidualValue> ResidualSum::evaluate(const Eigen::VectorXd& parameters, bool with_jacobian) const {
  ResidualValue sum{Eigen::VectorXd(size()), {}};
  if (with_jacobian) sum.jacobian.resize(size(), parameters.size());
  Index first = 0;
  for (const auto& [residual, weight] : terms_) {
    const auto part = residual->evaluate(parameters, with_jacobian);
    if (!part) return std::nullopt;
    sum.values.segment(first, part->values.size()) = std::sqrt(weight) * part->values;
    if (with_jacobian) sum.jacobian.middleRows(first, part->values.size()) = std::sqrt(weight) * part->jacobian;
    first += part->values.size();
  }
  return sum;
}

}  // namespace kalfem
