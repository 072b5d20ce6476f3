// SPDX-License-Identifier: Apache-2.0
#include "kalfem/distributed/weakest_direction.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace kalfem::distributed {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Lanczos on A^-1: the eigenvalue that is looked for ends its spectrum, at the bottom where it is negative, otherwise
// at the top. A rough vector will do.
Index weakest_entry(Index size, bool negative, const std::function<VectorXd(const VectorXd&)>& inverse) {
  constexpr double tolerance = 1e-2;
  const Index most_steps = std::min<Index>(40, size);
  std::mt19937 random;
  MatrixXd basis(size, most_steps), projected = MatrixXd::Zero(most_steps, most_steps);
  VectorXd next = VectorXd::NullaryExpr(size, [&] { return std::ldexp(random(), -31) - 1.0; }).normalized();
  for (Index step = 0;; ++step) {
    const Index count = step + 1;
    basis.col(step) = next;
    const auto known = basis.leftCols(count);
    next = inverse(next);
    projected.col(step).head(count) = known.transpose() * next;
    projected.row(step).head(count) = projected.col(step).head(count).transpose();
    for (int pass = 0; pass < 2; ++pass) next -= known * (known.transpose() * next);
    const double coupling = next.norm();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> pairs(projected.topLeftCorner(count, count));
    const Index wanted = negative ? 0 : step;
    const double value = pairs.eigenvalues()[wanted] * (negative ? -1.0 : 1.0);
    if (count == most_steps || coupling * std::abs(pairs.eigenvectors()(step, wanted)) <= tolerance * value) {
      Index largest = 0;
      (known * pairs.eigenvectors().col(wanted)).cwiseAbs().maxCoeff(&largest);
      return largest;
    }
    next /= coupling;
  }
}

}  // namespace kalfem::distributed
