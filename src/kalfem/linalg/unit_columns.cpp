#include "kalfem/linalg/unit_columns.hpp"

namespace kalfem {

Eigen::MatrixXd unit_columns(const Eigen::MatrixXd& columns) {
  // Lengths are evaluated before the product: as an expression they would be summed up anew for every entry of it.
  const Eigen::RowVectorXd lengths = columns.colwise().norm();
  const Eigen::RowVectorXd factors = (lengths.array() > 0.0).select(lengths.cwiseInverse(), 0.0);
  return columns * factors.asDiagonal();
}

}  // namespace kalfem
