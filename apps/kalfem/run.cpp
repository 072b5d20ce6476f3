#include <filesystem>

#include "console.hpp"
#include "kalfem/casefile/case_reader.hpp"
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
  print("{}\n\n", study.given.title.empty() ? fs::path(study.file).filename().string() : study.given.title);
  for (const auto& warning : study.warnings) print_error("warning: {}\n", warning);
  require_output();
}

void print_files(const fs::path& folder, const ResultSet& set) {
  print("Results in {}: {}\n", folder.string(), listed(set.files));
  if (!set.removed.empty()) print("Removed there, as of a former run: {}\n", listed(set.removed));
}

}  // namespace

/// The output folder is taken, and the standard output tried, before anything is computed.
ExitCode run(const std::string& case_file, Stage last, const std::string& folder_name, bool must_update) {
  const Stopwatch watch;
  auto given = read_case(case_file, description::case_form());
  OutputFolder folder(output_folder(case_file, folder_name));
  const Study study = make_study(std::move(given), case_file);
  if (must_update && !study.updating)
    throw InvalidInput(
        {{case_file, 0}, "the case has no `update`", "there is nothing to refine", "add it, or use another verb"});
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
  if (!results.usable()) print_error("the numbers are not usable: {}\n", results.failure);
  require_output();
  return results.usable() ? done : not_usable;
}

}  // namespace kalfem::command
