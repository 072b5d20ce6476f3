#include "kalfem/distributed/negative_direction.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace kalfem::distributed {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Lanczos on A^-1, whose spectrum ends at the bottom with the eigenvalue that is looked for. A rough vector will do.
Index largest_entry_of_negative_direction(Index size, const std::function<VectorXd(const VectorXd&)>& inverse) {
  constexpr double tolerance = 1e-2;
  const Index most_steps = std::min<Index>(60, size);
  std::mt19937 random;
  MatrixXd basis(size, most_steps), projected = MatrixXd::Zero(most_steps, most_steps);
  VectorXd next = VectorXd::NullaryExpr(size, [&] { return std::ldexp(random(), -31) - 1.0; }).normalized();
  for (Index step = 0;; ++step) {
    basis.col(step) = next;
    next = inverse(next);
    const auto known = basis.leftCols(step + 1);
    projected.col(step).head(step + 1) = known.transpose() * next;
    projected.row(step) = projected.col(step).transpose();
    for (int pass = 0; pass < 2; ++pass) next -= known * (known.transpose() * next);
    const double coupling = next.norm();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> pairs(projected.topLeftCorner(step + 1, step + 1));
    const double value = pairs.eigenvalues()[0], residual = coupling * std::abs(pairs.eigenvectors()(step, 0));
    if (step + 1 == most_steps || (value < 0.0 && residual < -tolerance * value)) {
      Index largest = 0;
      (known * pairs.eigenvectors().col(0)).cwiseAbs().maxCoeff(&largest);
      return largest;
    }
    next /= coupling;
  }
}

}  // namespace kalfem::distributed
