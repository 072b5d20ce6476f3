// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/interruption.hpp"

#include <gtest/gtest.h>
#include <atomic>

#include "kalfem/base/parallel.hpp"

namespace kalfem {
namespace {

TEST(Interruption, ReachesTheThreadsOfAComputation) {
  std::atomic<int> asked = 0, done = 0;
  const StopQuestion question = [&] { return ++asked > 10; };
  const auto work = [&](std::size_t) {
    stop_if_asked();
    ++done;
  };
  {
    const StopScope scope(&question);
    EXPECT_THROW(for_each_index(100, 4, work), Interrupted);
  }
  EXPECT_EQ(done, 10);
  EXPECT_NO_THROW(for_each_index(100, 4, work));  // nobody asks any more
  EXPECT_EQ(done, 110);
}

}  // namespace
}  // namespace kalfem
