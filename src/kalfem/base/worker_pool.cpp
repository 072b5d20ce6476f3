// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/worker_pool.hpp"

#include <chrono>

namespace kalfem {
namespace {

constexpr std::chrono::microseconds spin_time{200};

template <class Done>
bool spin_until(Done done) {
  const auto begin = std::chrono::steady_clock::now();
  for (int turn = 1; !done(); ++turn)
    if (turn % 64 == 0 && std::chrono::steady_clock::now() - begin > spin_time) return false;
  return true;
}

}  // namespace

WorkerPool::WorkerPool(int threads) {
  for (int number = 1; number < threads; ++number) workers_.emplace_back([this, number] { serve(number); });
}

WorkerPool::~WorkerPool() {
  stopping_ = true;
  ++run_;
  run_.notify_all();
  for (auto& worker : workers_) worker.join();
}

void WorkerPool::start(const Job& job) {
  job_ = job;
  busy_ = static_cast<int>(workers_.size());
  ++run_;
  run_.notify_all();
  take_share(0);
  for (;;) {
    if (spin_until([this] { return busy_ == 0; })) return;
    if (const int busy = busy_; busy != 0) busy_.wait(busy);
  }
}

void WorkerPool::serve(int number) {
  unsigned seen = 0;
  for (;;) {
    if (!spin_until([&] { return run_ != seen; })) run_.wait(seen);
    if (run_ == seen) continue;
    ++seen;
    if (stopping_) return;
    take_share(number);
    if (--busy_ == 0) busy_.notify_one();
  }
}

void WorkerPool::take_share(int number) const {
  for (int task = number; task < job_.tasks; task += threads()) job_.call(job_.context, task);
}

}  // namespace kalfem
