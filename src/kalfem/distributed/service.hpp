// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mpi.h>

#include <array>
#include <atomic>
#include <mutex>

namespace kalfem::distributed {

/// What the ranks may be asked to do together.
enum class Task : int {
  make_factor,  ///< a MUMPS instance under a number
  run_factor,   ///< one job of that instance
  free_factor,
  make_vectors,  ///< distributed vectors under a number; their rows
  use_vectors,   ///< one job with them and its arguments, see VectorsJob
  free_vectors,
  finish  ///< the workers' service ends
};

/// A task with the number of the object that it belongs to, and what else the workers must know.
struct Order {
  Task task = Task::finish;
  int object = 0;
  std::array<int, 4> arguments = {};
};

/// Rank 0 gives orders, all other ranks wait for them: the channel between the program on rank 0 and its workers.
class Service {
public:
  explicit Service(MPI_Comm ranks) : ranks_(ranks) {}

  [[nodiscard]] MPI_Comm ranks() const { return ranks_; }

  /// Rank 0: a number for an object that the workers hold a part of.
  [[nodiscard]] int new_object() { return ++objects_; }

  /// Rank 0: gives an order and does its own part of it. Threads take turns, as the workers do one thing at a time.
  template <class Part>
  void together(Order order, const Part& part) {
    const std::lock_guard turn(one_at_a_time_);
    announce(order);
    part();
  }

  /// A worker: the next order. Sleeps more and more while none comes: whatever rank 0 computes alone meanwhile may need
  /// the processor.
  [[nodiscard]] Order await() const;

private:
  void announce(Order order) const;

  MPI_Comm ranks_;
  std::mutex one_at_a_time_;
  std::atomic<int> objects_ = 0;
};

}  // namespace kalfem::distributed
