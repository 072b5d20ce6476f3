// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <atomic>
#include <memory>

namespace kalfem::distributed {

class Service;

struct RanksOptions {
  Eigen::Index least_rows = 20000;  ///< what has fewer rows, or fewer than ranks, is rank 0's alone
};

/// The processes that an MPI launcher started for one case. Rank 0 runs the program as if it were alone, while its
/// SparseFactor and LongVectors distribute what is large over all ranks; the others serve it:
///
///     Ranks ranks(argc, argv);
///     if (ranks.works_for_rank_0()) return ranks.serve();
///     ranks.distribute();
///     ...
///
/// One object a process; factors and vectors end before it.
class Ranks {
public:
  /// Throws InvalidInput where the MPI library cannot be called by several threads in turn.
  Ranks(int& argc, char**& argv);
  /// On rank 0, also after an exception: lets the workers go.
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] bool works_for_rank_0() const { return rank_ > 0; }

  /// From now on each rank works by itself, on runs of its own: rank 0 gives no orders.
  void share_runs() { orders_ = false; }

  /// On rank 0: factors and long vectors are distributed from here on.
  void distribute(const RanksOptions& options = {});
  /// Whether any was.
  [[nodiscard]] bool were_needed() const { return were_needed_; }

  /// On a worker: does its part of what rank 0 asks for, until rank 0 is through.
  void serve();
  /// Ends all ranks at once with an exit code: for a worker that cannot go on.
  [[noreturn]] void abandon(int code) const;

private:
  int rank_ = 0, size_ = 1;
  std::unique_ptr<Service> service_;
  bool orders_ = true;
  std::atomic<bool> were_needed_ = false;
};

}  // namespace kalfem::distributed
