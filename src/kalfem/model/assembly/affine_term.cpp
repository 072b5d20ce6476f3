#include "kalfem/model/assembly/affine_term.hpp"

#include <cmath>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

double affine_factor(const std::map<std::string, int>& powers, const std::map<std::string, double>& parameters) {
  double product = 1.0;
  for (const auto& [name, power] : powers) {
    const auto value = parameters.find(name);
    if (value == parameters.end())
      throw InvalidInput("the parameter '" + name + "' has no value", "a matrix depends on it",
                         "start from the values of the assembled model");
    product *= std::pow(value->second, power);
  }
  return product;
}

double affine_factor(const AffineTerm& term, const std::map<std::string, double>& parameters) {
  return affine_factor(term.powers, parameters);
}

void add_to(SparseMatrix& sum, const SparseMatrix& matrix) {
  if (matrix.size() == 0) return;
  sum = sum.size() == 0 ? matrix : SparseMatrix(sum + matrix);
}

SparseMatrix evaluate(const std::vector<AffineTerm>& terms, const std::map<std::string, double>& parameters) {
  SparseMatrix sum;
  for (const auto& term : terms) add_to(sum, affine_factor(term, parameters) * term.matrix);
  return sum;
}

}  // namespace kalfem
