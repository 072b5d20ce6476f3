// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/worker_pool.hpp"

#include <gtest/gtest.h>
#include <numeric>

namespace kalfem {
namespace {

TEST(WorkerPool, EveryTaskIsDoneOnceInEveryRun) {
  for (const int threads : {1, 2, 3, 5}) {
    WorkerPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    std::vector<int> count(7, 0);
    for (int run = 0; run < 2000; ++run)  // back to back, so that threads meet runs both awake and asleep
      pool.run(7, [&](int task) { ++count[static_cast<std::size_t>(task)]; });
    for (const int times : count) EXPECT_EQ(times, 2000) << threads;
  }
}

TEST(WorkerPool, ThreadsThatSleepWakeAgain) {
  WorkerPool pool(2);
  std::vector<int> done(2, 0);
  for (int run = 0; run < 5; ++run) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    pool.run(2, [&](int task) { ++done[static_cast<std::size_t>(task)]; });
  }
  EXPECT_EQ(done, (std::vector<int>{5, 5}));
}

TEST(WorkerPool, NoTaskIsNoWork) {
  WorkerPool pool(3);
  pool.run(0, [](int) { FAIL(); });
}

}  // namespace
}  // namespace kalfem
