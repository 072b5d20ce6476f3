// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "kalfem/base/interruption.hpp"

namespace kalfem {

/// While it lives, the computations of its thread take one core: the others work beside it already.
class OneCore {
public:
  OneCore() : outer_(std::exchange(taken_, true)) {}
  ~OneCore() { taken_ = outer_; }
  OneCore(const OneCore&) = delete;
  OneCore& operator=(const OneCore&) = delete;

  [[nodiscard]] static bool taken() { return taken_; }

private:
  bool outer_;
  static inline thread_local bool taken_ = false;
};

/// Cores that a computation may use: those of the machine, or one where other threads of the same job use them.
inline int processors() {
  return OneCore::taken() ? 1 : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Calls work(i) for i = 0 .. count - 1 on that many threads, the caller's among them, each index once and in no
/// certain order; with several threads each is OneCore, so that work that is spread itself does not ask for more than
/// there are. The first exception that a call throws is thrown again after all threads have ended; indices that
/// were not begun by then are left out.
template <class Work>
void for_each_index(std::size_t count, int threads, const Work& work) {
  std::atomic<std::size_t> next = 0;
  std::exception_ptr thrown;
  std::mutex guard;
  const auto most = std::min(count, static_cast<std::size_t>(std::max(1, threads)));
  const auto serve = [&] {
    std::optional<OneCore> one_core;
    if (most > 1) one_core.emplace();
    for (std::size_t i = next++; i < count; i = next++) try {
        work(i);
      } catch (...) {
        const std::scoped_lock lock(guard);
        if (!thrown) thrown = std::current_exception();
        next = count;
      }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < most; ++i)
      others.emplace_back([&, asked = StopScope::question()] {
        const StopScope scope(asked);
        serve();
      });
    serve();
  }
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace kalfem
