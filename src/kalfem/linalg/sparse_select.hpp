#pragma once

#include <Eigen/Sparse>
#include <vector>

namespace kalfem {

/// The block of a sparse matrix at the given rows and columns, in their order.
Eigen::SparseMatrix<double> select(const Eigen::SparseMatrix<double>& matrix, const std::vector<Eigen::Index>& rows,
                                   const std::vector<Eigen::Index>& columns);

}  // namespace kalfem
