// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/complex_factor.hpp"

#include <array>
#include <new>
#include <string>

#include <umfpack.h>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/blas.hpp"

namespace kalfem {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;

namespace {

const SuiteSparse_long* indices(const std::int64_t* values) {
  return reinterpret_cast<const SuiteSparse_long*>(values);
}

/// UMFPACK takes real and imaginary parts packed, as std::complex stores them, where the second pointer is null.
const double* packed(const Complex* values) { return reinterpret_cast<const double*>(values); }

struct FreeSymbolic {
  void operator()(void* symbolic) const { umfpack_zl_free_symbolic(&symbolic); }
};
struct FreeNumeric {
  void operator()(void* numeric) const { umfpack_zl_free_numeric(&numeric); }
};

void require_memory(SuiteSparse_long status) {
  if (status == UMFPACK_ERROR_out_of_memory) throw std::bad_alloc();
}

}  // namespace

struct ComplexFactor::Workspace {
  std::unique_ptr<void, FreeSymbolic> symbolic;
  std::unique_ptr<void, FreeNumeric> numeric;
  const ComplexSparseMatrix* matrix = nullptr;  ///< that was factored last
  std::array<double, UMFPACK_CONTROL> control{};
};

ComplexFactor::ComplexFactor(const ComplexSparseMatrix& matrix) : workspace_(std::make_unique<Workspace>()) {
  keep_blas_to_one_thread();
  const Index size = matrix.rows();
  if (matrix.cols() != size)
    throw InvalidInput("the matrix is " + std::to_string(size) + " x " + std::to_string(matrix.cols()),
                       "only square matrices can be factored", "");
  auto& control = workspace_->control;
  umfpack_zl_defaults(control.data());
  control[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC;
  control[UMFPACK_ORDERING] = UMFPACK_ORDERING_METIS;
  void* symbolic = nullptr;
  const auto status = umfpack_zl_symbolic(size, size, indices(matrix.outerIndexPtr()), indices(matrix.innerIndexPtr()),
                                          packed(matrix.valuePtr()), nullptr, &symbolic, control.data(), nullptr);
  workspace_->symbolic.reset(symbolic);
  require_memory(status);
}

ComplexFactor::~ComplexFactor() = default;
ComplexFactor::ComplexFactor(ComplexFactor&&) noexcept = default;
ComplexFactor& ComplexFactor::operator=(ComplexFactor&&) noexcept = default;

bool ComplexFactor::factor(const ComplexSparseMatrix& matrix) {
  workspace_->numeric.reset();  // two factors at once would take twice the memory
  workspace_->matrix = &matrix;
  void* numeric = nullptr;
  const auto status =
      umfpack_zl_numeric(indices(matrix.outerIndexPtr()), indices(matrix.innerIndexPtr()), packed(matrix.valuePtr()),
                         nullptr, workspace_->symbolic.get(), &numeric, workspace_->control.data(), nullptr);
  workspace_->numeric.reset(numeric);
  require_memory(status);
  return status == UMFPACK_OK;
}

MatrixXcd ComplexFactor::solve(const MatrixXcd& right_side) const {
  const auto& matrix = *workspace_->matrix;
  MatrixXcd solution(right_side.rows(), right_side.cols());
  for (Index j = 0; j < right_side.cols(); ++j)
    require_memory(umfpack_zl_solve(
        UMFPACK_A, indices(matrix.outerIndexPtr()), indices(matrix.innerIndexPtr()), packed(matrix.valuePtr()), nullptr,
        reinterpret_cast<double*>(solution.col(j).data()), nullptr, packed(right_side.col(j).data()), nullptr,
        workspace_->numeric.get(), workspace_->control.data(), nullptr));
  return solution;
}

}  // namespace kalfem
