#include "kalfem/formats/matrices/op4.hpp"

#include <cstdlib>

namespace kalfem {

void check_op4(const Op4Header& header, const std::string& source, int line) {
  if (header.type == 3 || header.type == 4)
    refuse_matrix(source, line, "matrix '" + header.name + "' is complex", "the structures here are real",
                  "write stiffness and damping as real matrices");
  if (header.type != 1 && header.type != 2)
    refuse_matrix(source, line, "matrix '" + header.name + "' has type " + std::to_string(header.type),
                  "it is 1 or 2 (real)");
}

MatrixEntries op4_entries(const Op4Header& header, const std::string& source, std::size_t bytes, int line) {
  check_op4(header, source, line);
  if (header.rows == INT64_MIN)
    refuse_matrix(source, line, "the size of a matrix is no number of rows", "the file is damaged");
  return {source, header.name, std::abs(header.rows), header.columns, bytes, line};
}

ForeignMatrix op4_matrix(const Op4Header& header, const MatrixEntries& entries) {
  constexpr std::int64_t diagonal = 3, symmetric = 6, identity = 8;
  ForeignMatrix matrix = entries.finish(header.form == symmetric ? Storage::triangle_or_full : Storage::full);
  if (header.form == diagonal && matrix.matrix.cols() == 1) {
    SparseMatrix spread(matrix.matrix.rows(), matrix.matrix.rows());
    spread.reserve(Eigen::VectorXi::Ones(spread.cols()));
    for (SparseMatrix::InnerIterator it(matrix.matrix, 0); it; ++it) spread.insert(it.row(), it.row()) = it.value();
    spread.makeCompressed();
    matrix.matrix = std::move(spread);
  }
  if (header.form == identity && matrix.matrix.rows() == matrix.matrix.cols()) matrix.matrix.setIdentity();
  matrix.symmetric = header.form == symmetric || header.form == diagonal || header.form == identity;
  return matrix;
}

}  // namespace kalfem
