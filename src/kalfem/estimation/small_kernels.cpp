#include "kalfem/estimation/small_kernels.hpp"

#include <cmath>
#include <cstring>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// `Height` consecutive entries of a column; one or two vector registers on the machines of today.
template <int Height>
struct Lane {
  typedef double type __attribute__((vector_size(Height * sizeof(double))));
};
template <>
struct Lane<1> {
  using type = double;
};

template <int Height>
inline typename Lane<Height>::type load(const double* from) {
  typename Lane<Height>::type value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

/// A matrix read with any strides: a transposed one has them exchanged.
struct Strided {
  const double* data;
  Index row, column;
  [[nodiscard]] Strided from(Index i, Index j) const { return {data + i * row + j * column, row, column}; }
};

Strided plain(const MatrixXd& matrix) { return {matrix.data(), 1, matrix.rows()}; }
Strided transposed(const MatrixXd& matrix) { return {matrix.data(), matrix.rows(), 1}; }

/// sum = A B of one tile, Height x Width.
template <int Height, int Width>
inline void product_of_tile(Index depth, const double* a, Index a_stride, Strided b,
                            typename Lane<Height>::type (&sum)[Width]) {
  for (int j = 0; j < Width; ++j) sum[j] = typename Lane<Height>::type{};
  for (Index k = 0; k < depth; ++k) {
    const auto column = load<Height>(a + k * a_stride);
    for (int j = 0; j < Width; ++j) sum[j] += column * b.data[k * b.row + j * b.column];
  }
}

/// C += sign A B of one tile.
template <int Height, int Width>
inline void add_tile(Index depth, const double* a, Index a_stride, Strided b, double sign, double* c, Index c_stride) {
  typename Lane<Height>::type sum[Width];
  product_of_tile<Height, Width>(depth, a, a_stride, b, sum);
  for (int j = 0; j < Width; ++j) {
    const auto value = load<Height>(c + j * c_stride) + sign * sum[j];
    std::memcpy(c + j * c_stride, &value, sizeof value);
  }
}

/// C += sign A B for `Width` columns and the rows from `row` on.
template <int Width>
void add_panel(Index row, Index rows, Index depth, const double* a, Strided b, double sign, double* c) {
  for (; rows - row >= 8; row += 8) add_tile<8, Width>(depth, a + row, rows, b, sign, c + row, rows);
  if (rows - row >= 4) {
    add_tile<4, Width>(depth, a + row, rows, b, sign, c + row, rows);
    row += 4;
  }
  for (; row < rows; ++row) add_tile<1, Width>(depth, a + row, rows, b, sign, c + row, rows);
}

/// C += sign A B, rows x columns; only tiles that reach the lower triangle where `lower` says so.
void add_product(Index rows, Index columns, Index depth, const double* a, Strided b, double sign, bool lower,
                 double* c) {
  const auto first_row = [lower](Index column) { return lower ? column - column % 8 : 0; };
  Index j = 0;
  for (; columns - j >= 6; j += 6) add_panel<6>(first_row(j), rows, depth, a, b.from(0, j), sign, c + j * rows);
  if (columns - j >= 4) {
    add_panel<4>(first_row(j), rows, depth, a, b.from(0, j), sign, c + j * rows);
    j += 4;
  }
  for (; j < columns; ++j) add_panel<1>(first_row(j), rows, depth, a, b.from(0, j), sign, c + j * rows);
}

/// Columns of a panel behind its diagonal block L_J: X <- (C - A B) L_J^-T, one tile of rows at a time.
template <int Height, int Width>
inline void solve_tile(Index depth, const double* a, Index stride, Strided b, const double* block,
                       const double* inverse, double* c) {
  typename Lane<Height>::type x[Width];
  product_of_tile<Height, Width>(depth, a, stride, b, x);
  for (int j = 0; j < Width; ++j) {
    x[j] = load<Height>(c + j * stride) - x[j];
    for (int k = 0; k < j; ++k) x[j] -= x[k] * block[j + k * stride];
    x[j] *= inverse[j];
    std::memcpy(c + j * stride, &x[j], sizeof x[j]);
  }
}

/// Factor of the diagonal block in place and the inverses of its diagonal.
template <int Width>
inline bool factor_block(double* block, Index stride, const double* floor, double* inverse) {
  for (int j = 0; j < Width; ++j) {
    double pivot = block[j + j * stride];
    for (int k = 0; k < j; ++k) pivot -= block[j + k * stride] * block[j + k * stride];
    if (!(pivot > floor[j])) return false;
    const double root = std::sqrt(pivot);
    block[j + j * stride] = root;
    inverse[j] = 1.0 / root;
    for (int i = j + 1; i < Width; ++i) {
      double value = block[i + j * stride];
      for (int k = 0; k < j; ++k) value -= block[i + k * stride] * block[j + k * stride];
      block[i + j * stride] = value * inverse[j];
    }
  }
  return true;
}

/// Columns j ... j + Width - 1 of L from those before (left-looking).
template <int Width>
bool factor_panel(Index j, Index n, double pivot_floor, double* l) {
  double* block = l + j + j * n;
  const Strided before{l + j, n, 1};  // L_J^T
  double floor[Width], inverse[Width];
  for (int i = 0; i < Width; ++i) floor[i] = pivot_floor * block[i + i * n];
  add_tile<Width, Width>(j, l + j, n, before, -1.0, block, n);
  if (!factor_block<Width>(block, n, floor, inverse)) return false;
  Index row = j + Width;
  const auto solve = [&]<int Height>() {
    solve_tile<Height, Width>(j, l + row, n, before, block, inverse, l + row + j * n);
    row += Height;
  };
  while (n - row >= 8) solve.template operator()<8>();
  if (n - row >= 4) solve.template operator()<4>();
  while (row < n) solve.template operator()<1>();
  return true;
}

bool small(const MatrixXd& a, Index depth) { return std::max({a.rows(), a.cols(), depth}) <= small_dimension; }

}  // namespace

