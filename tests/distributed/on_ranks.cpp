// SPDX-License-Identifier: Apache-2.0
#include "on_ranks.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "kalfem/distributed/ranks.hpp"

namespace {

int ranks_at_work = 1;

void limit_memory() {
  constexpr auto limit = static_cast<rlim_t>(kalfem::test::most_memory_of_a_worker);
  const rlimit address_space{limit, limit};
  setrlimit(RLIMIT_AS, &address_space);
}

}  // namespace

int kalfem::test::number_of_ranks() { return ranks_at_work; }

/// Rank 0 runs the tests, which distribute everything with at least a row a rank.
int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  kalfem::distributed::Ranks ranks(argc, argv);
  if (ranks.works_for_rank_0()) {
    limit_memory();
    ranks.serve();
    return 0;
  }
  ranks_at_work = ranks.size();
  ranks.distribute({.least_rows = 1});
  return RUN_ALL_TESTS();
}
