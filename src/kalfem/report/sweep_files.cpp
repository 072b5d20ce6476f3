#include <cerrno>
#include <nlohmann/json.hpp>
#include <sstream>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/report/sweep_report.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Eigen::Index;

std::string line_of(const SweepRun& run) {
  Json line{{"run", run.number}, {"values", run.values}};
  line["seed"] = run.seed ? Json(*run.seed) : Json(nullptr);
  if (run.summary.empty())
    line["refused"] = run.refused;
  else
    line["summary"] = Json::parse(run.summary);
  return line.dump(-1, ' ', true, Json::error_handler_t::replace) + "\n";
}

/// Nothing where the line is cut short.
std::optional<SweepRun> run_in(const std::string& line) try {
  const Json json = Json::parse(line);
  SweepRun run{json.at("run"), json.at("values"), std::nullopt, {}, json.value("refused", std::string())};
  if (!json.at("seed").is_null()) run.seed = json.at("seed").get<int>();
  if (json.contains("summary")) run.summary = json.at("summary").dump(-1, ' ', true, Json::error_handler_t::replace);
  return run;
} catch (const Json::exception&) {
  return std::nullopt;
}

std::string heading_of(const Sweep& sweep) {
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

/// One number a run, NaN where it is unknown.
template <class Read>
Eigen::VectorXd array_of(std::size_t count, const Read& read) {
  Eigen::VectorXd values(static_cast<Index>(count));
  for (std::size_t i = 0; i < count; ++i)
    values[static_cast<Index>(i)] = read(i).value_or(std::numeric_limits<double>::quiet_NaN());
  return values;
}

}  // namespace

SweepLog::SweepLog(fs::path file, const Sweep& sweep) : file_(std::move(file)), heading_(heading_of(sweep)) {
  std::ifstream existing(file_, std::ios::binary);
  std::string line;
  if (std::getline(existing, line) && line + "\n" == heading_)
    while (std::getline(existing, line))
      if (auto run = run_in(line); run && run->number < sweep.plan().size()) known_.push_back(std::move(*run));
  existing.close();
  finish(known_);
  stream_.open(file_, std::ios::binary | std::ios::app);
}

void SweepLog::add(const SweepRun& run) {
  stream_ << line_of(run) << std::flush;
  if (!stream_) fail_to_write(file_, ENOSPC);
}

void SweepLog::finish(const std::vector<SweepRun>& runs) {
  std::string text = heading_;
  for (const auto& run : runs) text += line_of(run);
  write_file_atomically(file_, text);
}

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
    const auto& [run, found] = runs[i];
    text += std::to_string(run.number + 1);
    for (const auto& value : run.values) text += "," + cell(value);
    text += "," + (run.seed ? std::to_string(*run.seed) : "") + "," + status_of(runs[i]) + "," +
            (found ? to_string(found->verdict) : "") + "," + cell(mean_nis(runs[i]));
    for (const auto& column : columns) {
      const FoundParameter parameter = column.values[i].value_or(FoundParameter{});
      text += "," + cell(parameter.estimate) + "," + cell(parameter.deviation()) + "," + cell(parameter.truth);
    }
    text += "\n";
  }
  return text;
}

void write_sweep_arrays(const fs::path& file, const SweepPlan& plan, const std::vector<FinishedSweepRun>& runs) {
  Hdf5File arrays = Hdf5File::create(file.string());
  const std::size_t count = runs.size();
  arrays.write_axis("/run", static_cast<Index>(count));
  const auto write = [&](const std::string& name, const Eigen::VectorXd& values) {
    arrays.write(name, values);
    arrays.set_axes(name, {"/run"});
  };
  const auto write_texts = [&](const std::string& name, const auto& text_of) {
    std::vector<std::string> texts;
    for (const auto& run : runs) texts.push_back(text_of(run));
    arrays.write_strings(name, texts);
  };
  for (std::size_t a = 0; a < plan.axes.size(); ++a)
    write_texts("/axes/" + plan.axes[a].key, [a](const auto& run) { return run.run.values[a]; });
  write_texts("/status", status_of);
  if (plan.seeds > 0)
    write("/seed", array_of(count, [&](std::size_t i) { return std::optional<double>(runs[i].run.seed); }));
  write("/mean_nis", array_of(count, [&](std::size_t i) { return mean_nis(runs[i]); }));
  for (const auto& column : columns_of(runs)) {
    const std::string group = "/parameters/" + column.name;
    const auto value = [&](std::size_t i) { return column.values[i].value_or(FoundParameter{}); };
    write(group + "/estimate", array_of(count, [&](std::size_t i) { return value(i).estimate; }));
    write(group + "/std", array_of(count, [&](std::size_t i) { return value(i).deviation(); }));
    write(group + "/true", array_of(count, [&](std::size_t i) { return value(i).truth; }));
    arrays.set_attribute(group, "unit", column.unit);
  }
  arrays.close();
}

}  // namespace kalfem
