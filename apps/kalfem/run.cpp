// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <filesystem>
#include <optional>

#include "console.hpp"
#include "kalfem/base/output_folder.hpp"
#include "kalfem/report/console_report.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/compared.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/steps/table.hpp"
#include "kalfem/steps/updating/report.hpp"
#include "kalfem/study/live_plan.hpp"
#include "resume_note.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

namespace fs = std::filesystem;

fs::path output_folder(const std::string& case_file, const std::string& asked) {
  return asked.empty() ? fs::path(case_file).replace_extension(".kalfem-out") : fs::path(asked);
}

/// A verb that asks for one step needs its section.
void require_section(const Study& study, std::string_view verb) {
  if (verb == "estimate") require_no_stream(study);
  const RunStep* step = find_step(verb);
  if (!step || step->asked_for(study)) return;
  throw InvalidInput(Issue{{study.file, 1},
                           fmt::format("the case has no `{}`", step->section_name()),
                           fmt::format("`kalfem {}`", step->name),
                           "add the section or use another verb"});
}

/// Every reason for the verdict, worst first.
void print_reasons(const StudyResults& results) {
  if (!results.usable()) print_error("the numbers are not usable: {}\n", results.why_unusable());
  const auto reasons = results.verdict.reasons();
  for (std::size_t i = 1; i < reasons.size() && reasons[i].state == VerdictState::unusable; ++i)
    print_error("and: {}\n", sentence_of(reasons[i]));
  for (const auto& warning : results.warnings) print_error("warning: {}\n", warning);
}

/// The checkpoint from which a run can go on, that of the latest step; nothing if it would begin again.
std::optional<fs::path> checkpoint_in(const fs::path& folder) {
  constexpr std::array<std::string_view, 3> latest_first{"update", "infer", "simulate"};
  for (const auto* step : steps_in_order(latest_first))
    if (!step->checkpoint.file.empty() && fs::exists(folder / step->checkpoint.file))
      return folder / step->checkpoint.file;
  return std::nullopt;
}

/// How the run goes on after it was stopped.
std::string way_on(const fs::path& folder) {
  const auto checkpoint = checkpoint_in(folder);
  if (!checkpoint) return "the same command begins again";
  return "the same command, or kalfem run --resume " + folder.string() + ", goes on from " + checkpoint->string() +
         ", with the same result";
}

/// Progress of a whole job, of which reductions of finite elements come first if there are any.
class RunProgress {
public:
  explicit RunProgress(bool in_lines) : whole_(progress_bar(in_lines)) {}

  Progress of_loading() {
    return [this, part = part_of(whole_, 0.0, loading_share)](std::string_view words, double fraction) {
      reduces_ = true;
      if (part) part(words, fraction);
    };
  }
  [[nodiscard]] Progress of_running() const { return part_of(whole_, reduces_ ? loading_share : 0.0, 1.0); }

private:
  static constexpr double loading_share = 0.2;
  Progress whole_;
  bool reduces_ = false;
};

class Run {
public:
  /// The output folder is taken, and the standard output tried, before anything is computed. `noted`: the run that is
  /// resumed, if one is.
  Run(const RunArguments& arguments, std::string_view verb, const NotedRun* noted = nullptr)
      : arguments_(arguments),
        progress_(arguments.told == Told::report),
        folder_(output_folder(arguments.case_file, arguments.folder)),
        study_(verb == "correlate"
                   ? load_for_correlation(arguments.case_file, arguments.changes, progress_.of_loading())
                   : load_study(arguments.case_file, changes_of(arguments.changes), progress_.of_loading())) {
    if (noted) noted->require_same_case(study_.resolved_case);
    require_section(study_, verb);
    require_result_places(folder_.path(), study_);
    tell("{}\n\n", study_.title.empty() ? fs::path(study_.file).filename().string() : study_.title);
    for (const auto& warning : study_.warnings) print_error("warning: {}\n", warning);
    require_output();
    note_.emplace(folder_.path(), arguments, verb, study_.resolved_case);
    results_ = run_study(
        study_, verb,
        {.progress = progress_.of_running(),
         .folder = folder_.path(),
         .on_updating_step = [&](int number,
                                 const UpdatingStep& step) { tell("{}", console_updating_step(study_, number, step)); },
         .on_first_answer = [&](const StudyResults& results) { write_and_tell_first(results); },
         .keep_finished = true});
    if (results_.interrupted && checkpoint_in(folder_.path())) note_->stay();
  }

  ExitCode write_and_tell() {
    if (results_.interrupted && !results_.has<SimulationOutcome>() && !results_.has<UpdatingOutcome>() &&
        !results_.has<EstimationOutcome>())
      throw Interrupted();
    const ResultSet set = write_result_set(folder_, study_, results_, watch_);
    if (arguments_.told == Told::report) print_report(console_report(study_, results_));
    if (arguments_.verbose) print_report(console_details(study_, results_));
    tell_files(set);
    if (arguments_.told == Told::json)
      print_text(set.summary);
    else
      print_verdict(has_verdict(results_) ? std::optional(results_.verdict.state()) : std::nullopt,
                    why_no_verdict(results_));
    print_reasons(results_);
    require_output();
    if (results_.interrupted) {
      print_error("stopped; {}\n", way_on(folder_.path()));
      return interrupted;
    }
    const bool suspicious = results_.verdict.state() == VerdictState::suspicious;
    return results_.usable() && !(arguments_.strict && suspicious) ? done : not_usable;
  }

private:
  template <class... Values>
  void tell(fmt::format_string<Values...> format, Values&&... values) const {
    if (arguments_.told == Told::report) command::print(format, std::forward<Values>(values)...);
  }

  void write_and_tell_first(const StudyResults& results) {
    write_first_answer(folder_, study_, results, watch_);
    if (is_read_on_terminal()) tell("{}\n", console_first_answer(study_, results.get<EstimationOutcome>()));
  }

  void tell_files(const ResultSet& set) const {
    tell("Results in {}: {}\n", folder_.path().string(), listed(set.files));
    if (!set.removed.empty()) tell("Removed from there (results of an earlier run): {}\n", listed(set.removed));
    if (results_.identified && !results_.identified->notes.empty())
      tell("case.identified.yaml: {} of its values have no place in `substructures`; its first lines name them\n",
           results_.identified->notes.size());
  }

  const RunArguments& arguments_;
  Stopwatch watch_;
  RunProgress progress_;
  OutputFolder folder_;
  Study study_;
  std::optional<ResumeNote> note_;  ///< goes before the folder does
  StudyResults results_;
};

}  // namespace

std::vector<CaseChange> changes_of(const std::vector<std::string>& texts) {
  std::vector<CaseChange> changes;
  IssueList issues;
  for (const auto& text : texts) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      issues.add({}, "--set " + text + ": it is no KEY=VALUE", "",
                 "write for example --set simulate.duration=4s, or KEY= to remove a key");
    else if (equals + 1 == text.size())
      changes.push_back({text.substr(0, equals), std::nullopt});
    else
      changes.push_back({text.substr(0, equals), text.substr(equals + 1)});
  }
  issues.raise();
  return changes;
}

ExitCode run(const RunArguments& arguments, std::string_view verb) { return Run(arguments, verb).write_and_tell(); }

ExitCode resume(const std::string& folder, const RunArguments& arguments) {
  NotedRun noted = read_resume_note(folder);
  noted.arguments.told = arguments.told;
  noted.arguments.verbose = arguments.verbose;
  noted.arguments.strict = noted.arguments.strict || arguments.strict;
  return Run(noted.arguments, noted.verb, &noted).write_and_tell();
}

}  // namespace kalfem::command
