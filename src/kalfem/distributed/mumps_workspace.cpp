#include "kalfem/distributed/mumps_workspace.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <new>
#include <stdexcept>
#include <string>

#include "kalfem/distributed/negative_direction.hpp"
#include "kalfem/linalg/cholmod_workspace.hpp"

namespace kalfem::distributed {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double doubtful_pivot = 1e-10;  ///< below it a row may be the rounding of a large model's zero
constexpr int most_room = 400;            ///< workspace beyond the estimate that is tried [%]

/// Entries of MUMPS' arrays by the numbers of its manual.
template <class Array>
auto& entry(Array& array, int number) {
  return array[number - 1];
}

/// MUMPS writes nothing; it takes the order and the scaling that it is given, looks for rows that vanish, counts
/// negative pivots in all fronts, and takes every other pivot as it comes, as Cholesky does.
void set_options(DMUMPS_STRUC_C& state) {
  for (const int output : {1, 2, 3, 4}) entry(state.icntl, output) = 0;
  entry(state.icntl, 6) = 0;     // no permutation of columns
  entry(state.icntl, 7) = 1;     // the order is given
  entry(state.icntl, 8) = -1;    // so is the scaling
  entry(state.icntl, 12) = 1;    // no pairs of columns are looked for beforehand
  entry(state.icntl, 13) = 1;    // the last front is not left to ScaLAPACK, which would not count its negative pivots
  entry(state.icntl, 16) = 1;    // one thread a rank
  entry(state.icntl, 24) = 1;    // rows that vanish are counted, listed and passed over
  entry(state.cntl, 1) = 1e-30;  // not 0, with which rows that vanish would not be looked for
}

EliminationOrder fill_reducing_order(const LowerTriangle& pattern) { return CholmodWorkspace(pattern, {}).order(); }

int next_number() {
  static std::atomic<int> last = 0;
  return ++last;
}

}  // namespace

// The order of elimination is that of CHOLMOD's analysis, nested dissection or minimum degree, whichever fills less.
// One factorisation answers a definite matrix that no row comes near to vanishing in; another one with the threshold of
// a zero decides where one does.
MumpsWorkspace::MumpsWorkspace(Service& service, const LowerTriangle& pattern, const EliminationOrder& order)
    : service_(service), number_(next_number()), order_(order.empty() ? fill_reducing_order(pattern) : order) {
  service_.together({Task::make_factor, number_, 0}, [&] { instance_.emplace(service_.ranks()); });
  set_options(instance_->state());
  std::vector<MUMPS_INT> places(order_.size());
  for (std::size_t j = 0; j < order_.size(); ++j)
    places[static_cast<std::size_t>(order_[j])] = static_cast<MUMPS_INT>(j + 1);
  instance_->state().perm_in = places.data();
  give(pattern);
  run(MumpsJob::analyse);
  instance_->state().perm_in = nullptr;
}

MumpsWorkspace::~MumpsWorkspace() {
  service_.together({Task::free_factor, number_, 0}, [&] { instance_.reset(); });
}

void MumpsWorkspace::run(MumpsJob job) {
  service_.together({Task::run_factor, number_, static_cast<int>(job)}, [&] { instance_->run(job); });
}

void MumpsWorkspace::give(const LowerTriangle& matrix) {
  rows_.resize(matrix.rows.size());
  columns_.resize(matrix.rows.size());
  for (Index column = 0; column < matrix.size; ++column)
    for (auto k = static_cast<std::size_t>(matrix.starts[static_cast<std::size_t>(column)]);
         k < static_cast<std::size_t>(matrix.starts[static_cast<std::size_t>(column) + 1]); ++k) {
      rows_[k] = static_cast<MUMPS_INT>(matrix.rows[k] + 1);
      columns_[k] = static_cast<MUMPS_INT>(column + 1);
    }
  auto& state = instance_->state();
  state.n = static_cast<MUMPS_INT>(matrix.size);
  state.nnz = static_cast<MUMPS_INT8>(rows_.size());
  state.irn = rows_.data();
  state.jcn = columns_.data();
  state.a = const_cast<double*>(matrix.values.data());
}

void MumpsWorkspace::take_back() {
  auto& state = instance_->state();
  state.irn = state.jcn = nullptr;
  state.a = nullptr;
  rows_ = columns_ = {};
}

void MumpsWorkspace::scale(const LowerTriangle& matrix) {
  for (Index column = 0; column < matrix.size; ++column) {
    if (!(matrix.diagonal[column] > 0.0)) throw NotPositiveDefinite(column);
    for (auto k = matrix.starts[static_cast<std::size_t>(column)];
         k < matrix.starts[static_cast<std::size_t>(column) + 1]; ++k)
      if (!std::isfinite(matrix.values[static_cast<std::size_t>(k)])) throw NotPositiveDefinite(column);
  }
  scale_ = matrix.diagonal.cwiseSqrt().cwiseInverse();
  instance_->state().colsca = instance_->state().rowsca = scale_.data();
}

void MumpsWorkspace::factorize(const LowerTriangle& matrix) {
  scale(matrix);
  if (rows_.empty()) give(matrix);
  instance_->state().a = const_cast<double*>(matrix.values.data());
  const auto vanishing_rows = [&](double threshold) {
    eliminate(threshold);
    return entry(instance_->state().infog, 28);
  };
  smallest_pivot_ = doubtful_pivot;
  if (vanishing_rows(doubtful_pivot) > 0) {
    smallest_pivot_ = zero_pivot;
    if (vanishing_rows(zero_pivot) > 0) throw NotPositiveDefinite(instance_->state().pivnul_list[0] - 1);
  }
  take_back();
  if (entry(instance_->state().infog, 12) > 0) throw NotPositiveDefinite(column_of_negative_energy());
}

/// Factors with more and more workspace where the estimate of the analysis was too low.
void MumpsWorkspace::eliminate(double threshold) {
  constexpr std::array too_little = {-8, -9, -14, -15, -17, -20};
  auto& state = instance_->state();
  entry(state.cntl, 3) = -threshold;  // negative: absolute
  run(MumpsJob::factorize);
  while (std::ranges::find(too_little, entry(state.infog, 1)) != too_little.end() &&
         entry(state.icntl, 14) < most_room) {
    entry(state.icntl, 14) *= 2;
    run(MumpsJob::factorize);
  }
}

Index MumpsWorkspace::column_of_negative_energy() {
  const Eigen::ArrayXd stiffness = scale_.array().inverse();
  return largest_entry_of_negative_direction(scale_.size(), [&](const VectorXd& load) {
    VectorXd response = stiffness * load.array();
    solve(response, response);
    return VectorXd(stiffness * response.array());
  });
}

void MumpsWorkspace::solve(const Eigen::Ref<const MatrixXd>& right_side, Eigen::Ref<MatrixXd> solution) {
  if (solution.data() != right_side.data()) solution = right_side;
  auto& state = instance_->state();
  state.rhs = solution.data();
  state.lrhs = static_cast<MUMPS_INT>(solution.cols() == 1 ? solution.rows() : solution.outerStride());
  state.nrhs = static_cast<MUMPS_INT>(solution.cols());
  run(MumpsJob::solve);
}

double MumpsWorkspace::nonzeros() const {
  const double entries = entry(instance_->state().infog, 29);
  return entries < 0.0 ? -1e6 * entries : entries;
}

double MumpsWorkspace::bytes() const {
  const double indices = entry(instance_->state().infog, 10);
  return 8.0 * nonzeros() + double(sizeof(MUMPS_INT)) * (indices < 0.0 ? -1e6 * indices : indices);
}

}  // namespace kalfem::distributed
