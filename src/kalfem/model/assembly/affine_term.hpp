#pragma once

#include <map>
#include <string>
#include <vector>

#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// One term of a matrix that is affine in products of named parameters: (prod_p value_p^power_p) * matrix.
struct AffineTerm {
  std::map<std::string, int> powers;  ///< of parameters such as "steel.youngs_modulus", "tubes.thickness"
  SparseMatrix matrix;                ///< n x n over the free degrees of freedom, symmetric (both triangles)
};

/// prod_p value_p^power_p. Throws InvalidInput for a parameter without a value.
double affine_factor(const std::map<std::string, int>& powers, const std::map<std::string, double>& parameters);
/// The same of a term.
double affine_factor(const AffineTerm& term, const std::map<std::string, double>& parameters);

/// sum += matrix; a matrix of 0 x 0 stands for zero.
void add_to(SparseMatrix& sum, const SparseMatrix& matrix);

/// Sum of terms at the given parameter values, n x n; 0 x 0 without terms.
/// Throws InvalidInput for a parameter without a value.
SparseMatrix evaluate(const std::vector<AffineTerm>& terms, const std::map<std::string, double>& parameters);

}  // namespace kalfem
