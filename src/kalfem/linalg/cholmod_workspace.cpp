// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/cholmod_workspace.hpp"

#include <algorithm>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "kalfem/linalg/blas.hpp"
#include "kalfem/linalg/tall_matrices.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

cholmod_sparse sparse_view(const UpperTriangle& matrix) {
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(matrix.size);
  view.nzmax = matrix.rows.size();
  view.p = const_cast<std::int64_t*>(matrix.starts.data());
  view.i = const_cast<std::int64_t*>(matrix.rows.data());
  view.x = const_cast<double*>(matrix.values.data());
  view.stype = 1;
  view.itype = CHOLMOD_LONG;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = view.packed = 1;
  return view;
}

cholmod_dense dense_view(const double* data, Index rows, Index columns, Index stride) {
  cholmod_dense view{};
  view.nrow = static_cast<std::size_t>(rows);
  view.ncol = static_cast<std::size_t>(columns);
  view.d = static_cast<std::size_t>(columns == 1 ? rows : stride);
  view.nzmax = view.d * view.ncol;
  view.x = const_cast<double*>(data);
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  return view;
}

/// Calls visit(j, L_jj) for every column of the factor, in its own order.
template <typename Visitor>
void visit_diagonal(const cholmod_factor& factor, Visitor visit) {
  const auto* x = static_cast<const double*>(factor.x);
  if (!factor.is_super) {
    const auto* starts = static_cast<const SuiteSparse_long*>(factor.p);
    for (std::size_t j = 0; j < factor.n; ++j) visit(j, x[starts[j]]);
    return;
  }
  const auto* columns = static_cast<const SuiteSparse_long*>(factor.super);
  const auto* row_starts = static_cast<const SuiteSparse_long*>(factor.pi);
  const auto* value_starts = static_cast<const SuiteSparse_long*>(factor.px);
  for (std::size_t s = 0; s < factor.nsuper; ++s) {
    const SuiteSparse_long height = row_starts[s + 1] - row_starts[s];
    for (SuiteSparse_long k = 0; k < columns[s + 1] - columns[s]; ++k)
      visit(static_cast<std::size_t>(columns[s] + k), x[value_starts[s] + k * (height + 1)]);
  }
}

}  // namespace

// In two phases that are kept apart:
//   1. analysis: the fill-reducing order P, the pattern of L and the choice of supernodes, from the pattern of A alone;
//   2. factorisation: the values of L, for any matrix of that pattern.
// CHOLMOD is given views of our arrays and allocates only L. After the factorisation the squared pivots l_jj^2 are
// compared with the diagonal of A: a quotient near rounding means that the matrix is singular for our purposes, even
// where CHOLMOD went through. Failures are read from its status, never from its messages.
CholmodWorkspace::CholmodWorkspace(const UpperTriangle& pattern, const EliminationOrder& order) {
  keep_blas_to_one_thread();
  cholmod_l_start(&common_);
  common_.print = 0;
  common_.try_catch = 1;  // failures are read from the status
  common_.error_handler = nullptr;
  common_.final_ll = 1;  // also where it is not supernodal: L D L^T would not notice a negative pivot
  cholmod_sparse view = sparse_view(pattern);
  if (order.empty()) {
    factor_ = cholmod_l_analyze(&view, &common_);
  } else {
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_GIVEN;
    std::vector<SuiteSparse_long> given_order(order.begin(), order.end());
    factor_ = cholmod_l_analyze_p(&view, given_order.data(), nullptr, 0, &common_);
  }
  if (factor_ == nullptr) fail();
}

CholmodWorkspace::~CholmodWorkspace() {
  for (Temporaries* temporaries : {&single_, &block_}) {
    cholmod_l_free_dense(&temporaries->y, &common_);
    cholmod_l_free_dense(&temporaries->e, &common_);
  }
  cholmod_l_free_factor(&factor_, &common_);
  cholmod_l_finish(&common_);
}

