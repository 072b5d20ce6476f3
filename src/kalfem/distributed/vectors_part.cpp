// SPDX-License-Identifier: Apache-2.0
#include "kalfem/distributed/vectors_part.hpp"

#include <array>
#include <new>
#include <numeric>

namespace kalfem::distributed {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

using Requests = std::array<MPI_Request, VectorsPart::widest>;

int rank_in(MPI_Comm ranks) {
  int rank = 0;
  MPI_Comm_rank(ranks, &rank);
  return rank;
}

/// Rows of each rank, which differ by one at most.
std::vector<int> shares(MPI_Comm ranks, Index rows) {
  int size = 1;
  MPI_Comm_size(ranks, &size);
  std::vector<int> shares(static_cast<std::size_t>(size), static_cast<int>(rows / size));
  for (Index rank = 0; rank < rows % size; ++rank) ++shares[static_cast<std::size_t>(rank)];
  return shares;
}

std::vector<int> starts(const std::vector<int>& shares) {
  std::vector<int> starts(shares.size());
  std::exclusive_scan(shares.begin(), shares.end(), starts.begin(), 0);
  return starts;
}

}  // namespace

VectorsPart::VectorsPart(MPI_Comm ranks, Index rows)
    : ranks_(ranks),
      rows_(shares(ranks, rows)),
      first_row_(starts(rows_)),
      rank_(rank_in(ranks)),
      own_(rows_[static_cast<std::size_t>(rank_)]),
      part_(own_.rows(), widest),
      whole_(on_rank_0() ? rows : 0) {}

bool VectorsPart::reserve(Index capacity) {
  int found = 1;
  try {
    own_.reserve(capacity);
  } catch (const std::bad_alloc&) {
    found = 0;
  }
  MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_INT, MPI_MIN, ranks_);
  return found == 1;
}

void VectorsPart::put(Index place, const Columns& block) { scatter(block, own_.between(place, place + block.cols())); }

void VectorsPart::get(Index place, Eigen::Ref<MatrixXd> block) {
  gather(own_.between(place, place + block.cols()), [&](Index column) { block.col(column) = whole_; });
}

// Each rank has its part of the sum from its rows alone.
MatrixXd VectorsPart::products(Index begin, Index end, const Columns& block) {
  auto part = part_.leftCols(block.cols());
  scatter(block, part);
  MatrixXd sum = own_.products(begin, end, part);
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), static_cast<int>(sum.size()), MPI_DOUBLE, MPI_SUM, ranks_);
  return sum;
}

// Of C each rank makes its rows of Q C, and rank 0 takes them from V, which never leaves it.
MatrixXd VectorsPart::project_out(Index begin, Index end, const Columns& mass_weighted, Eigen::Ref<MatrixXd> block) {
  MatrixXd coefficients = products(begin, end, mass_weighted);
  auto part = part_.leftCols(block.cols());
  part.noalias() = own_.between(begin, end) * coefficients;
  gather(part, [&](Index column) { block.col(column) -= whole_; });
  return coefficients;
}

void VectorsPart::combination(const Columns& weights, Eigen::Ref<MatrixXd> block) {
  auto part = part_.leftCols(weights.cols());
  part.noalias() = own_.between(0, weights.rows()) * on_all_ranks(weights);
  gather(part, [&](Index column) { block.col(column) = whole_; });
}

void VectorsPart::follow(const Order& order) {
  const auto [job, first, second, third] = order.arguments;
  MatrixXd no_rows(0, widest);
  switch (static_cast<VectorsJob>(job)) {
    case VectorsJob::reserve:
      reserve(first);
      break;
    case VectorsJob::put:
      put(first, no_rows.leftCols(second));
      break;
    case VectorsJob::get:
      get(first, no_rows.leftCols(second));
      break;
    case VectorsJob::products:
      products(first, second, no_rows.leftCols(third));
      break;
    case VectorsJob::project_out:
      project_out(first, second, no_rows.leftCols(third), no_rows.leftCols(third));
      break;
    case VectorsJob::combination:
      combination(MatrixXd(first, second), no_rows.leftCols(second));
      break;
    case VectorsJob::combine:
      combine(MatrixXd(first, second));
      break;
  }
}

// A column is a message, so that no count or place exceeds the number of rows, which is an int; the columns of a block
// are under way together.
void VectorsPart::scatter(const Columns& block, Eigen::Ref<MatrixXd> part) const {
  Requests requests;
  for (Index column = 0; column < block.cols(); ++column)
    MPI_Iscatterv(block.col(column).data(), rows_.data(), first_row_.data(), MPI_DOUBLE, part.col(column).data(),
                  static_cast<int>(part.rows()), MPI_DOUBLE, 0, ranks_, &requests[column]);
  MPI_Waitall(static_cast<int>(block.cols()), requests.data(), MPI_STATUSES_IGNORE);
}

template <class Use>
void VectorsPart::gather(const Columns& parts, const Use& use) {
  Requests requests;
  for (Index column = 0; column < parts.cols(); ++column) {
    MPI_Igatherv(parts.col(column).data(), static_cast<int>(parts.rows()), MPI_DOUBLE, whole_.data(), rows_.data(),
                 first_row_.data(), MPI_DOUBLE, 0, ranks_, &requests[column]);
    if (!on_rank_0()) continue;
    MPI_Wait(&requests[column], MPI_STATUS_IGNORE);
    use(column);
  }
  MPI_Waitall(static_cast<int>(parts.cols()), requests.data(), MPI_STATUSES_IGNORE);
}

MatrixXd VectorsPart::on_all_ranks(MatrixXd weights) const {
  MPI_Bcast(weights.data(), static_cast<int>(weights.size()), MPI_DOUBLE, 0, ranks_);
  return weights;
}

}  // namespace kalfem::distributed
