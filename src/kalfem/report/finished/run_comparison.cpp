// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/finished/run_comparison.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "kalfem/base/regular_file.hpp"
#include "kalfem/report/finished/run_series.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> labels_of(const std::vector<FinishedRun>& runs) {
  std::vector<std::string> labels;
  for (const auto& run : runs) labels.push_back(run.label());
  const auto names = labels;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (std::ranges::count(names, names[i]) > 1) labels[i] = runs[i].folder.lexically_normal().string();
  for (std::size_t i = 1; i < labels.size(); ++i)
    if (std::find(labels.begin(), labels.begin() + static_cast<std::ptrdiff_t>(i), labels[i]) !=
        labels.begin() + static_cast<std::ptrdiff_t>(i))
      labels[i] += fmt::format(" ({})", i + 1);
  return labels;
}

/// The sections of the case that the run used, each with its text. A section starts at a line without indent.
std::map<std::string, std::string> sections_of(const FinishedRun& run) {
  std::map<std::string, std::string> sections;
  std::istringstream stream(bytes_if_readable(run.folder / "case.resolved.yaml"));
  std::string section;
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with('#') || line.empty()) continue;
    if (line.front() != ' ' && line.front() != '-') section = line.substr(0, line.find(':'));
    sections[section] += line + "\n";
  }
  return sections;
}

std::string differences_of(const std::vector<FinishedRun>& runs) {
  const auto first = sections_of(runs.front());
  std::vector<std::string> differing;
  const auto note = [&](const std::string& section) {
    if (section != "title" && std::ranges::find(differing, section) == differing.end()) differing.push_back(section);
  };
  for (std::size_t i = 1; i < runs.size(); ++i) {
    const auto other = sections_of(runs[i]);
    for (const auto& [section, text] : first)
      if (!other.contains(section) || other.at(section) != text) note(section);
    for (const auto& [section, text] : other)
      if (!first.contains(section)) note(section);
  }
  return differing.empty() ? "" : fmt::format("The cases differ in: {}.", fmt::join(differing, ", "));
}

/// Whether a run took other numbers of a sensor: more than offsets, gains and delays that two runs find alike leave.
bool differ(const Eigen::VectorXd& mine, const Eigen::VectorXd& theirs) {
  constexpr double alike = 1e-3;  ///< rms of the difference over that of the record
  if (mine.size() != theirs.size()) return true;
  if ((mine.array().isFinite() != theirs.array().isFinite()).any()) return true;
  const auto there = mine.array().isFinite();
  const double difference = there.select(mine - theirs, 0.0).norm();
  return difference > alike * there.select(mine, 0.0).norm();
}

/// Sensors of both runs, parted by whether their records differ.
struct CommonSensors {
  std::vector<std::string> same, different;
};

CommonSensors common_sensors(const RunSeries& first, const RunSeries& other) {
  CommonSensors sensors;
  for (const auto& path : first.below("/measurements")) {
    const auto mine = first.read(path), theirs = other.read(path);
    if (!theirs) continue;
    (differ(*mine, *theirs) ? sensors.different : sensors.same).push_back(path.substr(path.rfind('/') + 1));
  }
  return sensors;
}

std::vector<std::string> parameters_with_other_truth(const FinishedRun& first, const FinishedRun& other) {
  std::vector<std::string> names;
  const auto theirs = other.parameters();
  for (const auto& mine : first.parameters()) {
    const auto found = std::ranges::find(theirs, mine.name, &FoundParameter::name);
    if (found != theirs.end() && mine.truth && found->truth && *mine.truth != *found->truth) names.push_back(mine.name);
  }
  return names;
}

/// Members of a population with one record are one member counted twice.
std::vector<std::string> warnings_of_members(const std::vector<FinishedRun>& runs,
                                             const std::vector<std::string>& labels) {
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < runs.size(); ++i)
    for (std::size_t j = i + 1; j < runs.size(); ++j)
      if (const auto same = common_sensors(RunSeries(runs[i]), RunSeries(runs[j])).same; !same.empty())
        warnings.push_back(
            fmt::format("'{}' and '{}' rest on the same records of {}: members of a population need data "
                        "of their own, or its spread comes out too small",
                        labels[i], labels[j], fmt::join(same, ", ")));
  return warnings;
}

