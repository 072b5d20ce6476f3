#include <fmt/format.h>

#include <filesystem>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/casefile/description_form.hpp"
#include "kalfem/report/field_files.hpp"
#include "kalfem/report/results_file.hpp"
#include "kalfem/report/study_page.hpp"
#include "kalfem/report/summary.hpp"
#include "kalfem/report/superelement_files.hpp"
#include "kalfem/report/tables.hpp"
#include "kalfem/report/updating_tables.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

namespace fs = std::filesystem;

fs::path output_folder(const std::string& case_file, const std::string& asked) {
  const fs::path folder = asked.empty() ? fs::path(case_file).replace_extension(".kalfem-out") : fs::path(asked);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    throw InvalidInput("the folder '" + folder.string() + "' cannot be made", error.message(),
                       "give another one with --out");
  return folder;
}

/// Removes the temporary file unless it was renamed to its place.
class TemporaryFile {
public:
  explicit TemporaryFile(fs::path place) : place_(std::move(place)), path_(place_.string() + ".partial") {}
  ~TemporaryFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  [[nodiscard]] std::string path() const { return path_.string(); }
  void move_to_place() const {
    std::error_code ignored;
    if (fs::exists(path_, ignored)) fs::rename(path_, place_);
  }

private:
  fs::path place_, path_;
};

void write_all(const fs::path& folder, const Study& study, const StudyResults& results) {
  const TemporaryFile series(folder / "results.h5");
  write_results(series.path(), study, results);
  series.move_to_place();
  write_fields(folder.string(), study, results);
  write_superelements(folder, study);
  write_file_atomically(folder / "case.resolved.yaml", to_yaml(*description::case_form().write(study.given)));
  write_file_atomically(folder / "report.html", render_html(make_page(study, results)));
  write_file_atomically(folder / "summary.json", summarise(study, results).dump(2) + "\n");
}

}  // namespace

ExitCode run(const std::string& case_file, Stage last, const std::string& folder_name, bool must_update) {
  const Study study = load_study(case_file);
  if (must_update && !study.updating)
    throw InvalidInput(
        {{case_file, 0}, "the case has no `update`", "there is nothing to refine", "add it, or use another verb"});
  const fs::path folder = output_folder(case_file, folder_name);
  for (const auto& warning : study.warnings) fmt::print(stderr, "warning: {}\n", warning);
  const StudyResults results = run_study(
      study, last,
      {.progress = progress_bar(), .folder = folder, .on_updating_step = [&](int number, const UpdatingStep& step) {
         fmt::print("{}", console_updating_step(study, number, step));
         std::fflush(stdout);
       }});
  write_all(folder, study, results);
  fmt::print("{}", console_report(study, results));
  fmt::print("Results in {}: report.html, summary.json, results.h5, case.resolved.yaml\n", folder.string());
  if (results.usable()) return done;
  fmt::print(stderr, "the numbers are not usable: {}\n", results.failure);
  return not_usable;
}

}  // namespace kalfem::command
