// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "console.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/watch/playback.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

Playback published(const Study& study) {
  if (study.record) return playback_of(study, study.record->record);
  if (study.simulation) return playback_of(study, run_study(study, "simulate").get<SimulationOutcome>().measurements);
  throw InvalidInput(Issue{{study.file, 1},
                           "the case has neither `record` nor `simulate`",
                           "`kalfem play` publishes a record",
                           "name a case that has one"});
}

}  // namespace

ExitCode play(const PlayArguments& arguments) {
  using Clock = std::chrono::steady_clock;
  std::vector<ScheduledFault> faults;
  for (const auto& text : arguments.faults) faults.push_back(scheduled_fault(text));
  const Study study = load_study(arguments.case_file, changes_of(arguments.changes));
  Playback playback = published(study);
  apply_faults(faults, playback);
  const auto begin = Clock::now();
  for (Eigen::Index first = 0; first < playback.samples(); first += arguments.block) {
    const auto count = std::min<Eigen::Index>(arguments.block, playback.samples() - first);
    if (arguments.speed > 0.0) {  // a block is there once its last sample has been taken
      const double due = static_cast<double>(first + count - 1) / playback.sample_rate / arguments.speed;
      const auto left = [&] { return due - std::chrono::duration<double>(Clock::now() - begin).count(); };
      for (double rest = left(); rest > 0.0; rest = left()) {
        stop_if_asked();
        std::this_thread::sleep_for(std::chrono::duration<double>(std::min(rest, 0.1)));
      }
    }
    stop_if_asked();
    for (const auto& line : playback.lines(first, count)) print("{}\n", line);
    require_output();
    if (reader_has_gone()) return done;
  }
  return done;
}

}  // namespace kalfem::command
