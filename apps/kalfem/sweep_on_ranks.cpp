// SPDX-License-Identifier: Apache-2.0
#include <mpi.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "console.hpp"
#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/parallel.hpp"
#include "ranks.hpp"
#include "sweep_on_ranks.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

constexpr int no_more = -1;
constexpr auto pause = std::chrono::milliseconds(1);

int rank_of_process() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

int rank_count() {
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  return ranks;
}

void send_text(const std::string& text, int to) {
  MPI_Send(text.data(), static_cast<int>(text.size()), MPI_CHAR, to, 0, MPI_COMM_WORLD);
}

std::string receive_text(MPI_Status status) {
  int length = 0;
  MPI_Get_count(&status, MPI_CHAR, &length);
  std::string text(static_cast<std::size_t>(length), ' ');
  MPI_Recv(text.data(), length, MPI_CHAR, status.MPI_SOURCE, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return text;
}

std::string receive_text(int from) {
  MPI_Status status;
  MPI_Probe(from, 0, MPI_COMM_WORLD, &status);
  return receive_text(status);
}

/// The runs that are still to be made, in their order, for rank 0 and its workers. Used by two threads of rank 0.
class OpenRuns {
public:
  OpenRuns(std::size_t count, const std::vector<SweepRun>& known) : count_(count) {
    for (const auto& run : known) known_.insert(run.number);
  }

  /// Nothing where all are given out.
  std::optional<std::size_t> next() {
    const std::scoped_lock lock(guard_);
    while (next_ < count_ && known_.contains(next_)) ++next_;
    return next_ < count_ ? std::optional(next_++) : std::nullopt;
  }

private:
  std::size_t count_, next_ = 0;
  std::set<std::size_t> known_;
  std::mutex guard_;
};

/// Rank 0's own share, made beside its talk with the workers.
class OwnShare {
public:
  OwnShare(CaseSweep& sweep, OpenRuns& open)
      : thread_([&] {
          const OneCore one;
          try {
            while (const auto number = stop_ ? std::nullopt : open.next()) {
              auto run = sweep.run_one(*number);
              const std::scoped_lock lock(guard_);
              finished_.push_back(std::move(run));
            }
          } catch (...) {
            thrown_ = std::current_exception();
          }
          through_ = true;
        }) {}

  ~OwnShare() { stop_ = true; }

  /// Throws what a run threw.
  [[nodiscard]] bool through() const {
    if (through_ && thrown_) std::rethrow_exception(thrown_);
    return through_;
  }
  std::vector<SweepRun> taken() {
    const std::scoped_lock lock(guard_);
    return std::exchange(finished_, {});
  }

private:
  std::atomic<bool> stop_ = false, through_ = false;
  std::exception_ptr thrown_;  ///< set before through_
  std::mutex guard_;
  std::vector<SweepRun> finished_;
  std::jthread thread_;
};

/// Ends all ranks, as the workers wait for an answer that will not come.
[[noreturn]] void end_early(const std::string& why, int code) {
  print_error("kalfem: the sweep ends before all runs are made: {}\nThe same command goes on with the others.\n", why);
  MPI_Abort(MPI_COMM_WORLD, code);
  std::abort();
}

}  // namespace

// Each rank reads the case by itself. Before anything is run, rank 0 hears from all others whether theirs is the same:
// a file may be missing on another computer.
std::unique_ptr<CaseSweep> sweep_of_all_ranks(const std::function<std::unique_ptr<CaseSweep>()>& make) {
  if (launched_rank().ranks == 1) return make();
  std::unique_ptr<CaseSweep> sweep;
  std::exception_ptr refusal;
  std::string word;
  try {
    sweep = make();
    word = sweep->identity();
  } catch (const std::exception& error) {
    refusal = std::current_exception();
    word = error.what();
  }
  if (rank_of_process() > 0) {
    send_text(word, 0);
    int go_on = 0;
    MPI_Bcast(&go_on, 1, MPI_INT, 0, MPI_COMM_WORLD);
    return go_on != 0 ? std::move(sweep) : nullptr;
  }
  for (int rank = 1; rank < rank_count(); ++rank)
    if (const auto other = receive_text(rank); !refusal && other != word)
      refusal = std::make_exception_ptr(
          InvalidInput("rank " + std::to_string(rank) + " of " + std::to_string(rank_count()) +
                           " has another sweep than rank 0: " + other,
                       "each rank reads the case and its files by itself",
                       "make the same files and the same version of kalfem available on all computers"));
  int go_on = refusal ? 0 : 1;
  MPI_Bcast(&go_on, 1, MPI_INT, 0, MPI_COMM_WORLD);
  if (refusal) std::rethrow_exception(refusal);
  return sweep;
}

bool works_for_rank_0() { return launched_rank().rank > 0; }

void make_runs_for_rank_0(CaseSweep& sweep) {
  const OneCore one;
  for (std::string made;;) {
    send_text(made, 0);
    long long number = no_more;
    MPI_Recv(&number, 1, MPI_LONG_LONG, 0, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    if (number == no_more) return;
    made = to_line(sweep.run_one(static_cast<std::size_t>(number)));
  }
}

std::vector<SweepRun> run_on_ranks(CaseSweep& sweep, const SweepOptions& options) {
  if (launched_rank().ranks == 1) return sweep.run(options);
  std::vector<SweepRun> runs = options.known;
  const std::size_t count = sweep.plan().size();
  const auto take = [&](SweepRun run) {
    if (options.on_run) options.on_run(run);
    runs.push_back(std::move(run));
    if (options.progress)
      options.progress("run " + std::to_string(runs.size()) + " of " + std::to_string(count),
                       static_cast<double>(runs.size()) / static_cast<double>(count));
  };
  try {
    OpenRuns open(count, options.known);
    OwnShare own(sweep, open);
    int workers = rank_count() - 1;
    while (workers > 0 || !own.through()) {
      stop_if_asked();
      for (auto& run : own.taken()) take(std::move(run));
      int waits = 0;
      MPI_Status status;
      MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &waits, &status);
      if (waits == 0) {
        std::this_thread::sleep_for(pause);
        continue;
      }
      if (const auto run = sweep_run_of(receive_text(status))) take(*run);  // the first word of a worker holds none
      const auto next = open.next();
      const long long number = next ? static_cast<long long>(*next) : no_more;
      workers -= next ? 0 : 1;
      MPI_Send(&number, 1, MPI_LONG_LONG, status.MPI_SOURCE, 0, MPI_COMM_WORLD);
    }
    for (auto& run : own.taken()) take(std::move(run));
  } catch (const Interrupted&) {
    end_early("it was stopped", interrupted);
  } catch (const std::exception& error) {
    end_early(error.what(), a_bug);
  }
  std::ranges::sort(runs, {}, &SweepRun::number);
  return runs;
}

}  // namespace kalfem::command
