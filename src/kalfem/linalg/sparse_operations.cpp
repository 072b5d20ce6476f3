// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/sparse_operations.hpp"
#include "kalfem/linalg/large_pages.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;
using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

namespace {

constexpr double dense_fill = 0.25;  ///< part of all entries from which on dense products are faster

}  // namespace

PairedProduct::PairedProduct(const Eigen::SparseMatrix<double>& a, const Eigen::SparseMatrix<double>& b)
    : rows_(a.rows()) {
  const RowMatrix rows_a(a), rows_b(b);
  const bool both = b.nonZeros() > 0;
  start_.reserve(static_cast<std::size_t>(rows_) + 1);
  start_.push_back(0);
  for (Index row = 0; row < rows_; ++row) {
    RowMatrix::InnerIterator in_a(rows_a, row), in_b(rows_b, row);
    while (in_a || in_b) {
      const Index column = !in_b ? in_a.col() : !in_a ? in_b.col() : std::min(in_a.col(), in_b.col());
      const bool has_a = in_a && in_a.col() == column, has_b = in_b && in_b.col() == column;
      column_.push_back(static_cast<int>(column));
      a_.push_back(has_a ? in_a.value() : 0.0);
      if (both) b_.push_back(has_b ? in_b.value() : 0.0);
      if (has_a) ++in_a;
      if (has_b) ++in_b;
    }
    start_.push_back(static_cast<int>(column_.size()));
  }
  if (static_cast<double>(column_.size()) > dense_fill * static_cast<double>(a.rows() * a.cols())) {
    dense_a_ = a;
    if (both) dense_b_ = b;
    start_.clear(), column_.clear(), a_.clear(), b_.clear();
  }
  move_to_large_pages(a_);
  move_to_large_pages(b_);
  move_to_large_pages(column_);
}

void PairedProduct::multiply(const VectorXd& u, const VectorXd& v, VectorXd& y) const {
  if (dense_a_.size() > 0) {
    y.noalias() = dense_a_ * u;
    if (dense_b_.size() > 0) y.noalias() += dense_b_ * v;
  } else {
    y.resize(rows_);
    sweep(u.data(), v.data(), y.data());
  }
}

void PairedProduct::sweep(const double* u, const double* v, double* y) const {
  for (Index row = 0; row < rows_; ++row) {
    double sum = 0.0;
    const auto first = static_cast<std::size_t>(start_[static_cast<std::size_t>(row)]);
    const auto last = static_cast<std::size_t>(start_[static_cast<std::size_t>(row) + 1]);
    if (single())
      for (std::size_t k = first; k < last; ++k) sum += a_[k] * u[column_[k]];
    else
      for (std::size_t k = first; k < last; ++k) sum += a_[k] * u[column_[k]] + b_[k] * v[column_[k]];
    y[row] = sum;
  }
}

Eigen::SparseMatrix<double> select(const Eigen::SparseMatrix<double>& matrix, const std::vector<Index>& rows,
                                   const std::vector<Index>& columns) {
  std::vector<Index> position(static_cast<std::size_t>(matrix.rows()), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) position[static_cast<std::size_t>(rows[i])] = static_cast<Index>(i);
  const auto visit = [&](auto visitor) {
    for (std::size_t j = 0; j < columns.size(); ++j)
      for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, columns[j]); it; ++it)
        if (const Index i = position[static_cast<std::size_t>(it.row())]; i >= 0)
          visitor(i, static_cast<Index>(j), it.value());
  };
  Eigen::VectorXi counts = Eigen::VectorXi::Zero(static_cast<Index>(columns.size()));
  visit([&](Index, Index j, double) { ++counts[j]; });
  Eigen::SparseMatrix<double> block(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
  block.reserve(counts);
  visit([&](Index i, Index j, double value) { block.insert(i, j) = value; });  // at the end where rows ascend
  block.makeCompressed();
  return block;
}

}  // namespace kalfem
