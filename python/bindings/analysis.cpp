// SPDX-License-Identifier: Apache-2.0
#include "kalfem/analysis/analysis.hpp"

#include <cmath>
#include <cstdio>

#include "calls.hpp"
#include "kalfem/base/units.hpp"
#include "options.hpp"
#include "records.hpp"
#include "results.hpp"
#include "sensors.hpp"
#include "structure.hpp"

namespace kalfem::python {

using Eigen::Index;

namespace {

/// {"initial": ..., "std": ...}, as `unknown` takes it.
py::dict in_python(const Prior& prior) {
  py::dict entry;
  if (prior.initial) entry["initial"] = *prior.initial;
  if (prior.std != 0.0) entry["std"] = prior.std;
  if (prior.random_walk != 0.0) entry["random_walk"] = prior.random_walk;
  if (prior.transform && prior.transform->kind == TransformKind::logit)
    entry["bounds"] = py::make_tuple(prior.transform->lower, prior.transform->upper);
  else if (prior.transform)
    entry["transform"] = prior.transform->kind == TransformKind::log ? "log" : "none";
  if (!prior.applies_to.empty()) entry["applies_to"] = prior.applies_to;
  return entry;
}

py::object second_thoughts_in_python(double factor) {
  if (factor == 0.0) return py::str("none");
  if (std::isinf(factor)) return py::str("full");
  return py::float_(factor);
}

py::dict known_to_in_python(const std::vector<KnownTo>& all) {
  py::dict known_to;
  for (const auto& known : all)
    known_to[py::str(known.name)] =
        known.relative ? py::object(py::str(shortest(100.0 * known.deviation) + " %")) : py::float_(known.deviation);
  return known_to;
}

/// The options that are not the defaults, by the names of the arguments of kalfem.estimate.
py::dict in_python(const EstimateOptions& options) {
  const EstimateOptions defaults;
  py::dict all, unknown, state, connectors;
  for (const auto& [name, prior] : options.unknowns) unknown[py::str(name)] = in_python(prior);
  for (const auto& [point, prior] : options.initial_state) {
    py::dict entry;
    entry["displacement"] = prior.displacement;
    entry["velocity"] = prior.velocity;
    entry["displacement_std"] = prior.displacement_std;
    entry["velocity_std"] = prior.velocity_std;
    state[py::str(point)] = entry;
  }
  for (const auto& [name, prior] : options.initial_connector_states) {
    py::dict entry;
    entry["value"] = prior.value;
    entry["std"] = prior.std;
    connectors[py::str(name)] = entry;
  }
  const auto give = [&](const char* name, const auto& value, const auto& otherwise) {
    if (value != otherwise) all[name] = value;
  };
  all["sensors"] = sensors_in_python(options.sensors);
  if (!unknown.empty()) all["unknown"] = unknown;
  if (options.filter) all["filter"] = to_string(*options.filter);
  if (!state.empty()) all["initial_state"] = state;
  if (!connectors.empty()) all["initial_connector_states"] = connectors;
  give("process_noise", options.process_noise, defaults.process_noise);
  if (options.adaptive_noise.sensors || options.adaptive_noise.process) {
    py::dict adaptive;
    adaptive["sensors"] = options.adaptive_noise.sensors;
    adaptive["process"] = options.adaptive_noise.process;
    adaptive["memory"] = options.adaptive_noise.memory;
    all["adaptive_noise"] = adaptive;
  }
  give("substeps", options.substeps, defaults.substeps);
  give("step_order", options.step_order, defaults.step_order);
  give("settle", options.settle, defaults.settle);
  give("initial_state_from_record", options.initial_state_from_record, defaults.initial_state_from_record);
  give("estimate_initial_state", options.estimate_initial_state, defaults.estimate_initial_state);
  give("passes", options.passes, defaults.passes);
  give("threads", options.threads, defaults.threads);
  give("diagnose", options.diagnose, defaults.diagnose);
  if (options.second_thoughts) all["second_thoughts"] = second_thoughts_in_python(*options.second_thoughts);
  if (!options.known_to.empty()) all["known_to"] = known_to_in_python(options.known_to);
  if (options.free != defaults.free) all["free"] = to_string(options.free);
  return all;
}

/// {"initial": ..., "lower": ...}, as `parameters` takes it.
py::dict in_python(const RefinedParameter::Range& range) {
  py::dict entry;
  if (range.initial) entry["initial"] = *range.initial;
  if (range.std) entry["std"] = *range.std;
  if (range.lower != 0.0) entry["lower"] = range.lower;
  if (std::isfinite(range.upper)) entry["upper"] = range.upper;
  return entry;
}

/// The members of kalfem.MeasuredModes.
py::dict in_python(const MeasuredModes& modes, double weight) {
  py::list frequencies, std, numbers;
  bool numbered = false;
  for (const auto& each : modes.frequencies) {
    frequencies.append(each.frequency);
    std.append(each.std);
    numbers.append(each.mode);
    numbered = numbered || each.mode;
  }
  py::dict entry;
  entry["substructure"] = modes.substructure;
  entry["frequencies"] = frequencies;
  entry["std"] = std;
  if (numbered) entry["modes"] = numbers;
  entry["above"] = modes.above;
  entry["weight"] = weight;
  return entry;
}

/// By the names of the arguments of kalfem.update.
py::dict in_python(const UpdateOptions& options) {
  const UpdateOptions defaults;
  py::dict all, parameters, compare;
  for (const auto& [name, range] : options.parameters) parameters[py::str(name)] = in_python(range);
  for (const auto& [name, what, weight] : options.comparisons)
    compare[py::str(name)] = in_python(std::get<MeasuredModes>(what), weight);
  all["parameters"] = parameters;
  all["compare"] = compare;
  if (options.max_evaluations != defaults.max_evaluations) all["max_evaluations"] = options.max_evaluations;
  if (options.tolerance != defaults.tolerance) all["tolerance"] = options.tolerance;
  if (!options.known_to.empty()) all["known_to"] = known_to_in_python(options.known_to);
  return all;
}

py::dict in_python(const Record& record) {
  if (record.used)
    throw InvalidInput("the filter learns from a part of the case's record alone",
                       "arrays of Python do not say so (record.free_response)",
                       "run the case file, or read it from C++");
  Datasets data;
  data.add("time", times_of(record), "s");
  for (Index i = 0; i < record.values.rows(); ++i) {
    const auto& channel = record.channels[static_cast<std::size_t>(i)];
    data.add("measurements/" + channel.name, Eigen::VectorXd(record.values.row(i).transpose()), channel.unit);
  }
  return data.take();
}

py::dict read(const std::string& file, const std::vector<std::pair<std::string, std::optional<std::string>>>& set,
              bool with_record, const py::object& progress) {
  ReadCaseOptions options{.set = set, .record = with_record};
  Analysis analysis = LongCall(progress).run([&](const Progress& report) {
    options.progress = report;
    return read_case(file, options);
  });
  py::dict all;
  all["title"] = analysis.title;
  all["structure"] = analysis.structure;
  all["record"] = analysis.record ? py::object(in_python(*analysis.record)) : py::none();
  all["estimate"] = analysis.estimate ? py::object(in_python(*analysis.estimate)) : py::none();
  all["update"] = analysis.update ? py::object(in_python(*analysis.update)) : py::none();
  all["left_out"] = analysis.left_out;
  return all;
}

/// The text of the case; written with its records where a file is given.
std::string write(const Structure& structure, const py::object& t, const py::object& y, const py::dict& inputs,
                  const py::object& arguments, const py::object& updating, const std::string& title,
                  const std::string& file) {
  Analysis analysis{.title = title, .structure = structure};
  if (!t.is_none()) {
    const TimeGrid grid = grid_of(t);
    analysis.structure = driven(structure, inputs, grid.start, grid.sample_rate, grid.samples);
    if (!arguments.is_none()) {
      const auto given = arguments.cast<py::dict>();
      auto& options = analysis.estimate.emplace(options_of(structure, given));
      std::vector<std::string> names;
      for (const auto& sensor : options.sensors) names.push_back(sensor.name);
      analysis.record = record_of(grid, y, names);
      set_relative_noise(given["sensors"], *analysis.record, options.sensors);
    }
  }
  if (!updating.is_none()) analysis.update = update_options_of(analysis.structure, updating.cast<py::dict>());
  const std::filesystem::path path = file;
  const CaseText text = to_case(analysis, file.empty() ? "case" : path.stem().string());
  if (!file.empty())
    write_case(analysis, path);
  else if (!text.files.empty())
    throw InvalidInput("file: it is not given, and samples in memory go to '" + text.files.front().first + "'",
                       "a case names the files of its samples", "give the file of the case: they stand beside it");
  return text.yaml;
}

}  // namespace

void bind_analysis(py::module_& module) {
  module.def("read_case", &read, py::arg("case"), py::arg("set"), py::arg("record"), py::arg("progress") = py::none(),
             "A case as a structure, a record and arguments: see kalfem.read_case.");
  module.def("to_case", &write, py::arg("structure"), py::arg("t"), py::arg("y"), py::arg("inputs"),
             py::arg("arguments"), py::arg("update"), py::arg("title"), py::arg("file"),
             "A case as text: see kalfem.to_case.");
}

}  // namespace kalfem::python
