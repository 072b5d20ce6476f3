// SPDX-License-Identifier: Apache-2.0
#include "kalfem/distributed/mumps_workspace.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <stdexcept>
#include <string>

#include "kalfem/distributed/weakest_direction.hpp"
#include "kalfem/linalg/cholmod_workspace.hpp"

namespace kalfem::distributed {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int most_room = 400;  ///< workspace beyond the estimate that is tried [%]

/// Entries of MUMPS' arrays by the numbers of its manual.
template <class Array>
auto& entry(Array& array, int number) {
  return array[number - 1];
}

/// MUMPS takes the order and the scaling that it is given, and the pivots as they come, as Cholesky does.
void set_options(DMUMPS_STRUC_C& state) {
  entry(state.icntl, 6) = 0;   // no permutation of columns
  entry(state.icntl, 7) = 1;   // the order is given
  entry(state.icntl, 8) = -1;  // so is the scaling
  entry(state.icntl, 12) = 1;  // no pairs of columns are looked for beforehand
  entry(state.icntl, 13) = 1;  // the last front is not left to ScaLAPACK, which would not count its negative pivots
  entry(state.icntl, 16) = 1;  // one thread a rank
  entry(state.cntl, 1) = 0.0;  // no pivoting
}

EliminationOrder fill_reducing_order(const UpperTriangle& pattern) { return CholmodWorkspace(pattern, {}).order(); }

/// A_jj^-1/2; what no factor can answer is refused.
VectorXd unit_diagonal_scale(const UpperTriangle& matrix) {
  for (Index column = 0; column < matrix.size; ++column) {
    if (!(matrix.diagonal[column] > 0.0)) throw NotPositiveDefinite(column);
    for (auto k = matrix.starts[static_cast<std::size_t>(column)];
         k < matrix.starts[static_cast<std::size_t>(column) + 1]; ++k)
      if (!std::isfinite(matrix.values[static_cast<std::size_t>(k)])) throw NotPositiveDefinite(column);
  }
  return matrix.diagonal.cwiseSqrt().cwiseInverse();
}

}  // namespace

// The order of elimination is that of CHOLMOD's analysis, nested dissection or minimum degree, whichever fills less.
// The matrix is scaled to a unit diagonal, so that the smallest entry of D, which MUMPS keeps account of, is the
// smallest pivot relative to its diagonal entry. It does not tell which it is: the column that is named for a matrix
// that is not positive definite is the one that moves most where it is weakest.
MumpsWorkspace::MumpsWorkspace(Service& service, const UpperTriangle& pattern, const EliminationOrder& order)
    : scale_(unit_diagonal_scale(pattern)),
      order_(order.empty() ? fill_reducing_order(pattern) : order),
      mumps_(service) {
  set_options(mumps_.state());
  std::vector<MUMPS_INT> places(order_.size());
  for (std::size_t j = 0; j < order_.size(); ++j)
    places[static_cast<std::size_t>(order_[j])] = static_cast<MUMPS_INT>(j + 1);
  mumps_.state().perm_in = places.data();
  give(pattern);
  if (mumps_.run(MumpsJob::analyse) < 0) fail();
  mumps_.state().perm_in = nullptr;
}

void MumpsWorkspace::fail() const {
  const int status = entry(mumps_.state().infog, 1);
  if (status == -5 || status == -7 || status == -13) throw std::bad_alloc();
  throw std::logic_error("MUMPS refused its arguments, status " + std::to_string(status) + ", " +
                         std::to_string(entry(mumps_.state().infog, 2)));
}

