#include "dense_kernels.hpp"

#include "kalfem/estimation/small_kernels.hpp"

// OpenBLAS declares these in headers that other BLAS libraries do not have; weak, so that any BLAS links.
extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha, const double* a,
            const int* lda, const double* beta, double* c, const int* ldc);
[[gnu::weak]] char* openblas_get_corename();
[[gnu::weak]] char* openblas_get_config();
[[gnu::weak]] void openblas_set_num_threads(int threads);
}

namespace kalfem::benchmarks {

using Eigen::MatrixXd;
using LowerCholesky = Eigen::internal::llt_inplace<double, Eigen::Lower>;

namespace {

void eigen_blocked(const MatrixXd& in, MatrixXd& out) {
  out = in;
  LowerCholesky::blocked(out);
}

void eigen_unblocked(const MatrixXd& in, MatrixXd& out) {
  out = in;
  LowerCholesky::unblocked(out);
}

void dpotrf(const MatrixXd& in, MatrixXd& out) {
  out = in;
  const int n = static_cast<int>(out.rows());
  int info = 0;
  dpotrf_("L", &n, out.data(), &n, &info);
}

void own_cholesky(const MatrixXd& in, MatrixXd& out) { (void)cholesky(in, 0.0, out); }

void eigen_rank_update(const MatrixXd& in, MatrixXd& out) {
  out.setZero();
  out.selfadjointView<Eigen::Lower>().rankUpdate(in);
}

void dsyrk(const MatrixXd& in, MatrixXd& out) {
  const int n = static_cast<int>(in.rows()), k = static_cast<int>(in.cols());
  const double one = 1.0, zero = 0.0;
  dsyrk_("L", "N", &n, &k, &one, in.data(), &n, &zero, out.data(), &n);
}

void own_rank_update(const MatrixXd& in, MatrixXd& out) {
  out.setZero();
  add_symmetric_product(in, in, out);
}

void eigen_full_product(const MatrixXd& in, MatrixXd& out) { out.noalias() = in * in.transpose(); }

}  // namespace

const std::vector<Kernel>& cholesky_kernels() {
  static const std::vector<Kernel> kernels = {{"eigen_blocked", eigen_blocked},
                                              {"eigen_unblocked", eigen_unblocked},
                                              {"dpotrf", dpotrf},
                                              {"kalfem", own_cholesky, true}};
  return kernels;
}

const std::vector<Kernel>& rank_update_kernels() {
  static const std::vector<Kernel> kernels = {{"eigen_rank_update", eigen_rank_update},
                                              {"dsyrk", dsyrk},
                                              {"eigen_full_product", eigen_full_product},
                                              {"kalfem", own_rank_update, true}};
  return kernels;
}

std::string blas_name() { return openblas_get_config ? openblas_get_config() : "not OpenBLAS"; }
std::string blas_kernel() { return openblas_get_corename ? openblas_get_corename() : "unknown"; }
void use_one_blas_thread() {
  if (openblas_set_num_threads) openblas_set_num_threads(1);
}

}  // namespace kalfem::benchmarks
