// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

namespace kalfem {

/// Threads that wait for short work: task i of a run goes to thread i modulo their number, the caller among them, so
/// that which thread does what never changes. Waiting threads spin for a moment before they sleep, since the next run
/// of a time step loop comes within microseconds. Owned and used by one thread.
class WorkerPool {
public:
  /// `threads` >= 1, the caller counted.
  explicit WorkerPool(int threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  [[nodiscard]] int threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// Calls work(0) ... work(tasks - 1) and returns when all are done. `work` must not throw.
  template <class Work>
  void run(int tasks, const Work& work) {
    start({[](const void* context, int task) { (*static_cast<const Work*>(context))(task); }, &work, tasks});
  }

private:
  struct Job {
    void (*call)(const void*, int) = nullptr;
    const void* context = nullptr;
    int tasks = 0;
  };
  void start(const Job& job);
  void serve(int number);
  void take_share(int number) const;

  Job job_;
  std::atomic<unsigned> run_ = 0;
  std::atomic<int> busy_ = 0;
  std::atomic<bool> stopping_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace kalfem
