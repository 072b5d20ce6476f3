#pragma once

#include <Eigen/Dense>
#include <atomic>
#include <memory>

namespace kalfem::distributed {

class Service;

struct RanksOptions {
  Eigen::Index least_rows = 20000;  ///< matrices with fewer rows are factored by rank 0 alone
};

/// The processes that an MPI launcher started for one case. Rank 0 runs the program as if it were alone, and from here
/// on its SparseFactor distributes large matrices over all ranks; the others serve it:
///
///     Ranks ranks(argc, argv);
///     if (ranks.works_for_rank_0()) return ranks.serve();
///     ...
///
/// One object a process; what was factored ends before it.
class Ranks {
public:
  /// Throws InvalidInput where the MPI library cannot be called from several threads in turn.
  Ranks(int& argc, char**& argv, const RanksOptions& options = {});
  /// On rank 0, also after an exception: lets the workers go.
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] bool works_for_rank_0() const { return rank_ > 0; }

  /// Does the worker's part of what rank 0 asks for, until rank 0 is through.
  void serve();
  /// Whether rank 0 has distributed anything up to now.
  [[nodiscard]] bool were_needed() const { return were_needed_; }
  /// Ends all ranks at once with an exit code: for a worker that cannot go on.
  [[noreturn]] void abandon(int code) const;

private:
  int rank_ = 0, size_ = 1;
  std::unique_ptr<Service> service_;
  std::atomic<bool> were_needed_ = false;
};

}  // namespace kalfem::distributed