std::vector<std::string> warnings_of_answers(const std::vector<FinishedRun>& runs,
                                             const std::vector<std::string>& labels) {
  std::vector<std::string> warnings;
  const RunSeries first(runs.front());
  for (std::size_t i = 1; i < runs.size(); ++i) {
    if (const auto sensors = common_sensors(first, RunSeries(runs[i])).different; !sensors.empty())
      warnings.push_back(fmt::format("'{}' and '{}' do not rest on the same data: the records of {} differ",
                                     labels.front(), labels[i], fmt::join(sensors, ", ")));
    if (const auto names = parameters_with_other_truth(runs.front(), runs[i]); !names.empty())
      warnings.push_back(
          fmt::format("'{}' and '{}' have other true values of {}", labels.front(), labels[i], fmt::join(names, ", ")));
  }
  return warnings;
}

}  // namespace

RunComparison compare_runs(const std::vector<fs::path>& folders, RunsAre are) {
  if (folders.size() < 2)
    throw InvalidInput(fmt::format("compare: {} given", folders.empty() ? "no folder" : "one folder"),
                       "a comparison needs at least two",
                       "give the folders of two or more runs; `kalfem report` shows a single one");
  RunComparison comparison{.are = are, .runs = {}, .labels = {}, .differences = {}, .warnings = {}};
  IssueList issues;
  for (const auto& folder : folders) try {
      comparison.runs.push_back(read_finished_run(folder));
    } catch (const InvalidInput& error) {
      issues.add(error, {folder.string(), 0});
    }
  issues.raise();
  comparison.labels = labels_of(comparison.runs);
  comparison.differences = differences_of(comparison.runs);
  comparison.warnings = are == RunsAre::members ? warnings_of_members(comparison.runs, comparison.labels)
                                                : warnings_of_answers(comparison.runs, comparison.labels);
  return comparison;
}

std::optional<double> joint_deviations(const FoundParameter& a, const FoundParameter& b) {
  const auto of_a = a.deviation(), of_b = b.deviation();
  if (!a.estimate || !b.estimate || !of_a || !of_b) return std::nullopt;
  const double joint = std::hypot(*of_a, *of_b);
  return joint > 0.0 ? std::optional((*a.estimate - *b.estimate) / joint) : std::nullopt;
}

std::vector<ComparedParameter> compared_parameters(const RunComparison& comparison) {
  std::vector<ComparedParameter> all;
  for (std::size_t i = 0; i < comparison.runs.size(); ++i)
    for (const auto& parameter : comparison.runs[i].parameters()) {
      auto at = std::ranges::find(all, parameter.name, &ComparedParameter::name);
      if (at == all.end())
        at = all.insert(all.end(), {parameter.name, parameter.unit, parameter.truth,
                                    std::vector<std::optional<FoundParameter>>(comparison.runs.size())});
      if (!at->truth) at->truth = parameter.truth;
      at->runs[i] = parameter;
    }
  return all;
}

Named<std::vector<std::optional<double>>> compared_errors(const RunComparison& comparison, ErrorsOfRun kind) {
  Named<std::vector<std::optional<double>>> all;
  for (std::size_t i = 0; i < comparison.runs.size(); ++i)
    for (const auto& [point, errors] : comparison.runs[i].*kind)
      for (const auto& [quantity, error] : errors) {
        const std::string name = point + ", " + quantity;
        auto at = std::ranges::find(all, name, [](const auto& each) { return each.first; });
        if (at == all.end()) at = all.insert(all.end(), {name, decltype(at->second)(comparison.runs.size())});
        at->second[i] = error;
      }
  return all;
}

}  // namespace kalfem
