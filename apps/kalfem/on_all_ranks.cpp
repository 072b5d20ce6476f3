// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdlib>
#include <exception>
#include <string_view>

#include "console.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/distributed/ranks.hpp"
#include "ranks.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

constexpr const char* least_rows_variable = "KALFEM_DISTRIBUTED_ROWS";

distributed::RanksOptions options() {
  distributed::RanksOptions options;
  const char* rows = std::getenv(least_rows_variable);
  if (rows == nullptr) return options;
  char* end = nullptr;
  options.least_rows = std::strtol(rows, &end, 10);
  if (end == rows || *end != '\0' || options.least_rows < 1)
    throw InvalidInput(std::string(least_rows_variable) + "=" + rows,
                       "it is the number of rows from which a matrix is distributed over the ranks",
                       "set it to a number of at least 1, or not at all");
  return options;
}

/// It is rank 0 that a signal may ask to stop.
void leave_signals_to_rank_0() {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_IGN);
}

/// A worker does its part, or ends all ranks: rank 0 would wait for it.
int work(distributed::Ranks& ranks, const std::function<int()>& part) {
  leave_signals_to_rank_0();
  try {
    return part();
  } catch (const std::exception& error) {
    print_error("kalfem: rank {} of {} cannot go on: {}\n", ranks.rank(), ranks.size(), error.what());
    ranks.abandon(a_bug);
  }
}

}  // namespace

int on_ranks(int argc, char** argv, const std::function<int()>& command) {
  if (launched_rank().ranks == 1) return command();
  distributed::Ranks ranks(argc, argv);
  if (argc > 1 && std::string_view(argv[1]) == "sweep") {
    ranks.share_runs();
    return ranks.works_for_rank_0() ? work(ranks, command) : command();
  }
  if (ranks.works_for_rank_0())
    return work(ranks, [&] {
      ranks.serve();
      return int{done};
    });
  const auto chosen = options();
  ranks.distribute(chosen);
  const int code = command();
  if (code == done && !ranks.were_needed())
    print_error(
        "warning: {} ranks were started, and rank 0 did everything: no matrix has the {} rows from which it is "
        "distributed; start kalfem without mpirun\n",
        ranks.size(), chosen.least_rows);
  return code;
}

}  // namespace kalfem::command
