#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <vector>

namespace kalfem {

/// y = A u + B v of two sparse matrices in one sweep over their common pattern: both are read once, side by side.
/// Where B has no entries its vector is not read.
class PairedProduct {
public:
  PairedProduct(const Eigen::SparseMatrix<double>& a, const Eigen::SparseMatrix<double>& b);

  /// y is resized at the first use.
  void multiply(const Eigen::VectorXd& u, const Eigen::VectorXd& v, Eigen::VectorXd& y) const;
  [[nodiscard]] bool single() const { return b_.empty(); }

private:
  Eigen::Index rows_ = 0;
  std::vector<int> start_, column_;
  std::vector<double> a_, b_;
};

}  // namespace kalfem
