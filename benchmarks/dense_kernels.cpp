// SPDX-License-Identifier: Apache-2.0
#include "dense_kernels.hpp"

#include "blas_copy.hpp"
#include "kalfem/base/vector_loops.hpp"
#include "kalfem/estimation/kernels/small_kernels.hpp"

namespace kalfem::benchmarks {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using LowerCholesky = Eigen::internal::llt_inplace<double, Eigen::Lower>;

namespace {

constexpr int unblocked_largest = 256;  ///< unblocked or twofold work loses by far beyond

void eigen_blocked(const MatrixXd& in, MatrixXd& out) {
  out = in;
  LowerCholesky::blocked(out);
}

void eigen_unblocked(const MatrixXd& in, MatrixXd& out) {
  out = in;
  LowerCholesky::unblocked(out);
}

void own_cholesky(const MatrixXd& in, MatrixXd& out) { (void)cholesky(in, 0.0, out); }

void eigen_rank_update(const MatrixXd& in, MatrixXd& out) {
  out.setZero();
  out.selfadjointView<Eigen::Lower>().rankUpdate(in);
}

void own_rank_update(const MatrixXd& in, MatrixXd& out) {
  out.setZero();
  add_symmetric_product(in, in, out);
}

void eigen_full_product(const MatrixXd& in, MatrixXd& out) { out.noalias() = in * in.transpose(); }

auto dpotrf(const BlasCopy& blas) {
  return [blas](const MatrixXd& in, MatrixXd& out) {
    out = in;
    const int n = static_cast<int>(out.rows());
    int info = 0;
    blas.dpotrf("L", &n, out.data(), &n, &info);
  };
}

auto dsyrk(const BlasCopy& blas) {
  return [blas](const MatrixXd& in, MatrixXd& out) {
    const int n = static_cast<int>(in.rows()), k = static_cast<int>(in.cols());
    const double one = 1.0, zero = 0.0;
    blas.dsyrk("L", "N", &n, &k, &one, in.data(), &n, &zero, out.data(), &n);
  };
}

/// The routine of the linked BLAS under its name, of further copies with their kernels behind it.
template <class Routine>
void add_blas(std::vector<Kernel>& kernels, const std::string& name, Routine routine) {
  kernels.push_back({name, routine(linked_blas())});
  for (const auto& copy : other_blas_kernels()) kernels.push_back({name + "_" + copy.kernel, routine(copy)});
}

// A factor of one, unknown to the compiler, leaves the buffer as it is.
volatile double one = 1.0;

void scale(VectorXd& buffer) {
  const double factor = one;
  for (Index i = 0; i < buffer.size(); ++i) buffer[i] *= factor;
}

void scale_backwards(VectorXd& buffer) {
  const double factor = one;
  for (Index i = buffer.size(); i-- > 0;) buffer[i] *= factor;
}

/// Four places at once, which some processors fetch faster.
void scale_quarters(VectorXd& buffer) {
  const double factor = one;
  const Index quarter = buffer.size() / 4;
  double *a = buffer.data(), *b = a + quarter, *c = b + quarter, *d = c + quarter;
  KALFEM_INDEPENDENT
  for (Index i = 0; i < quarter; ++i) {
    a[i] *= factor;
    b[i] *= factor;
    c[i] *= factor;
    d[i] *= factor;
  }
  for (Index i = 4 * quarter; i < buffer.size(); ++i) buffer[i] *= factor;
}

}  // namespace

const std::vector<Kernel>& cholesky_kernels() {
  static const std::vector<Kernel> kernels = [] {
    std::vector<Kernel> all = {{"eigen_blocked", eigen_blocked},
                               {"eigen_unblocked", eigen_unblocked, false, unblocked_largest},
                               {"kalfem", own_cholesky, true}};
    add_blas(all, "dpotrf", [](const BlasCopy& blas) { return dpotrf(blas); });
    return all;
  }();
  return kernels;
}

const std::vector<Kernel>& rank_update_kernels() {
  static const std::vector<Kernel> kernels = [] {
    std::vector<Kernel> all = {{"eigen_rank_update", eigen_rank_update},
                               {"eigen_full_product", eigen_full_product, false, unblocked_largest},
                               {"kalfem", own_rank_update, true}};
    add_blas(all, "dsyrk", [](const BlasCopy& blas) { return dsyrk(blas); });
    return all;
  }();
  return kernels;
}

const std::vector<StreamLoop>& stream_loops() {
  static const std::vector<StreamLoop> loops = {
      {"forwards", scale}, {"backwards", scale_backwards}, {"quarters", scale_quarters}};
  return loops;
}

}  // namespace kalfem::benchmarks
