// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <functional>
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

/// Where one row of a small matrix goes: to `column` of the large one, times `coefficient`. A row that goes to several
/// columns has several targets, one that is fixed has none.
struct ScatterTarget {
  int row = 0;
  int column = 0;
  double coefficient = 1.0;
};
using Scatter = std::vector<ScatterTarget>;

/// The common pattern of sums S = sum_e T_e^T A_e T_e of many small symmetric matrices that are scattered alike. The
/// pattern is counted and filled before any value is known, and only its lower triangle is kept, so that memory stays a
/// small multiple of the sums.
class SparseSumPattern {
public:
  using Visitor = std::function<void(const Scatter&)>;

  /// `for_each` calls its visitor with the scatter of every small matrix; it is called twice.
  SparseSumPattern(Eigen::Index size, const std::function<void(const Visitor&)>& for_each);

  /// Values of a sum that is zero so far.
  [[nodiscard]] std::vector<double> zero() const { return std::vector<double>(rows_.size(), 0.0); }
  /// values += T_e^T A_e T_e. Only the upper triangle of A_e is read.
  void add(const Scatter& scatter, const Eigen::MatrixXd& matrix, std::vector<double>& values) const;
  /// The sum as a matrix, both triangles, without the entries that are exactly 0.
  [[nodiscard]] Eigen::SparseMatrix<double> matrix(const std::vector<double>& values) const;

private:
  void compress();

  std::vector<std::size_t> starts_;  ///< of each column in rows_
  std::vector<int> rows_;            ///< at and below the diagonal, ascending in each column
};

}  // namespace kalfem
