#include "kalfem/estimation/small_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

#if defined(__AVX512F__)
constexpr int lane_size = 8;
#elif defined(__AVX__)
constexpr int lane_size = 4;
#else
constexpr int lane_size = 2;
#endif
constexpr int tallest = std::min(8, 2 * lane_size);  ///< rows of a tile, whose 6 columns of sums stay in registers

template <int Size>
struct Lane {
  typedef double type __attribute__((vector_size(Size * sizeof(double))));
};
template <>
struct Lane<1> {
  using type = double;
};

/// `Height` consecutive entries of a column in vector registers.
template <int Height>
struct Column {
  static constexpr int size = std::min(Height, lane_size), count = Height / size;
  typename Lane<size>::type lanes[count];

  Column() = default;
  explicit Column(const double* from) {
#pragma GCC unroll 8
    for (int i = 0; i < count; ++i) std::memcpy(&lanes[i], from + i * size, sizeof lanes[i]);
  }
  void store(double* to) const {
#pragma GCC unroll 8
    for (int i = 0; i < count; ++i) std::memcpy(to + i * size, &lanes[i], sizeof lanes[i]);
  }
  void add(const Column& other, double factor) {
#pragma GCC unroll 8
    for (int i = 0; i < count; ++i) lanes[i] += other.lanes[i] * factor;
  }
  void scale(double factor) {
#pragma GCC unroll 8
    for (int i = 0; i < count; ++i) lanes[i] *= factor;
  }
};

/// The right-hand factor of a product as its matrix stands in memory, and transposed.
struct Plain {
  const double* data;
  Index stride;
  double operator()(Index i, Index j) const { return data[i + j * stride]; }
  [[nodiscard]] Plain from(Index i, Index j) const { return {data + i + j * stride, stride}; }
};
struct Transposed {
  const double* data;
  Index stride;
  double operator()(Index i, Index j) const { return data[i * stride + j]; }
  [[nodiscard]] Transposed from(Index i, Index j) const { return {data + i * stride + j, stride}; }
};

Plain plain(const MatrixXd& matrix) { return {matrix.data(), matrix.rows()}; }
Transposed transposed(const MatrixXd& matrix) { return {matrix.data(), matrix.rows()}; }

/// sum = A B of one tile, Height x Width.
template <int Height, int Width, class Right>
[[gnu::always_inline]] inline void product_of_tile(Index depth, const double* a, Index a_stride, Right b,
                                                   Column<Height> (&sum)[Width]) {
#pragma GCC unroll 8
  for (int j = 0; j < Width; ++j) sum[j] = Column<Height>{};
  for (Index k = 0; k < depth; ++k) {
    const Column<Height> column(a + k * a_stride);
#pragma GCC unroll 8
    for (int j = 0; j < Width; ++j) sum[j].add(column, b(k, j));
  }
}

/// What becomes of a product A B and what stood in its place.
enum class Keep { nothing, sum, difference };

template <Keep keep, int Height, int Width, class Right>
[[gnu::always_inline]] inline void tile(Index depth, const double* a, Index a_stride, Right b, double* c,
                                        Index c_stride) {
  Column<Height> product[Width];
  product_of_tile<Height, Width>(depth, a, a_stride, b, product);
#pragma GCC unroll 8
  for (int j = 0; j < Width; ++j) {
    if constexpr (keep == Keep::nothing) {
      product[j].store(c + j * c_stride);
    } else {
      Column<Height> value(c + j * c_stride);
      value.add(product[j], keep == Keep::sum ? 1.0 : -1.0);
      value.store(c + j * c_stride);
    }
  }
}

/// `Width` columns and the rows from `row` on.
template <Keep keep, int Width, int Height = tallest, class Right>
[[gnu::noinline]] void panel(Index row, Index rows, Index depth, const double* a, Right b, double* c) {
  for (; rows - row >= Height; row += Height) tile<keep, Height, Width>(depth, a + row, rows, b, c + row, rows);
  if constexpr (Height > 1)
    if (row < rows) panel<keep, Width, Height / 2>(row, rows, depth, a, b, c);
}

/// Which part of a product is wanted or not zero.
enum class Shape { full, lower_result, lower_factor };

/// C = A B, C += A B or C -= A B, panels of columns from `j` on.
template <Keep keep, Shape shape, int Width = 6, class Right>
void product(Index j, Index rows, Index columns, Index depth, const double* a, Right b, double* c) {
  for (; columns - j >= Width; j += Width) {
    const Index row = shape == Shape::lower_result ? j - j % lane_size : 0, k = shape == Shape::lower_factor ? j : 0;
    panel<keep, Width>(row, rows, depth - k, a + k * rows, b.from(k, j), c + j * rows);
  }
  if constexpr (Width > 1)
    if (j < columns) product<keep, shape, Width == 6 ? 4 : Width / 2>(j, rows, columns, depth, a, b, c);
}

