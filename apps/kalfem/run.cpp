#include <filesystem>

#include "console.hpp"
#include "kalfem/base/output_folder.hpp"
#include "kalfem/pipeline/likelihood_checkpoint.hpp"
#include "kalfem/pipeline/updating_checkpoint.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/report/tables.hpp"
#include "kalfem/report/updating_tables.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

namespace fs = std::filesystem;

fs::path output_folder(const std::string& case_file, const std::string& asked) {
  return asked.empty() ? fs::path(case_file).replace_extension(".kalfem-out") : fs::path(asked);
}

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

/// A verb that asks for one step needs its section.
void require_section(const Study& study, Step asked) {
  const auto require = [&](bool present, const char* section) {
    if (!present)
      throw InvalidInput(Issue{{study.file, 1},
                               "the case has no `" + std::string(section) + "`",
                               "`kalfem " + std::string(section) + "`",
                               "add the section or use another verb"});
  };
  if (asked == Step::simulate) require(study.simulation.has_value(), "simulate");
  if (asked == Step::estimate) require(study.problem != nullptr, "estimate");
  if (asked == Step::predict) require(study.prediction.has_value() || !study.modifications.empty(), "predict");
  if (asked == Step::update) require(study.updating.has_value(), "update");
  if (asked == Step::infer) require(study.inference.has_value(), "infer");
  if (asked == Step::place) require(study.placement.has_value(), "place");
  if (asked == Step::statics) require(study.statics.has_value(), "static");
}

/// Every reason for the verdict, worst first.
void print_reasons(const StudyResults& results) {
  if (!results.usable()) print_error("the numbers are not usable: {}\n", results.why_unusable());
  const auto reasons = results.verdict.reasons();
  for (std::size_t i = 1; i < reasons.size() && reasons[i].state == VerdictState::unusable; ++i)
    print_error("and: {}\n", sentence_of(reasons[i]));
  for (const auto& warning : results.warnings) print_error("warning: {}\n", warning);
}

/// How the same command goes on after it was stopped.
std::string way_on(const fs::path& folder) {
  for (const char* checkpoint : {checkpoint_name, likelihoods_name})
    if (fs::exists(folder / checkpoint))
      return "the same command goes on from " + (folder / checkpoint).string() + ", with the same result";
  return "the same command begins again";
}

class Run {
public:
  /// The output folder is taken, and the standard output tried, before anything is computed.
  Run(const RunArguments& arguments, Step last)
      : arguments_(arguments),
        folder_(output_folder(arguments.case_file, arguments.folder)),
        study_(load_study(arguments.case_file, changes_of(arguments.changes))) {
    require_section(study_, last);
    require_result_places(folder_.path(), study_);
    tell("{}\n\n", study_.title.empty() ? fs::path(study_.file).filename().string() : study_.title);
    for (const auto& warning : study_.warnings) print_error("warning: {}\n", warning);
    require_output();
    results_ = run_study(
        study_, last,
        {.progress = progress_bar(arguments.told == Told::report),
         .folder = folder_.path(),
         .on_updating_step = [&](int number,
                                 const UpdatingStep& step) { tell("{}", console_updating_step(study_, number, step)); },
         .keep_finished = true});
  }

  ExitCode write_and_tell() {
    if (results_.interrupted && !results_.simulation && !results_.updating && !results_.estimation) throw Interrupted();
    const ResultSet set = write_result_set(folder_, study_, results_, watch_);
    tell("{}", console_report(study_, results_));
    tell_files(set);
    if (arguments_.told == Told::json)
      print_text(set.summary);
    else
      print("Verdict: {}\n", to_string(results_.verdict.state()));
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

  void tell_files(const ResultSet& set) const {
    tell("Results in {}: {}\n", folder_.path().string(), listed(set.files));
    if (!set.removed.empty()) tell("Removed from there (results of an earlier run): {}\n", listed(set.removed));
    if (results_.identified && !results_.identified->notes.empty())
      tell("case.identified.yaml: {} of its values have no place in `substructures`; its first lines name them\n",
           results_.identified->notes.size());
  }

  const RunArguments& arguments_;
  Stopwatch watch_;
  OutputFolder folder_;
  Study study_;
  StudyResults results_;
};

}  // namespace

ExitCode run(const RunArguments& arguments, Step last) { return Run(arguments, last).write_and_tell(); }

}  // namespace kalfem::command
