#include <gtest/gtest.h>

#include "kalfem/distributed/ranks.hpp"

/// Rank 0 runs the tests, which distribute every matrix with at least a row a rank.
int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  kalfem::distributed::Ranks ranks(argc, argv);
  if (ranks.works_for_rank_0()) {
    ranks.serve();
    return 0;
  }
  ranks.distribute({.least_rows = 1});
  return RUN_ALL_TESTS();
}
