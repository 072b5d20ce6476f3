#include <filesystem>

#include "console.hpp"
#include "kalfem/base/output_folder.hpp"
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

void print_heading(const Study& study) {
  print("{}\n\n", study.title.empty() ? fs::path(study.file).filename().string() : study.title);
  for (const auto& warning : study.warnings) print_error("warning: {}\n", warning);
  require_output();
}

void print_files(const fs::path& folder, const ResultSet& set) {
  print("Results in {}: {}\n", folder.string(), listed(set.files));
  if (!set.removed.empty()) print("Removed from there (results of an earlier run): {}\n", listed(set.removed));
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
}

/// The state, and every reason for it, worst first.
void print_verdict(const StudyResults& results) {
  print("Verdict: {}\n", to_string(results.verdict.state()));
  if (!results.usable()) print_error("the numbers are not usable: {}\n", results.why_unusable());
  const auto reasons = results.verdict.reasons();
  for (std::size_t i = 1; i < reasons.size() && reasons[i].state == VerdictState::unusable; ++i)
    print_error("and: {}\n", sentence_of(reasons[i]));
  for (const auto& warning : results.warnings) print_error("warning: {}\n", warning);
}

}  // namespace

/// The output folder is taken, and the standard output tried, before anything is computed.
ExitCode run(const std::string& case_file, Step last, const std::string& folder_name, bool strict) {
  const Stopwatch watch;
  OutputFolder folder(output_folder(case_file, folder_name));
  const Study study = load_study(case_file);
  require_section(study, last);
  require_result_places(folder.path(), study);
  print_heading(study);
  const StudyResults results = run_study(study, last,
                                         {.progress = progress_bar(),
                                          .folder = folder.path(),
                                          .on_updating_step = [&](int number, const UpdatingStep& step) {
                                            print_text(console_updating_step(study, number, step));
                                          }});
  const ResultSet set = write_result_set(folder, study, results, watch);
  print_text(console_report(study, results));
  print_files(folder.path(), set);
  if (results.identified && !results.identified->notes.empty())
    print("case.identified.yaml: {} of its values have no place in `substructures`; its first lines name them\n",
          results.identified->notes.size());
  print_verdict(results);
  require_output();
  const bool suspicious = results.verdict.state() == VerdictState::suspicious;
  return results.usable() && !(strict && suspicious) ? done : not_usable;
}

}  // namespace kalfem::command
