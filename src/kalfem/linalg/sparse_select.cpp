#include "kalfem/linalg/sparse_select.hpp"

namespace kalfem {

using Eigen::Index;

Eigen::SparseMatrix<double> select(const Eigen::SparseMatrix<double>& matrix, const std::vector<Index>& rows,
                                   const std::vector<Index>& columns) {
  std::vector<Index> position(static_cast<std::size_t>(matrix.rows()), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) position[static_cast<std::size_t>(rows[i])] = static_cast<Index>(i);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t j = 0; j < columns.size(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, columns[j]); it; ++it)
      if (const Index i = position[static_cast<std::size_t>(it.row())]; i >= 0)
        entries.emplace_back(i, static_cast<Index>(j), it.value());
  Eigen::SparseMatrix<double> block(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
  block.setFromTriplets(entries.begin(), entries.end());
  return block;
}

}  // namespace kalfem
