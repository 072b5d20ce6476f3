#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <functional>
#include <vector>

namespace kalfem {

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
