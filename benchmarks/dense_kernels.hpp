// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace kalfem::benchmarks {

/// One implementation of a dense kernel, `run` repeats it on the same input.
struct Kernel {
  std::string name;
  std::function<void(const Eigen::MatrixXd& in, Eigen::MatrixXd& out)> run;
  bool own = false;                               ///< kalfem's, not a public library's
  int largest = std::numeric_limits<int>::max();  ///< size above which it cannot be the fastest
};

/// Lower Cholesky factor of an n x n matrix.
const std::vector<Kernel>& cholesky_kernels();
/// Lower triangle of X X^T, X of n x (2n + 1).
const std::vector<Kernel>& rank_update_kernels();

/// A plain loop that reads and writes every number of a buffer once.
struct StreamLoop {
  std::string name;
  void (*run)(Eigen::VectorXd& buffer);
};
const std::vector<StreamLoop>& stream_loops();

}  // namespace kalfem::benchmarks