void MumpsWorkspace::give(const UpperTriangle& matrix) {
  rows_.resize(matrix.rows.size());
  columns_.resize(matrix.rows.size());
  for (Index column = 0; column < matrix.size; ++column)
    for (auto k = static_cast<std::size_t>(matrix.starts[static_cast<std::size_t>(column)]);
         k < static_cast<std::size_t>(matrix.starts[static_cast<std::size_t>(column) + 1]); ++k) {
      rows_[k] = static_cast<MUMPS_INT>(matrix.rows[k] + 1);
      columns_[k] = static_cast<MUMPS_INT>(column + 1);
    }
  auto& state = mumps_.state();
  state.n = static_cast<MUMPS_INT>(matrix.size);
  state.nnz = static_cast<MUMPS_INT8>(rows_.size());
  state.irn = rows_.data();
  state.jcn = columns_.data();
}

void MumpsWorkspace::take_back() {
  auto& state = mumps_.state();
  state.irn = state.jcn = nullptr;
  state.a = nullptr;
  rows_ = columns_ = {};
}

void MumpsWorkspace::factorize(const UpperTriangle& matrix) {
  scale_ = unit_diagonal_scale(matrix);
  mumps_.state().colsca = mumps_.state().rowsca = scale_.data();
  if (rows_.empty()) give(matrix);
  const bool zero_met = !eliminate(matrix.values);
  if (zero_met) eliminate_beside(matrix);
  take_back();
  smallest_pivot_ = entry(mumps_.state().rinfog, 19);
  const bool negative_met = entry(mumps_.state().infog, 12) > 0;
  if (zero_met || negative_met || !(smallest_pivot_ > zero_pivot))
    throw NotPositiveDefinite(weakest_column(negative_met));
}

/// False where a pivot is exactly zero. The estimate of the workspace may be too low: it is raised then.
bool MumpsWorkspace::eliminate(const std::vector<double>& values) {
  constexpr std::array too_little_room = {-8, -9, -14, -15, -17, -20};
  constexpr int zero_pivot_met = -10;
  auto& state = mumps_.state();
  state.a = const_cast<double*>(values.data());
  while (mumps_.run(MumpsJob::factorize) < 0) {
    const int status = entry(state.infog, 1);
    if (status == zero_pivot_met) return false;
    if (std::ranges::find(too_little_room, status) == too_little_room.end() || entry(state.icntl, 14) > most_room)
      fail();
    entry(state.icntl, 14) *= 2;
  }
  return true;
}

/// A factor near that of a matrix with a zero pivot, to find what is weak there.
void MumpsWorkspace::eliminate_beside(const UpperTriangle& matrix) {
  std::vector<double> values = matrix.values;
  do {
    for (Index column = 0; column < matrix.size; ++column)
      values[static_cast<std::size_t>(matrix.starts[static_cast<std::size_t>(column) + 1] - 1)] *=
          1.0 + 0.1 * zero_pivot;
  } while (!eliminate(values));
}

Index MumpsWorkspace::weakest_column(bool negative_met) {
  const Eigen::ArrayXd scale_back = scale_.array().inverse();
  return weakest_entry(scale_.size(), negative_met, [&](const VectorXd& load) {
    VectorXd response = scale_back * load.array();
    solve(response, response);
    return VectorXd(scale_back * response.array());
  });
}

void MumpsWorkspace::solve(const Eigen::Ref<const MatrixXd>& right_side, Eigen::Ref<MatrixXd> solution) {
  if (solution.data() != right_side.data()) solution = right_side;
  auto& state = mumps_.state();
  state.rhs = solution.data();
  state.lrhs = static_cast<MUMPS_INT>(solution.cols() == 1 ? solution.rows() : solution.outerStride());
  state.nrhs = static_cast<MUMPS_INT>(solution.cols());
  if (mumps_.run(MumpsJob::solve) < 0) fail();
}

double MumpsWorkspace::nonzeros() const {
  const double entries = entry(mumps_.state().infog, 29);
  return entries < 0.0 ? -1e6 * entries : entries;
}

double MumpsWorkspace::bytes() const {
  const double indices = entry(mumps_.state().infog, 10);
  return 8.0 * nonzeros() + double(sizeof(MUMPS_INT)) * (indices < 0.0 ? -1e6 * indices : indices);
}

}  // namespace kalfem::distributed
