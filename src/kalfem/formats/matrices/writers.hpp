#pragma once

// The writers of the single formats; inside of write.cpp only. Each gives the bytes of the whole file.

#include <string>
#include <vector>

#include "kalfem/formats/matrices.hpp"

namespace kalfem {

std::string matrix_market_text(const ForeignMatrix& matrix);
std::string dmig_text(const std::vector<ForeignMatrix>& matrices);
std::string op4_text(const std::vector<ForeignMatrix>& matrices);
std::string op4_bytes(const std::vector<ForeignMatrix>& matrices, bool big_endian);
std::string hdf5_bytes(const std::vector<ForeignMatrix>& matrices, const Eigen::MatrixXd& basis,
                       const std::vector<std::string>& names);

/// Whether A and A^T are equal to the last bit.
bool is_symmetric(const SparseMatrix& matrix);

}  // namespace kalfem
