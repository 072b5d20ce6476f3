// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/result_set.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/steps/table.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

using Json = nlohmann::ordered_json;
using Names = std::vector<std::string>;

/// In the order in which they are of interest.
constexpr std::array main_files{"report.html",        "summary.json",         "results.h5",
                                "case.resolved.yaml", "case.identified.yaml", "case.proposed.yaml"};

bool is_main_file(const std::string& name) { return std::ranges::find(main_files, name) != main_files.end(); }

/// Whether a run may have written a file of that name beside the main ones. Guards what is removed: a summary
/// may come from anywhere.
bool may_be_written(const std::string& name) {
  static const std::regex pattern(
      "[A-Za-z0-9_-]+(_(modes|static)[.]vtu|_reduced(_[KMC])?[.](mtx|dmig|op4|h5|dof)|"
      "_(simulated|estimated)([.]pvd|/[0-9]+[.]vtu))|"
      "frf_(full|reduced)_(displacement|velocity|acceleration)_[A-Za-z0-9_.-]+[.]csv");
  constexpr std::size_t longest = 200;  // longer than any; regular expressions are recursive
  return name.size() <= longest && std::regex_match(name, pattern);
}

std::optional<Json> summary_in(const fs::path& folder) {
  Json summary = Json::parse(bytes_if_readable(folder / "summary.json"), nullptr, false);
  return summary.is_object() ? std::optional(std::move(summary)) : std::nullopt;
}

/// Files of the substructures in a summary that does not list its files, as that of an earlier version.
Names unlisted_files(const fs::path& folder, const Json& summary) {
  Names names;
  const Json model = summary.value("model", Json());
  const Json parts = model.is_object() ? model.value("substructures", Json()) : Json();
  if (!parts.is_object()) return names;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().lexically_relative(folder).string();
    const bool known = std::ranges::any_of(
        parts.items(), [&](const auto& part) { return name.starts_with(part.key() + "_") && may_be_written(name); });
    if (known) names.push_back(name);
  }
  return names;
}

/// What the former run left in the folder.
Names former_files(const fs::path& folder) {
  Names names(main_files.begin(), main_files.end());
  const auto summary = summary_in(folder);
  if (!summary) return names;
  if (const auto list = summary->find("files"); list != summary->end() && list->is_array()) {
    for (const auto& name : *list)
      if (name.is_string() && may_be_written(name.get<std::string>())) names.push_back(name.get<std::string>());
    return names;
  }
  const Names unlisted = unlisted_files(folder, *summary);
  names.insert(names.end(), unlisted.begin(), unlisted.end());
  return names;
}

Names files_in(const fs::path& folder) {
  Names names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) names.push_back(entry.path().lexically_relative(folder).string());
  std::ranges::sort(names);
  return names;
}

std::string resolved_case(const Study& study, const std::string& run) {
  return "# run " + run + "\n" + study.resolved_case;
}

std::string identified_case(const IdentifiedCase& identified, const std::string& run) {
  return "# run " + run + ", with the values that it found in the places of its parameters\n" + identified.yaml;
}

std::string proposed_case(const ProposedCase& proposed, const std::string& run) {
  return fmt::format("# run {}, with what its record asks for:\n# {}\n{}", run, fmt::join(proposed.edits, "\n# "),
                     proposed.yaml);
}

/// Writes the case as it ran, and with what it found.
void write_cases(const fs::path& staging, const Study& study, const StudyResults& results, const std::string& run) {
  write_file_atomically(staging / "case.resolved.yaml", resolved_case(study, run));
  if (results.identified)
    write_file_atomically(staging / "case.identified.yaml", identified_case(*results.identified, run));
  if (results.proposed) write_file_atomically(staging / "case.proposed.yaml", proposed_case(*results.proposed, run));
}

/// Writes summary.json beside the other files of the staging folder; their names, and the summary.
ResultSet write_summary(const fs::path& staging, Json summary, const Stopwatch& run) {
  Names files = files_in(staging);
  files.insert(std::ranges::lower_bound(files, "summary.json"), "summary.json");
  std::string text = summary_text(std::move(summary), files, run.seconds());
  write_file_atomically(staging / "summary.json", text);
  return {.files = std::move(files), .removed = {}, .summary = std::move(text)};
}

