#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

namespace kalfem::benchmarks {

/// One implementation of a dense kernel, `run` repeats it on the same input.
struct Kernel {
  std::string name;
  void (*run)(const Eigen::MatrixXd& in, Eigen::MatrixXd& out);
  bool own = false;  ///< kalfem's, not a public library's
};

/// Lower Cholesky factor of an n x n matrix.
const std::vector<Kernel>& cholesky_kernels();
/// Lower triangle of X X^T, X of n x (2n + 1).
const std::vector<Kernel>& rank_update_kernels();

/// Name of the BLAS with its version, and of the processor kernel that it chose.
std::string blas_name();
std::string blas_kernel();
void use_one_blas_thread();

}  // namespace kalfem::benchmarks
