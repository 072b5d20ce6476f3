#include "kalfem/model/affine_term.hpp"

#include <cmath>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

double affine_factor(const AffineTerm& term, const std::map<std::string, double>& parameters) {
  double product = 1.0;
  for (const auto& [name, power] : term.powers) {
    const auto value = parameters.find(name);
    if (value == parameters.end())
      throw InvalidInput("the parameter '" + name + "' has no value", "a matrix depends on it",
                         "start from the values of the assembled model");
    product *= std::pow(value->second, power);
  }
  return product;
}

SparseMatrix evaluate(const std::vector<AffineTerm>& terms, const std::map<std::string, double>& parameters) {
  SparseMatrix sum;
  for (const auto& term : terms) {
    const double factor = affine_factor(term, parameters);
    sum = sum.size() == 0 ? SparseMatrix(factor * term.matrix) : SparseMatrix(sum + factor * term.matrix);
  }
  return sum;
}

}  // namespace kalfem