void CholmodWorkspace::factorize(const UpperTriangle& matrix) {
  cholmod_sparse view = sparse_view(matrix);
  {
    const OneOpenMpThread alone;  // its own four only wait for each other
    cholmod_l_factorize(&view, factor_, &common_);
  }
  if (common_.status == CHOLMOD_NOT_POSDEF) throw NotPositiveDefinite(given_column(factor_->minor));
  if (common_.status < CHOLMOD_OK) fail();
  check_pivots(matrix);
}

/// l_jj^2 / a_jj is what elimination left of the diagonal entry: the sine of the angle to the columns before, squared.
void CholmodWorkspace::check_pivots(const UpperTriangle& matrix) {
  smallest_pivot_ = 1.0;
  visit_diagonal(*factor_, [&](std::size_t j, double entry) {
    const Index column = given_column(j);
    const double pivot = entry * entry / matrix.diagonal[column];
    if (!(pivot > zero_pivot)) throw NotPositiveDefinite(column);
    smallest_pivot_ = std::min(smallest_pivot_, pivot);
  });
}

Index CholmodWorkspace::given_column(std::size_t j) const {
  return static_cast<Index>(static_cast<const SuiteSparse_long*>(factor_->Perm)[j]);
}

void CholmodWorkspace::solve(const Eigen::Ref<const MatrixXd>& right_side, Eigen::Ref<MatrixXd> solution) {
  const Index n = right_side.rows(), columns = right_side.cols();
  // Into a block of a larger matrix CHOLMOD cannot write more than a column.
  by_panels(columns, solution.outerStride() == n ? widest_panel : 1, [&](Index j, Index count) {
    solve_whole(dense_view(right_side.col(j).data(), n, count, right_side.outerStride()),
                dense_view(solution.col(j).data(), n, count, n));
  });
}

/// Solves with temporaries that are kept for one and for many right-hand sides, so that repeated solves allocate
/// nothing.
void CholmodWorkspace::solve_whole(cholmod_dense right_side, cholmod_dense solution) {
  cholmod_dense* written = &solution;
  Temporaries& temporaries = solution.ncol == 1 ? single_ : block_;
  cholmod_l_solve2(CHOLMOD_A, factor_, &right_side, nullptr, &written, nullptr, &temporaries.y, &temporaries.e,
                   &common_);
  if (common_.status < CHOLMOD_OK) fail();
  if (factor_->is_super) return;
  // The simplicial solve leaves y in the shape of its last columns, and would take it for too little next time.
  temporaries.y->nrow = temporaries.y->d = temporaries.y->nzmax / solution.nrow;
  temporaries.y->ncol = solution.nrow;
}

void CholmodWorkspace::fail() const {
  if (common_.status == CHOLMOD_OUT_OF_MEMORY || common_.status == CHOLMOD_TOO_LARGE) throw std::bad_alloc();
  throw std::logic_error("CHOLMOD refused its arguments, status " + std::to_string(common_.status));
}

EliminationOrder CholmodWorkspace::order() const {
  const auto* order = static_cast<const SuiteSparse_long*>(factor_->Perm);
  return {order, order + factor_->n};
}

double CholmodWorkspace::nonzeros() const {
  return static_cast<double>(factor_->is_super ? factor_->xsize : factor_->nzmax);
}

double CholmodWorkspace::bytes() const {
  const auto indices = factor_->is_super ? factor_->ssize + 3 * factor_->nsuper : factor_->nzmax + 4 * factor_->n;
  return 8.0 * (nonzeros() + static_cast<double>(indices + 2 * factor_->n));
}

std::optional<SinglePrecisionFactor> CholmodWorkspace::in_single_precision() const {
  if (!factor_->is_super) return {};
  const auto numbers = [](const void* data, std::size_t count) {
    const auto* begin = static_cast<const SuiteSparse_long*>(data);
    return std::vector<std::int64_t>(begin, begin + count);
  };
  return SinglePrecisionFactor({.columns = numbers(factor_->super, factor_->nsuper + 1),
                                .row_starts = numbers(factor_->pi, factor_->nsuper + 1),
                                .value_starts = numbers(factor_->px, factor_->nsuper + 1),
                                .rows = numbers(factor_->s, factor_->ssize),
                                .order = numbers(factor_->Perm, factor_->n)},
                               {static_cast<const double*>(factor_->x), factor_->xsize});
}

}  // namespace kalfem
