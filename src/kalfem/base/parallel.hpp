#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "kalfem/base/interruption.hpp"

namespace kalfem {

/// Calls work(i) for i = 0 .. count - 1 on that many threads, the caller's among them, each index once and in no
/// certain order. The first exception that a call throws is thrown again after all threads have ended; indices that
/// were not begun by then are left out.
template <class Work>
void for_each_index(std::size_t count, int threads, const Work& work) {
  std::atomic<std::size_t> next = 0;
  std::exception_ptr thrown;
  std::mutex guard;
  const auto serve = [&] {
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
    const auto most = std::min(count, static_cast<std::size_t>(std::max(1, threads)));
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
