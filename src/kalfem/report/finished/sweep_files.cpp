// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/report/finished/sweep_report.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Eigen::Index;

std::string heading_of(const CaseSweep& sweep) {
  std::vector<std::string> keys;
  for (const auto& axis : sweep.plan().axes) keys.push_back(axis.key);
  return Json{{"kalfem", version},
              {"sweep", sweep.identity()},
              {"case", sweep.plan().case_file.filename().string()},
              {"keys", keys},
              {"runs", sweep.plan().size()}}
             .dump() +
         "\n";
}

/// Values of a run's parameters by their names, each where some run identified it.
struct Column {
  std::string name, unit;
  std::vector<std::optional<FoundParameter>> values;
};

std::vector<Column> columns_of(const std::vector<FinishedSweepRun>& runs) {
  std::vector<Column> columns;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!runs[i].found) continue;
    for (auto& parameter : runs[i].found->parameters()) {
      auto column = std::ranges::find(columns, parameter.name, &Column::name);
      if (column == columns.end()) column = columns.insert(column, {parameter.name, parameter.unit, {}});
      column->values.resize(runs.size());
      column->values[i] = std::move(parameter);
    }
  }
  return columns;
}

std::string status_of(const FinishedSweepRun& run) {
  if (!run.found) return "refused";
  return run.found->usable ? "ok" : "failed";
}

std::string verdict_of(const FinishedSweepRun& run) {
  return run.found && run.found->compared ? to_string(run.found->verdict) : "";
}

std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string cell(const std::optional<double>& value) { return value ? shortest(*value) : ""; }

std::optional<double> mean_nis(const FinishedSweepRun& run) {
  return run.found && run.found->filter ? run.found->filter->consistency.mean_nis : std::nullopt;
}

}  // namespace

std::vector<FinishedSweepRun> finished_runs(const std::vector<SweepRun>& runs) {
  std::vector<FinishedSweepRun> finished;
  for (const auto& run : runs) {
    finished.push_back({run, std::nullopt});
    if (!run.summary.empty()) finished.back().found = finished_run_of(run.summary, "runs.jsonl");
  }
  return finished;
}

std::string sweep_csv(const SweepPlan& plan, const std::vector<FinishedSweepRun>& runs) {
  const auto columns = columns_of(runs);
  std::string text = "run";
  for (const auto& axis : plan.axes) text += "," + cell(axis.key);
  text += ",seed,status,verdict,mean_nis";
  for (const auto& column : columns) {
    const std::string unit = column.unit.empty() ? "" : " [" + column.unit + "]";
    for (const char* kind : {"", " std", " true"}) text += "," + cell(column.name + kind + unit);
  }
  text += "\n";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const SweepRun& run = runs[i].run;
    text += std::to_string(run.number + 1);
    for (const auto& value : run.values) text += "," + cell(value);
    text += "," + (run.seed ? std::to_string(*run.seed) : "") + "," + status_of(runs[i]) + "," + verdict_of(runs[i]) +
            "," + cell(mean_nis(runs[i]));
    for (const auto& column : columns) {
      const FoundParameter parameter = column.values[i].value_or(FoundParameter{});
      text += "," + cell(parameter.estimate) + "," + cell(parameter.deviation()) + "," + cell(parameter.truth);
    }
    text += "\n";
  }
  return text;
}

SweepArrays sweep_arrays(const SweepPlan& plan, const std::vector<FinishedSweepRun>& runs) {
  SweepArrays arrays;
  const auto add_texts = [&](const std::string& path, const auto& text_of) {
    auto& texts = arrays.texts.emplace_back(SweepArrays::Texts{path, {}}).values;
    for (const auto& run : runs) texts.push_back(text_of(run));
  };
  for (std::size_t a = 0; a < plan.axes.size(); ++a)
    add_texts("/axes/" + plan.axes[a].key, [a](const auto& run) { return run.run.values[a]; });
  add_texts("/status", status_of);
  add_texts("/verdict", verdict_of);

  const auto add = [&](const std::string& path, const std::string& unit, const auto& value_of) {
    Eigen::VectorXd values(static_cast<Index>(runs.size()));
    for (std::size_t i = 0; i < runs.size(); ++i)
      values[static_cast<Index>(i)] = value_of(i).value_or(std::numeric_limits<double>::quiet_NaN());
    arrays.numbers.push_back({path, std::move(values), unit});
  };
  if (plan.seeds > 0) add("/seed", "", [&](std::size_t i) { return std::optional<double>(runs[i].run.seed); });
  add("/mean_nis", "", [&](std::size_t i) { return mean_nis(runs[i]); });
  for (const auto& column : columns_of(runs)) {
    const std::string group = "/parameters/" + column.name;
    const auto value = [&](std::size_t i) { return column.values[i].value_or(FoundParameter{}); };
    add(group + "/estimate", column.unit, [&](std::size_t i) { return value(i).estimate; });
    add(group + "/std", column.unit, [&](std::size_t i) { return value(i).deviation(); });
    add(group + "/true", column.unit, [&](std::size_t i) { return value(i).truth; });
  }
  return arrays;
}

namespace {

void write_arrays(const fs::path& file, const SweepArrays& arrays) {
  Hdf5File hdf5 = Hdf5File::create(file.string());
  if (!arrays.texts.empty()) hdf5.write_axis("/run", std::ssize(arrays.texts.front().values));
  for (const auto& [path, values] : arrays.texts) hdf5.write_strings(path, values);
  for (const auto& [path, values, unit] : arrays.numbers) {
    hdf5.write(path, values);
    hdf5.set_axes(path, {"/run"});
    if (!unit.empty()) hdf5.set_attribute(path, "unit", unit);
  }
  hdf5.close();
}

const char* const file_names[] = {"runs.jsonl", "sweep.csv", "sweep.h5"};

}  // namespace

SweepFolder::SweepFolder(const fs::path& folder, const CaseSweep& sweep)
    : lock_(folder), folder_(folder), plan_(sweep.plan()), heading_(heading_of(sweep)) {
  for (const char* name : file_names) require_writable(folder_ / name);
  const fs::path file = folder_ / "runs.jsonl";
  std::istringstream existing(fs::exists(file) ? read_bytes(file) : "");
  std::string line, text = heading_;
  if (std::getline(existing, line) && line + "\n" == heading_)
    for (int number = 2; std::getline(existing, line); ++number) {
      const bool cut_short = existing.eof();
      if (auto run = sweep_run_of(line); run && run->number < plan_.size()) {
        text += line + "\n";
        known_.push_back(std::move(*run));
      } else if (!cut_short) {
        damaged_lines_.push_back(number);
      }
    }
  write_file_atomically(file, text);
  stream_.open(file, std::ios::binary | std::ios::app);
}

void SweepFolder::add(const SweepRun& run) {
  stream_ << to_line(run) << "\n" << std::flush;
  if (!stream_) fail_to_write(folder_ / "runs.jsonl", ENOSPC);
}

void SweepFolder::finish(const std::vector<FinishedSweepRun>& runs) {
  std::string text = heading_;
  for (const auto& [run, found] : runs) text += to_line(run) + "\n";
  write_file_atomically(folder_ / "runs.jsonl", text);
  write_file_atomically(folder_ / "sweep.csv", sweep_csv(plan_, runs));
  write_arrays(folder_ / "sweep.h5", sweep_arrays(plan_, runs));
}

}  // namespace kalfem
