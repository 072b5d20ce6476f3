// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mpi.h>

#include <Eigen/Dense>
#include <vector>

#include "kalfem/distributed/service.hpp"
#include "kalfem/linalg/long_vectors.hpp"

namespace kalfem::distributed {

/// What the ranks do together with distributed vectors; beside it the arguments of its order.
enum class VectorsJob : int {
  reserve,      ///< capacity
  put,          ///< place, columns of the block
  get,          ///< the same
  products,     ///< begin, end, columns of the block
  project_out,  ///< begin, end, columns of the block
  combination,  ///< rows and columns of the weights
  combine       ///< the same
};

/// One rank's rows of distributed vectors, about as many on each rank. Every call concerns all ranks at once. Rank 0
/// gives and gets whole blocks and weights; the others give blocks without rows, for their number of columns, and
/// weights of the right size.
class VectorsPart {
public:
  using Columns = LongVectors::Columns;
  static constexpr Eigen::Index widest = 8;  ///< columns that a block may have

  VectorsPart(MPI_Comm ranks, Eigen::Index rows);

  /// Whether every rank has found the room.
  bool reserve(Eigen::Index capacity);
  void put(Eigen::Index place, const Columns& block);
  void get(Eigen::Index place, Eigen::Ref<Eigen::MatrixXd> block);
  Eigen::MatrixXd products(Eigen::Index begin, Eigen::Index end, const Columns& block);
  Eigen::MatrixXd project_out(Eigen::Index begin, Eigen::Index end, const Columns& mass_weighted,
                              Eigen::Ref<Eigen::MatrixXd> block);
  void combination(const Columns& weights, Eigen::Ref<Eigen::MatrixXd> block);
  void combine(const Columns& weights) { own_.combine(on_all_ranks(weights)); }

  /// A worker's part in what rank 0 has ordered: a job and its arguments.
  void follow(const Order& order);

  [[nodiscard]] Eigen::Index capacity() const { return own_.capacity(); }

private:
  void scatter(const Columns& block, Eigen::Ref<Eigen::MatrixXd> part) const;
  /// On rank 0: calls `use` for each column of the parts, while `whole_` has all its rows.
  template <class Use>
  void gather(const Columns& parts, const Use& use);
  [[nodiscard]] Eigen::MatrixXd on_all_ranks(Eigen::MatrixXd weights) const;

  [[nodiscard]] bool on_rank_0() const { return rank_ == 0; }

  MPI_Comm ranks_;
  std::vector<int> rows_, first_row_;  ///< of each rank
  int rank_;
  VectorsInMemory own_;
  Eigen::MatrixXd part_;   ///< this rank's rows of a block
  Eigen::VectorXd whole_;  ///< a column of a block, on rank 0 only
};

}  // namespace kalfem::distributed
