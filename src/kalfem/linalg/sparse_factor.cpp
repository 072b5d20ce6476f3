#include "kalfem/linalg/sparse_factor.hpp"

#include <algorithm>
#include <cassert>
#include <new>
#include <string>
#include <vector>

#include <cholmod.h>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/blas.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double zero_pivot = 1e-13;

/// The lower triangle by columns, in CHOLMOD's 64-bit indices (those of L may exceed 32 bits where A's do not).
struct LowerTriangle {
  explicit LowerTriangle(const Eigen::SparseMatrix<double>& matrix, const Eigen::VectorXd& springs = {})
      : size(matrix.rows()), diagonal(matrix.diagonal()) {
    starts.push_back(0);
    rows.reserve(static_cast<std::size_t>(matrix.nonZeros() / 2 + size) + 1);  // never without memory: CHOLMOD
    values.reserve(rows.capacity());                                           // refuses null pointers
    for (Index column = 0; column < size; ++column) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, column); it; ++it)
        if (it.row() >= column) {
          rows.push_back(it.row());
          values.push_back(it.value() + (it.row() == column && springs.size() > 0 ? springs[column] : 0.0));
        }
      starts.push_back(static_cast<SuiteSparse_long>(rows.size()));
    }
    if (springs.size() > 0) diagonal += springs;
  }

  [[nodiscard]] bool same_pattern(const LowerTriangle& other) const {
    return starts == other.starts && rows == other.rows;
  }

  cholmod_sparse view() {
    cholmod_sparse matrix{};
    matrix.nrow = matrix.ncol = static_cast<std::size_t>(size);
    matrix.nzmax = rows.size();
    matrix.p = starts.data();
    matrix.i = rows.data();
    matrix.x = values.data();
    matrix.stype = -1;
    matrix.itype = CHOLMOD_LONG;
    matrix.xtype = CHOLMOD_REAL;
    matrix.dtype = CHOLMOD_DOUBLE;
    matrix.sorted = matrix.packed = 1;
    return matrix;
  }

  Index size;
  Eigen::VectorXd diagonal;
  std::vector<SuiteSparse_long> starts, rows;
  std::vector<double> values;
};

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

// L L^T = P A P^T by CHOLMOD [CDHR08], in two phases that are kept apart:
//   1. analysis: the fill-reducing order P, the pattern of L and the choice of supernodes, from the pattern of A alone;
//   2. factorisation: the values of L. refactor() repeats this phase for another matrix of the same pattern.
// CHOLMOD is given views of our arrays and allocates only L. After the factorisation the squared pivots l_jj^2 are
// compared with the diagonal of A: a quotient near rounding means that the matrix is singular for our purposes, even
// where CHOLMOD went through. Failures are read from its status, never from its messages.
NotPositiveDefinite::NotPositiveDefinite(Index column)
    : std::runtime_error("the matrix is not positive definite: zero or negative pivot in column " +
                         std::to_string(column)),
      column_(column) {}

struct SparseFactor::Workspace {
  Workspace(LowerTriangle given, const EliminationOrder& order) : matrix(std::move(given)) {
    keep_blas_to_one_thread();
    cholmod_l_start(&common);
    common.print = 0;
    common.try_catch = 1;  // failures are read from the status
    common.error_handler = nullptr;
    common.final_ll = 1;  // also where it is not supernodal: L D L^T would not notice a negative pivot
    cholmod_sparse view = matrix.view();
    if (order.empty()) {
      factor = cholmod_l_analyze(&view, &common);
    } else {
      common.nmethods = 1;
      common.method[0].ordering = CHOLMOD_GIVEN;
      std::vector<SuiteSparse_long> given_order(order.begin(), order.end());
      factor = cholmod_l_analyze_p(&view, given_order.data(), nullptr, 0, &common);
    }
    if (factor == nullptr) fail();
  }

  ~Workspace() {
    for (Temporaries* temporaries : {&single, &block}) {
      cholmod_l_free_dense(&temporaries->y, &common);
      cholmod_l_free_dense(&temporaries->e, &common);
    }
    cholmod_l_free_factor(&factor, &common);
    cholmod_l_finish(&common);
  }

  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  void factorize() {
    cholmod_sparse view = matrix.view();
    cholmod_l_factorize(&view, factor, &common);
    if (common.status == CHOLMOD_NOT_POSDEF) throw NotPositiveDefinite(given_column(factor->minor));
    if (common.status < CHOLMOD_OK) fail();
    matrix.values = {};  // only the pattern is needed from here on
    check_pivots();
  }

  /// l_jj^2 / a_jj is what elimination left of the diagonal entry: the sine of the angle to the columns before,
  /// squared.
  void check_pivots() {
    smallest_pivot = 1.0;
    visit_diagonal(*factor, [&](std::size_t j, double entry) {
      const Index column = given_column(j);
      const double pivot = entry * entry / matrix.diagonal[column];
      if (!(pivot > zero_pivot)) throw NotPositiveDefinite(column);
      smallest_pivot = std::min(smallest_pivot, pivot);
    });
  }

  [[nodiscard]] Index given_column(std::size_t j) const {
    return static_cast<Index>(static_cast<const SuiteSparse_long*>(factor->Perm)[j]);
  }

