// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "console.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/report/finished/sweep_report.hpp"
#include "sweep_on_ranks.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

namespace fs = std::filesystem;

/// The parts of a text between commas that stand outside brackets and quotes.
std::vector<std::string> split_at_commas(const std::string& text) {
  std::vector<std::string> parts(1);
  int depth = 0;
  char quote = 0;
  for (const char c : text) {
    if (quote != 0)
      quote = c == quote ? 0 : quote;
    else if (c == '"' || c == '\'')
      quote = c;
    else if (c == '[' || c == '{')
      ++depth;
    else if (c == ']' || c == '}')
      --depth;
    if (c == ',' && depth == 0 && quote == 0)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

std::vector<SweepAxis> axes_of(const std::vector<std::string>& texts) {
  std::vector<SweepAxis> axes;
  IssueList issues;
  for (const auto& text : texts) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
      issues.add({}, "--grid " + text + ": it is no KEY=VALUE,VALUE,...", "",
                 "write for example --grid estimate.process_noise.acceleration=0.001,0.01,0.1");
    else
      axes.push_back({text.substr(0, equals), split_at_commas(text.substr(equals + 1))});
  }
  issues.raise();
  return axes;
}

fs::path folder_of(const SweepArguments& arguments) {
  return arguments.folder.empty() ? fs::path(arguments.case_file).replace_extension(".kalfem-sweep")
                                  : fs::path(arguments.folder);
}

}  // namespace

ExitCode sweep(const SweepArguments& arguments) {
  const fs::path place = folder_of(arguments);
  std::optional<SweepFolder> own_folder;
  const auto made = sweep_of_all_ranks([&] {
    auto sweep = std::make_unique<CaseSweep>(
        SweepPlan{arguments.case_file, changes_of(arguments.changes), axes_of(arguments.grid), arguments.seeds});
    if (!works_for_rank_0()) own_folder.emplace(place, *sweep);
    return sweep;
  });
  if (!made) return mend_the_input;
  CaseSweep& sweep = *made;
  if (works_for_rank_0()) {
    make_runs_for_rank_0(sweep);
    return done;
  }
  SweepFolder& folder = *own_folder;
  for (const int line : folder.damaged_lines())
    print_error("{}:{}: the line is not what was written: the run is made again\n", (place / "runs.jsonl").string(),
                line);
  if (!folder.known().empty())
    print("{} of {} runs are known from {}\n", folder.known().size(), sweep.plan().size(),
          (place / "runs.jsonl").string());
  const auto runs = run_on_ranks(sweep, {.threads = arguments.threads,
                                         .known = folder.known(),
                                         .on_run = [&](const SweepRun& run) { folder.add(run); },
                                         .progress = progress_bar(true)});
  const auto finished = finished_runs(runs);
  folder.finish(finished);
  for (const auto& table : sweep_tables(sweep.plan(), finished))
    print_report(table.title + "\n" + to_text(table) + "\n");
  print("Results in {}: runs.jsonl, sweep.csv, sweep.h5\n", place.string());
  std::string told;
  for (const auto& run : runs)
    if (!run.refused.empty() && run.refused != std::exchange(told, run.refused))
      print_error("run {}: {}\n", run.number + 1, run.refused);
  const bool usable = std::ranges::any_of(finished, [](const auto& run) { return run.found && run.found->usable; });
  return usable ? done : not_usable;
}

}  // namespace kalfem::command