void multiply(const MatrixXd& a, const MatrixXd& b, bool b_is_lower, MatrixXd& out) {
  const Index depth = b.rows(), columns = b.cols(), panel = small(b, a.rows()) ? 6 : 48;
  out.resize(a.rows(), columns);
  for (Index j = 0; j < columns; j += panel) {
    const Index width = std::min(panel, columns - j), first = b_is_lower ? j : 0, left = depth - first;
    if (panel > 6) {
      out.middleCols(j, width).noalias() = a.rightCols(left) * b.block(first, j, left, width);
    } else {
      out.middleCols(j, width).setZero();
      add_product(a.rows(), width, left, a.data() + first * a.rows(), plain(b).from(first, j), 1.0, false,
                  out.data() + j * a.rows());
    }
  }
}

bool is_lower(const MatrixXd& matrix) {
  for (Index j = 1; j < matrix.cols(); ++j)
    if (!(matrix.col(j).head(std::min(j, matrix.rows())).array().abs().sum() == 0.0)) return false;
  return true;
}

void multiply_transposed(const MatrixXd& a, const MatrixXd& b, MatrixXd& out) {
  out.setZero(a.rows(), b.rows());
  add_product_transposed(a, b, out);
}

void add_product_transposed(const MatrixXd& a, const MatrixXd& b, MatrixXd& out) {
  if (small(out, a.cols()))
    add_product(out.rows(), out.cols(), a.cols(), a.data(), transposed(b), 1.0, false, out.data());
  else
    out.noalias() += a * b.transpose();
}

void add_symmetric_product(const MatrixXd& a, const MatrixXd& b, double sign, MatrixXd& out) {
  if (small(out, a.cols()))
    add_product(out.rows(), out.cols(), a.cols(), a.data(), transposed(b), sign, true, out.data());
  else if (&a == &b)
    out.selfadjointView<Eigen::Lower>().rankUpdate(a, sign);
  else
    out.triangularView<Eigen::Lower>() += sign * a * b.transpose();
}

bool cholesky(const MatrixXd& p, double pivot_floor, MatrixXd& lower) {
  const Index n = p.rows();
  lower = p;
  if (n > small_dimension) {
    if (Eigen::internal::llt_inplace<double, Eigen::Lower>::blocked(lower) >= 0) return false;
    if (!(lower.diagonal().array().square() > pivot_floor * p.diagonal().array()).all()) return false;
  } else {
    Index j = 0;
    for (; n - j >= 4; j += 4)
      if (!factor_panel<4>(j, n, pivot_floor, lower.data())) return false;
    for (; j < n; ++j)
      if (!factor_panel<1>(j, n, pivot_floor, lower.data())) return false;
  }
  for (Index j = 1; j < n; ++j) lower.col(j).head(j).setZero();
  return true;
}

void solve_on_the_right(const MatrixXd& lower, MatrixXd& b) {
  for (Index j = 0; j < b.cols(); ++j) {
    for (Index k = 0; k < j; ++k) b.col(j) -= lower(j, k) * b.col(k);
    b.col(j) *= 1.0 / lower(j, j);
  }
}

}  // namespace kalfem