/// Writes all files of the run into the staging folder; their names, and the summary.
ResultSet write_files(const fs::path& staging, const Study& study, const StudyResults& results, const Stopwatch& run) {
  const Stopwatch writing;
  Json summary = summarise(study, results);
  const std::string identity = summary["run"];
  write_results((staging / "results.h5").string(), study, results, identity);
  for (const auto* step : steps_that_ran(results))
    if (step->write) step->write(staging, study, results);
  write_superelements(staging, study);
  write_cases(staging, study, results, identity);
  Page page = make_page(study, results);
  page.run = identity;
  for (const auto& file : files_in(staging))
    if (file.find('/') == std::string::npos) page.files.push_back(file);
  page.files.emplace_back("summary.json");
  write_file_atomically(staging / "report.html", render_html(page));
  summary["timing"]["write_s"] = writing.seconds();
  return write_summary(staging, std::move(summary), run);
}

/// The user knows a file by the name that it would have got, not by that in the staging folder.
WriteFailure with_final_names(const WriteFailure& failure, const OutputFolder& folder) {
  auto issues = failure.issues();
  for (auto& issue : issues)
    if (const auto at = issue.what.find(folder.staging().string()); at != std::string::npos)
      issue.what.replace(at, folder.staging().string().size(), folder.path().string());
  return WriteFailure(std::move(issues));
}

ResultSet switch_to_files(OutputFolder& folder, const Names& files, const StudyResults& results) {
  Names former = former_files(folder.path());
  ResultSet set;
  for (const auto& name : former)
    if (!std::ranges::binary_search(files, name) && fs::is_regular_file(folder.path() / name))
      set.removed.push_back(name);
  std::ranges::sort(set.removed);
  for (const auto* step : steps_that_ran(results))
    if (!step->checkpoint.file.empty() && !(step->checkpoint.outlives_step && results.interrupted))
      former.emplace_back(step->checkpoint.file);
  set.files = folder.replace(former);
  return set;
}

}  // namespace

std::string summary_text(Json summary, const Names& files, double total_seconds) {
  summary["files"] = files;
  summary["timing"]["total_s"] = total_seconds;
  return with_unicode_escapes(summary.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n";
}

void write_first_answer(OutputFolder& folder, const Study& study, const StudyResults& results, const Stopwatch& run) {
  const auto stands = [&](const auto& name) { return fs::exists(folder.path() / name); };
  if (std::ranges::any_of(former_files(folder.path()), stands)) return;
  try {
    Json summary = summarise(study, results);
    write_cases(folder.staging(), study, results, summary["run"]);
    write_summary(folder.staging(), std::move(summary), run);
    folder.replace({});
  } catch (const WriteFailure& failure) {
    throw with_final_names(failure, folder);
  }
}

ResultSet write_result_set(OutputFolder& folder, const Study& study, const StudyResults& results,
                           const Stopwatch& run) {
  try {
    ResultSet written = write_files(folder.staging(), study, results, run);
    ResultSet set = switch_to_files(folder, written.files, results);
    set.summary = std::move(written.summary);
    return set;
  } catch (const WriteFailure& failure) {
    throw with_final_names(failure, folder);
  }
}

void require_result_places(const fs::path& folder, const Study& study) {
  Names names(main_files.begin(), main_files.end());
  for (const auto* step : steps_of(every_step, study)) {
    if (!step->checkpoint.file.empty()) names.emplace_back(step->checkpoint.file);
    if (step->files) std::ranges::move(step->files(study), std::back_inserter(names));
  }
  std::error_code ignored;
  for (const auto& name : names)
    if (fs::is_directory(folder / name, ignored)) fail_to_write(folder / name, EISDIR);
}

std::string listed(const Names& names) {
  Names items;
  for (const auto* name : main_files)
    if (std::ranges::find(names, name) != names.end()) items.emplace_back(name);
  std::map<std::string, int> folders;
  for (const auto& name : names)
    if (const auto slash = name.find('/'); slash != std::string::npos)
      ++folders[name.substr(0, slash)];
    else if (!is_main_file(name))
      items.push_back(name);
  for (const auto& [name, count] : folders) items.push_back(fmt::format("{}/ ({} files)", name, count));
  return fmt::format("{}", fmt::join(items, ", "));
}

}  // namespace kalfem
