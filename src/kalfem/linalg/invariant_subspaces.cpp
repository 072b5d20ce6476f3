#include "kalfem/linalg/block_diagonal_form.hpp"

#include <algorithm>
#include <complex>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/blas.hpp"
#include "kalfem/linalg/scaling.hpp"

extern "C" {
void dgees_(const char* jobvs, const char* sort, void* select, const int* n, double* a, const int* lda, int* sdim,
            double* wr, double* wi, double* vs, const int* ldvs, double* work, const int* lwork, int* bwork, int* info);
void dtrexc_(const char* compq, const int* n, double* t, const int* ldt, double* q, const int* ldq, int* ifst,
             int* ilst, double* work, int* info);
void dtrsyl_(const char* trana, const char* tranb, const int* isgn, const int* m, const int* n, const double* a,
             const int* lda, const double* b, const int* ldb, double* c, const int* ldc, double* scale, int* info);
}

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// After balancing: real Schur form, then from the top a block [BS79] at a time. Decouple the block from the rest by a
// Sylvester equation. Where its solution is too large the basis would be ill conditioned: exchange the nearest
// eigenvalue of the rest to directly behind the block, take it in and try again.
/// A = U S U^T, S quasi upper triangular, made block diagonal from the top.
class SchurSplit {
public:
  SchurSplit(const MatrixXd& A, double magnification)
      : n_(static_cast<int>(A.rows())), magnification_(magnification), s_(A), u_(A.rows(), A.rows()) {
    VectorXd real(n_), imaginary(n_), work(1);
    keep_blas_to_one_thread();
    int selected = 0, query = -1, info = 0;
    dgees_("V", "N", nullptr, &n_, s_.data(), &n_, &selected, real.data(), imaginary.data(), u_.data(), &n_,
           work.data(), &query, nullptr, &info);
    int size = static_cast<int>(work[0]);
    work.resize(size);
    dgees_("V", "N", nullptr, &n_, s_.data(), &n_, &selected, real.data(), imaginary.data(), u_.data(), &n_,
           work.data(), &size, nullptr, &info);
    if (info != 0)
      throw InvalidInput("the eigenvalues of a matrix of " + std::to_string(n_) + " states did not converge",
                         "its entries must be finite and reasonably scaled", "check the model's masses and dampers");
  }

  InvariantSubspaces run() {
    InvariantSubspaces result{{}, MatrixXd::Zero(n_, n_), {}};
    for (Index begin = 0, size = 0; begin < n_; begin += size) {
      size = width_at(begin);
      while (!decouple(begin, size)) size += bring_nearest(begin, size);
      result.starts.push_back(begin);
      result.blocks.block(begin, begin, size, size) = s_.block(begin, begin, size, size);
    }
    result.starts.push_back(n_);
    result.basis = std::move(u_);
    return result;
  }

private:
  [[nodiscard]] Index width_at(Index i) const { return i + 1 < n_ && s_(i + 1, i) != 0.0 ? 2 : 1; }

  [[nodiscard]] std::complex<double> eigenvalue_at(Index i) const {
    if (width_at(i) == 1) return s_(i, i);
    const double mean = 0.5 * (s_(i, i) + s_(i + 1, i + 1)), half = 0.5 * (s_(i, i) - s_(i + 1, i + 1));
    return {mean, std::sqrt(std::max(0.0, -half * half - s_(i, i + 1) * s_(i + 1, i)))};
  }

  /// X with S_11 X - X S_22 = -S_12; the basis of the rest then has no part in the block. False where X is too large.
  bool decouple(Index begin, Index size) {
    const Index rest = n_ - begin - size;
    if (rest == 0) return true;
    MatrixXd x = -s_.block(begin, begin + size, size, rest);
    const int rows = static_cast<int>(size), columns = static_cast<int>(rest), sign = -1;
    double scale = 1.0;
    int info = 0;
    dtrsyl_("N", "N", &sign, &rows, &columns, &s_(begin, begin), &n_, &s_(begin + size, begin + size), &n_, x.data(),
            &rows, &scale, &info);
    if (!(scale > 0.0) || !(x.cwiseAbs().maxCoeff() <= magnification_ * scale)) return false;
    u_.rightCols(rest) += u_.middleCols(begin, size) * (x / scale);
    s_.block(begin, begin + size, size, rest).setZero();
    return true;
  }

  /// Moves the eigenvalue of the rest that is nearest to the block's directly behind it; its width.
  Index bring_nearest(Index begin, Index size) {
    Index nearest = begin + size;
    double distance = std::numeric_limits<double>::infinity();
    for (Index i = begin + size; i < n_; i += width_at(i))
      for (Index k = begin; k < begin + size; k += width_at(k))
        if (const double away = std::abs(eigenvalue_at(i) - eigenvalue_at(k)); away < distance)
          distance = away, nearest = i;
    const Index width = width_at(nearest);
    int from = static_cast<int>(nearest) + 1, to = static_cast<int>(begin + size) + 1, info = 0;
    VectorXd work(n_);
    // Columns of earlier blocks are decoupled from these rows, so the exchange leaves them alone.
    dtrexc_("V", &n_, s_.data(), &n_, u_.data(), &n_, &from, &to, work.data(), &info);
    return width;
  }

  int n_;
  double magnification_;
  MatrixXd s_, u_;
};

}  // namespace

InvariantSubspaces invariant_subspaces(const MatrixXd& A, double magnification) {
  if (!A.allFinite()) throw InvalidInput("a matrix of dynamics is not finite", "all its entries must be finite", "");
  const VectorXd scale = balancing_scale(A);
  const VectorXd inverse = scale.cwiseInverse();
  InvariantSubspaces result = SchurSplit(inverse.asDiagonal() * A * scale.asDiagonal(), magnification).run();
  result.basis = scale.asDiagonal() * result.basis;
  return result;
}

}  // namespace kalfem
