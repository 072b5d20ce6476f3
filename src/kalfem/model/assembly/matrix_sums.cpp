// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/matrix_sums.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

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

// The pattern of a sum of element matrices in two passes over the elements, without a list of triplets, which would
// take several times the memory of the matrix:
//   1. count the entries that each column gets, with repetitions;
//   2. write the rows into their columns; sort each and drop what it holds twice.
// Values are added by a search in the sorted column. Only the lower triangle is kept.
SparseSumPattern::SparseSumPattern(Eigen::Index size, const std::function<void(const Visitor&)>& for_each)
    : starts_(static_cast<std::size_t>(size) + 1, 0) {
  for_each([&](const Scatter& scatter) {
    for (const auto& target : scatter)
      starts_[static_cast<std::size_t>(target.column) + 1] += static_cast<std::size_t>(
          std::ranges::count_if(scatter, [&](const auto& other) { return other.column >= target.column; }));
  });
  for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
  rows_.resize(starts_.back());
  std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
  for_each([&](const Scatter& scatter) {
    for (const auto& target : scatter)
      for (const auto& other : scatter)
        if (other.column >= target.column) rows_[next[static_cast<std::size_t>(target.column)]++] = other.column;
  });
  compress();
}

/// Sorts each column and drops what it holds twice.
void SparseSumPattern::compress() {
  std::size_t kept = 0, first = 0;
  for (std::size_t column = 0; column + 1 < starts_.size(); ++column) {
    const auto begin = rows_.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = rows_.begin() + static_cast<std::ptrdiff_t>(starts_[column + 1]);
    first = starts_[column + 1];
    std::sort(begin, end);
    const auto unique_end = std::unique(begin, end);
    starts_[column] = kept;
    std::copy(begin, unique_end, rows_.begin() + static_cast<std::ptrdiff_t>(kept));
    kept += static_cast<std::size_t>(unique_end - begin);
  }
  starts_.back() = kept;
  rows_.resize(kept);
  rows_.shrink_to_fit();
}

void SparseSumPattern::add(const Scatter& scatter, const Eigen::MatrixXd& matrix, std::vector<double>& values) const {
  for (const auto& [column_row, column, column_coefficient] : scatter) {
    const auto begin = rows_.begin() + static_cast<std::ptrdiff_t>(starts_[static_cast<std::size_t>(column)]);
    const auto end = rows_.begin() + static_cast<std::ptrdiff_t>(starts_[static_cast<std::size_t>(column) + 1]);
    for (const auto& [row_row, row, row_coefficient] : scatter) {
      if (row < column) continue;
      const double value = matrix(std::min(row_row, column_row), std::max(row_row, column_row));
      if (value == 0.0) continue;
      const auto place = std::lower_bound(begin, end, row) - rows_.begin();
      values[static_cast<std::size_t>(place)] += (row_coefficient * column_coefficient) * value;
    }
  }
}

// Both triangles are written at once. What a column mirrors of those before it is there when its own entries come, so
// that its rows ascend.
Eigen::SparseMatrix<double> SparseSumPattern::matrix(const std::vector<double>& values) const {
  const auto size = static_cast<int>(starts_.size()) - 1;
  const auto visit = [&](auto visitor) {
    for (int column = 0; column < size; ++column)
      for (auto i = starts_[static_cast<std::size_t>(column)]; i < starts_[static_cast<std::size_t>(column) + 1]; ++i)
        if (values[i] != 0.0) visitor(rows_[i], column, values[i]);
  };
  Eigen::SparseMatrix<double> sum(size, size);
  int* const starts = sum.outerIndexPtr();
  visit([&](int row, int column, double) {
    ++starts[column + 1];
    if (row != column) ++starts[row + 1];
  });
  std::partial_sum(starts, starts + size + 1, starts);
  sum.resizeNonZeros(starts[size]);
  std::vector<int> next(starts, starts + size);
  const auto put = [&](int row, int column, double value) {
    const int place = next[static_cast<std::size_t>(column)]++;
    sum.innerIndexPtr()[place] = row;
    sum.valuePtr()[place] = value;
  };
  visit([&](int row, int column, double value) {
    put(row, column, value);
    if (row != column) put(column, row, value);
  });
  return sum;
}

}  // namespace kalfem