/// Columns of a panel behind its diagonal block L_J: X <- (C - A B) L_J^-T, one tile of rows at a time.
template <int Height, int Width>
[[gnu::always_inline]] inline void solve_tile(Index depth, const double* a, Index stride, Transposed b,
                                              const double* block, const double* inverse, double* c) {
  Column<Height> x[Width];
  product_of_tile<Height, Width>(depth, a, stride, b, x);
#pragma GCC unroll 8
  for (int j = 0; j < Width; ++j) {
    Column<Height> value(c + j * stride);
    value.add(x[j], -1.0);
    for (int k = 0; k < j; ++k) value.add(x[k], -block[j + k * stride]);
    value.scale(inverse[j]);
    value.store(c + j * stride);
    x[j] = value;
  }
}

template <int Width, int Height = tallest>
[[gnu::noinline]] void solve_panel(Index row, Index rows, Index depth, const double* a, Transposed b,
                                   const double* block, const double* inverse, double* c) {
  for (; rows - row >= Height; row += Height)
    solve_tile<Height, Width>(depth, a + row, rows, b, block, inverse, c + row);
  if constexpr (Height > 1)
    if (row < rows) solve_panel<Width, Height / 2>(row, rows, depth, a, b, block, inverse, c);
}

/// Factor of the diagonal block in place and the inverses of its diagonal.
template <int Width>
inline bool factor_block(double* block, Index stride, const double* floor, double* inverse) {
#pragma GCC unroll 8
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
  const Transposed before{l + j, n};  // L_J^T
  double floor[Width], inverse[Width];
  for (int i = 0; i < Width; ++i) floor[i] = pivot_floor * block[i + i * n];
  tile<Keep::difference, Width, Width>(j, l + j, n, before, block, n);
  if (!factor_block<Width>(block, n, floor, inverse)) return false;
  solve_panel<Width>(j + Width, n, j, l, before, block, inverse, l + j * n);
  return true;
}

/// Whether the result and the factors fit the nearest cache, so that nothing needs to be packed.
bool small(const MatrixXd& a, Index depth) {
  return std::max(a.rows(), a.cols()) <= small_dimension && depth <= 4 * small_dimension;
}

}  // namespace

void multiply(const MatrixXd& a, const MatrixXd& b, MatrixXd& out) {
  out.resize(a.rows(), b.cols());
  if (small(b, a.rows()))
    product<Keep::nothing, Shape::full>(0, a.rows(), b.cols(), b.rows(), a.data(), plain(b), out.data());
  else
    out.noalias() = a * b;
}

void multiply_lower(const MatrixXd& a, const MatrixXd& lower, MatrixXd& out) {
  const Index n = lower.rows(), block = 48;
  out.resize(a.rows(), n);
  if (small(lower, a.rows())) {
    product<Keep::nothing, Shape::lower_factor>(0, a.rows(), n, n, a.data(), plain(lower), out.data());
    return;
  }
  for (Index j = 0; j < n; j += block) {
    const Index width = std::min(block, n - j);
    out.middleCols(j, width).noalias() = a.rightCols(n - j) * lower.block(j, j, n - j, width);
  }
}

void multiply_transposed(const MatrixXd& a, const MatrixXd& b, MatrixXd& out) {
  out.resize(a.rows(), b.rows());
  if (small(out, a.cols()))
    product<Keep::nothing, Shape::full>(0, out.rows(), out.cols(), a.cols(), a.data(), transposed(b), out.data());
  else
    out.noalias() = a * b.transpose();
}

void add_product_transposed(const MatrixXd& a, const MatrixXd& b, MatrixXd& out) {
  if (small(out, a.cols()))
    product<Keep::sum, Shape::full>(0, out.rows(), out.cols(), a.cols(), a.data(), transposed(b), out.data());
  else
    out.noalias() += a * b.transpose();
}

void add_symmetric_product(const MatrixXd& a, const MatrixXd& b, MatrixXd& out) {
  if (small(out, a.cols()))
    product<Keep::sum, Shape::lower_result>(0, out.rows(), out.cols(), a.cols(), a.data(), transposed(b), out.data());
  else if (&a == &b)
    out.selfadjointView<Eigen::Lower>().rankUpdate(a);
  else
    out.triangularView<Eigen::Lower>() += a * b.transpose();
}

void subtract_square(const MatrixXd& a, MatrixXd& out) {
  if (small(out, a.cols()))
    product<Keep::difference, Shape::lower_result>(0, out.rows(), out.cols(), a.cols(), a.data(), transposed(a),
                                                   out.data());
  else
    out.selfadjointView<Eigen::Lower>().rankUpdate(a, -1.0);
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
  for (Index j = 1; j < n; ++j)
    for (Index i = 0; i < j; ++i) lower(i, j) = 0.0;
  return true;
}

void solve_on_the_right(const MatrixXd& lower, MatrixXd& b) {
  for (Index j = 0; j < b.cols(); ++j) {
    for (Index k = 0; k < j; ++k) b.col(j) -= lower(j, k) * b.col(k);
    b.col(j) *= 1.0 / lower(j, j);
  }
}

}  // namespace kalfem