  /// Solves with temporaries that are kept for one and for many right-hand sides, so that repeated solves allocate
  /// nothing.
  void solve(cholmod_dense right_side, cholmod_dense solution) {
    cholmod_dense* written = &solution;
    Temporaries& temporaries = solution.ncol == 1 ? single : block;
    cholmod_l_solve2(CHOLMOD_A, factor, &right_side, nullptr, &written, nullptr, &temporaries.y, &temporaries.e,
                     &common);
    if (common.status < CHOLMOD_OK) fail();
    if (factor->is_super) return;
    // The simplicial solve leaves y in the shape of its last columns, and would take it for too little next time.
    temporaries.y->nrow = temporaries.y->d = temporaries.y->nzmax / solution.nrow;
    temporaries.y->ncol = solution.nrow;
  }

  [[noreturn]] void fail() const {
    if (common.status == CHOLMOD_OUT_OF_MEMORY || common.status == CHOLMOD_TOO_LARGE) throw std::bad_alloc();
    throw std::logic_error("CHOLMOD refused its arguments, status " + std::to_string(common.status));
  }

  /// What solve2 keeps between calls; it allocates anew when the number of right-hand sides changes.
  struct Temporaries {
    cholmod_dense* y = nullptr;
    cholmod_dense* e = nullptr;
  };

  LowerTriangle matrix;
  cholmod_common common{};
  cholmod_factor* factor = nullptr;
  Temporaries single, block;
  double smallest_pivot = 1.0;
};

SparseFactor::SparseFactor(const Eigen::SparseMatrix<double>& matrix, const EliminationOrder& order,
                           const Eigen::VectorXd& springs) {
  if (matrix.rows() != matrix.cols())
    throw InvalidInput("a " + std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()) + " matrix",
                       "only a square matrix has a Cholesky factor", "pass a symmetric matrix");
  if (!order.empty() && static_cast<Index>(order.size()) != matrix.rows())
    throw InvalidInput(
        "an order of " + std::to_string(order.size()) + " rows for a matrix of " + std::to_string(matrix.rows()),
        "it must contain each row once", "pass the order of a factor of the same size");
  workspace_ = std::make_unique<Workspace>(LowerTriangle(matrix, springs), order);
  workspace_->factorize();
}

SparseFactor::~SparseFactor() = default;
SparseFactor::SparseFactor(SparseFactor&&) noexcept = default;
SparseFactor& SparseFactor::operator=(SparseFactor&&) noexcept = default;

void SparseFactor::refactor(const Eigen::SparseMatrix<double>& matrix) {
  LowerTriangle given(matrix);
  if (given.size != size() || !given.same_pattern(workspace_->matrix))
    throw InvalidInput("the matrix has a different pattern from the one analysed", "its factor has a different size",
                       "make a new SparseFactor or keep explicit zeros");
  workspace_->matrix = std::move(given);
  workspace_->factorize();
}

void SparseFactor::solve(const Eigen::Ref<const MatrixXd>& right_side, Eigen::Ref<MatrixXd> solution) const {
  const Index n = size(), columns = right_side.cols();
  assert(right_side.rows() == n && solution.rows() == n && solution.cols() == columns);
  if (right_side.size() == 0) return;
  // Into a block of a larger matrix CHOLMOD cannot write more than a column.
  const Index width = solution.outerStride() == n ? columns : 1;
  for (Index j = 0; j < columns; j += width)
    workspace_->solve(dense_view(right_side.col(j).data(), n, width, right_side.outerStride()),
                      dense_view(solution.col(j).data(), n, width, n));
}

MatrixXd SparseFactor::solve(const Eigen::Ref<const MatrixXd>& right_side) const {
  MatrixXd solution(right_side.rows(), right_side.cols());
  solve(right_side, solution);
  return solution;
}

Index SparseFactor::size() const { return workspace_->matrix.size; }

EliminationOrder SparseFactor::order() const {
  const auto* order = static_cast<const SuiteSparse_long*>(workspace_->factor->Perm);
  return {order, order + size()};
}

double SparseFactor::nonzeros() const {
  const cholmod_factor& factor = *workspace_->factor;
  return static_cast<double>(factor.is_super ? factor.xsize : factor.nzmax);
}

double SparseFactor::bytes() const {
  const cholmod_factor& factor = *workspace_->factor;
  const auto indices = factor.is_super ? factor.ssize + 3 * factor.nsuper : factor.nzmax + 4 * factor.n;
  return 8.0 * (nonzeros() + static_cast<double>(indices + 2 * factor.n));
}

double SparseFactor::smallest_pivot() const { return workspace_->smallest_pivot; }

using Eigen::VectorXd;
using Matrix = Eigen::SparseMatrix<double>;

MatrixXd semidefinite_solve(const Matrix& matrix, const MatrixXd& right_side) {
  constexpr double relative_shift = 1e-12, tolerance = 1e-11;
  constexpr int most_refinements = 50;
  const VectorXd diagonal = matrix.diagonal();
  const double elsewhere = diagonal.maxCoeff() > 0.0 ? diagonal.maxCoeff() : 1.0;
  Matrix shifted = matrix;
  Matrix shift(diagonal.size(), diagonal.size());
  shift.reserve(Eigen::VectorXi::Ones(diagonal.size()));
  for (Index i = 0; i < diagonal.size(); ++i)
    shift.insert(i, i) = diagonal[i] > 0.0 ? relative_shift * diagonal[i] : elsewhere;
  shifted += shift;
  const SparseFactor factor(shifted);
  MatrixXd solution = factor.solve(right_side);
  for (int i = 0; i < most_refinements; ++i) {
    const MatrixXd correction = factor.solve(right_side - matrix * solution);
    solution += correction;
    if (correction.norm() <= tolerance * solution.norm()) break;
  }
  return solution;
}

}  // namespace kalfem
