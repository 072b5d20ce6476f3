// SPDX-License-Identifier: Apache-2.0
#include "calls.hpp"
#include "mode_sets.hpp"
#include "options.hpp"
#include "records.hpp"
#include "results.hpp"
#include "sensors.hpp"
#include "structure.hpp"

namespace kalfem::python {
namespace {

RefinedParameter refined(const Structure& structure, const std::string& name, const py::handle& given) {
  RefinedParameter parameter{.name = name};
  auto& range = parameter.range;
  const std::string argument = entry_of("parameters", name);
  const auto value = [&](const py::handle& each) {
    return number_of(each, py::isinstance<py::str>(each) ? structure.unit(name) : "", argument);
  };
  if (py::isinstance<py::dict>(given)) {
    const std::vector<std::string> known{"initial", "std", "lower", "upper"};
    for (const auto& [key, each] : given.cast<py::dict>()) {
      const auto entry = key.cast<std::string>();
      if (entry == "initial")
        range.initial = value(each);
      else if (entry == "std")
        range.std = value(each);
      else if (entry == "lower")
        range.lower = value(each);
      else if (entry == "upper")
        range.upper = value(each);
      else
        throw InvalidInput(argument + ": there is no entry '" + entry + "'" + did_you_mean(entry, known), "", "");
    }
  } else if (py::isinstance<py::tuple>(given)) {
    const auto pair = given.cast<py::tuple>();
    if (pair.size() != 2)
      throw InvalidInput(argument + ": " + std::to_string(pair.size()) + " values are given", "",
                         "write (initial, std)");
    range.initial = value(py::object(pair[0]));
    range.std = value(py::object(pair[1]));
  } else if (!given.is_none()) {
    range.initial = value(given);
  }
  return parameter;
}

std::vector<RefinedParameter> parameters_of(const Structure& structure, const py::object& given) {
  std::vector<RefinedParameter> all;
  if (py::isinstance<py::dict>(given))
    for (const auto& [name, each] : given.cast<py::dict>())
      all.push_back(refined(structure, name.cast<std::string>(), each));
  else
    for (const auto& name : given) all.push_back({.name = name.cast<std::string>()});
  return all;
}

/// Frequencies with their deviations, and the modes that they belong to.
std::vector<MeasuredFrequency> frequencies_of(const py::object& frequencies, const py::object& std,
                                              const py::object& modes) {
  const Eigen::VectorXd values = vector_of(frequencies, "frequencies");
  Eigen::VectorXd deviations = Eigen::VectorXd::Constant(
      values.size(), py::isinstance<py::float_>(std) || py::isinstance<py::int_>(std) ? std.cast<double>() : 0.0);
  if (!py::isinstance<py::float_>(std) && !py::isinstance<py::int_>(std)) deviations = vector_of(std, "std");
  if (deviations.size() != values.size())
    throw InvalidInput(
        "std: " + std::to_string(deviations.size()) + " values, frequencies has " + std::to_string(values.size()),
        "each frequency has its standard deviation", "");
  std::vector<MeasuredFrequency> all;
  for (Eigen::Index i = 0; i < values.size(); ++i) all.push_back({values[i], deviations[i]});
  if (modes.is_none()) return all;
  const auto numbers = modes.cast<std::vector<std::optional<int>>>();
  if (numbers.size() != all.size())
    throw InvalidInput(
        "modes: " + std::to_string(numbers.size()) + " numbers, frequencies has " + std::to_string(all.size()),
        "each frequency has its mode, or None", "");
  for (std::size_t i = 0; i < all.size(); ++i) all[i].mode = numbers[i];
  return all;
}

/// Reads the descriptions of python/kalfem/comparing.py. Records give their inputs to the structure.
class ComparisonReader {
public:
  explicit ComparisonReader(Structure& structure) : structure_(structure) {}

  UpdateComparison read(const std::string& name, const py::dict& given) {
    place_ = entry_of("compare", name) + ".";
    UpdateComparison comparison{.name = name, .what = {}, .weight = number_of(given["weight"], "", place_ + "weight")};
    const auto kind = given["kind"].cast<std::string>();
    if (kind == "modes")
      comparison.what = modes(given);
    else if (kind == "responses")
      comparison.what = responses(given);
    else if (kind == "deflections")
      comparison.what = deflections(given);
    else
      comparison.what = record(given);
    return comparison;
  }

private:
  static bool is_given(const py::handle& value) { return !value.is_none(); }
  static bool is_matrix(const py::handle& value) {
    return py::isinstance<py::array>(value) || py::isinstance<py::list>(value);
  }

  std::vector<double> numbers(const py::handle& given, const std::string& argument) const {
    const Eigen::VectorXd values = vector_of(given, place_ + argument);
    return {values.begin(), values.end()};
  }

  MeasuredModes modes(const py::dict& given) const {
    MeasuredModes all{.substructure = given["substructure"].cast<std::string>(),
                      .frequencies = frequencies_of(given["frequencies"], given["std"], given["modes"]),
                      .above = number_of(given["above"], "Hz", place_ + "above"),
                      .points = strings(given["points"]),
                      .sensors = strings(given["sensors"])};
    if (is_matrix(given["shape_std"]))
      all.shape_stds = matrix(given["shape_std"], "shape_std");
    else
      all.shape_std = number_of(given["shape_std"], "", place_ + "shape_std");
    if (is_given(given["shapes"])) all.shapes = matrix(given["shapes"], "shapes");
    if (is_given(given["shape_covariances"]))
      for (const auto& each : given["shape_covariances"])
        all.shape_covariances.push_back(matrix(each, "shape_covariances"));
    if (is_given(given["dampings"])) all.dampings = numbers(given["dampings"], "dampings");
    if (is_given(given["damping_std"])) all.damping_stds = numbers(given["damping_std"], "damping_std");
    return all;
  }

  MeasuredResponses responses(const py::dict& given) const {
    MeasuredResponses all{.input = given["input"].cast<std::string>(),
                          .outputs = {},
                          .frequencies = vector_of(given["frequencies"], place_ + "frequencies"),
                          .values = {}};
    all.relative_std = number_of(given["relative_std"], "", place_ + "relative_std");
    all.smoothing = number_of(given["smoothing"], "Hz", place_ + "smoothing");
    const auto outputs = outputs_of(py::dict(given["outputs"]));
    const Eigen::Index lines = all.frequencies.size();
    all.values.resize(lines, std::ssize(outputs));
    if (is_given(given["std"])) all.std.resize(lines, std::ssize(outputs));
    for (Eigen::Index column = 0; const auto& [name, output] : outputs) {
      all.outputs.push_back(output);
      all.values.col(column) = column_of<std::complex<double>>(given["values"], "values", name, lines);
      if (is_given(given["std"])) all.std.col(column) = column_of<double>(given["std"], "std", name, lines);
      ++column;
    }
    return all;
  }

  MeasuredDeflections deflections(const py::dict& given) const {
    MeasuredDeflections all{.forces = {}, .displacements = {}, .std = number_of(given["std"], "m", place_ + "std")};
    for (const auto& [point, value] : py::dict(given["forces"]))
      all.forces.emplace_back(point.cast<std::string>(), number_of(value, "N", place_ + "forces"));
    for (const auto& [point, value] : py::dict(given["displacements"]))
      all.displacements.emplace_back(point.cast<std::string>(), number_of(value, "m", place_ + "displacements"));
    return all;
  }

  MeasuredRecord record(const py::dict& given) {
    const auto sensors = py::dict(given["sensors"]);
    MeasuredRecord all{.record = {}, .sensors = sensors_of(sensors)};
    all.settle = number_of(given["settle"], "s", place_ + "settle");
    all.substeps = given["substeps"].cast<int>();
    std::vector<std::string> names;
    for (const auto& sensor : all.sensors) names.push_back(sensor.name);
    const TimeGrid grid = grid_of(given["t"]);
    all.record = record_of(grid, given["y"], names);
    set_relative_noise(sensors, all.record, all.sensors);
    const auto inputs = py::dict(given["inputs"]);
    for (const auto& [input, values] : inputs)
      if (const auto name = input.cast<std::string>(); std::ranges::find(driven_, name) != driven_.end())
        throw InvalidInput("inputs: another record gives '" + name + "' its samples", "an input has one course",
                           "compare with one record, or give both the same time");
      else
        driven_.push_back(name);
    structure_ = driven(structure_, inputs, grid.start, grid.sample_rate, grid.samples);
    return all;
  }

  static std::vector<std::string> strings(const py::handle& given) {
    std::vector<std::string> all;
    for (const auto& each : given) all.push_back(each.cast<std::string>());
    return all;
  }

  [[nodiscard]] Eigen::MatrixXd matrix(const py::handle& given, const std::string& argument) const {
    const auto values = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(
        py::reinterpret_borrow<py::object>(given));
    if (!values) PyErr_Clear();
    if (!values || values.ndim() != 2)
      throw InvalidInput(argument + ": no matrix of numbers", "each mode is a column",
                         "give an array of shape (points, frequencies)");
    return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        values.data(), values.shape(0), values.shape(1));
  }

  template <class Number>
  [[nodiscard]] Eigen::Matrix<Number, Eigen::Dynamic, 1> column_of(const py::handle& given, const std::string& argument,
                                                                   const std::string& name, Eigen::Index lines) const {
    const auto all = py::reinterpret_borrow<py::object>(given);
    const std::string place = argument + "['" + name + "']";
    if (!all.contains(name)) throw InvalidInput(place + " is missing", "each output has its response", "");
    const auto values = py::array_t<Number, py::array::c_style | py::array::forcecast>::ensure(all[py::str(name)]);
    if (!values) PyErr_Clear();
    if (!values || values.ndim() != 1 || values.shape(0) != lines)
      throw InvalidInput(place + ": no array of " + std::to_string(lines) + " numbers", "each line has a value",
                         "give an array of shape (frequencies,)");
    return Eigen::Map<const Eigen::Matrix<Number, Eigen::Dynamic, 1>>(values.data(), lines);
  }

  Structure& structure_;
  std::string place_;
  std::vector<std::string> driven_;  ///< inputs that records gave their samples
};

/// The comparisons; `structure` gets the inputs of their records.
std::vector<UpdateComparison> comparisons_of(const py::dict& given, Structure& structure) {
  std::vector<UpdateComparison> all;
  ComparisonReader reader(structure);
  IssueList issues;
  for (const auto& [name, each] : given) try {
      all.push_back(reader.read(name.cast<std::string>(), each.cast<py::dict>()));
    } catch (const InvalidInput& error) {
      for (const auto& issue : error.issues())
        issues.add({}, entry_of("compare", name.cast<std::string>()) + ": " + issue.what, issue.why, issue.fix);
    }
  issues.raise();
  return all;
}

/// As `kalfem run` writes it.
py::list considered_of(const UpdateResult& result) {
  py::list all;
  for (const auto& each : result.stated_numbers) {
    py::dict entry, shift, adds;
    for (std::size_t j = 0; j < each.shift.size(); ++j) {
      shift[py::str(result.parameters[j].name)] = number(each.shift[j]);
      adds[py::str(result.parameters[j].name)] = number(each.considered[j]);
    }
    entry["name"] = each.name;
    entry["group"] = each.group;
    entry["unit"] = each.unit;
    entry["value"] = number(each.value);
    entry["known_to"] = number(each.known_to);
    entry["allowed_change"] = number(each.allowed);
    entry["shift"] = shift;
    entry["adds"] = adds;
    all.append(entry);
  }
  return all;
}

py::dict summary_of(const UpdateResult& result) {
  py::dict summary, parameters, updating;
  for (const auto& each : result.parameters) {
    py::dict entry;
    entry["initial"] = each.initial;
    entry["estimate"] = number(each.value);
    entry["std"] = number(each.std);
    entry["std_robust"] = number(each.std_robust);
    if (std::isfinite(each.std_considered)) entry["std_considered"] = each.std_considered;
    entry["interval_95"] = py::make_tuple(number(each.interval_95.lower), number(each.interval_95.upper));
    entry["unit"] = each.unit;
    parameters[py::str(each.name)] = entry;
  }
  const auto reasons = result.verdict.reasons();
  updating["parameters"] = parameters;
  updating["converged"] = result.converged;
  updating["termination"] = result.reason;
  py::dict comparisons;
  for (const auto& [name, size, rms_before, rms_after] : result.comparisons) {
    py::dict entry;
    entry["size"] = size;
    entry["rms_initial"] = number(rms_before);
    entry["rms_final"] = number(rms_after);
    comparisons[py::str(name)] = entry;
  }
  updating["comparisons"] = comparisons;
  py::dict before;
  before["undetermined"] = result.before.undetermined;
  before["groups"] = result.before.groups;
  before["hold"] = result.before.hold;
  updating["before"] = before;
  if (!result.stated_numbers.empty()) updating["considered"] = considered_of(result);
  summary["title"] = "update";
  summary["status"] = result.usable() ? "ok" : "unusable";
  summary["message"] = result.usable() || reasons.empty() ? "" : sentence_of(reasons.front());
  summary["verdict"] = python::summary_of(result.verdict);
  summary["updating"] = updating;
  return summary;
}

py::tuple update_structure(const Structure& structure, const py::dict& arguments, const py::object& progress) {
  Structure moved = structure;
  const UpdateOptions options = update_options_of(moved, arguments);
  const auto result = long_call(structure, progress, [&](const Progress&) { return update(moved, options); });
  Eigen::VectorXd measured(std::ssize(result.frequencies)), before = measured, after = measured;
  for (Eigen::Index i = 0; i < measured.size(); ++i) {
    const auto& each = result.frequencies[static_cast<std::size_t>(i)];
    measured[i] = each.measured;
    before[i] = each.before;
    after[i] = each.after;
  }
  Datasets data;
  data.add("updating/frequencies/measured", measured, "Hz");
  data.add("updating/frequencies/before", before, "Hz");
  data.add("updating/frequencies/after", after, "Hz");
  if (result.before.sensitivities.size() > 0)
    data.add("updating/frequencies/sensitivities", result.before.sensitivities, "-");
  return py::make_tuple(summary_of(result), data.take());
}

}  // namespace

MeasuredModes measured_modes_of(Structure& structure, const py::dict& given) {
  return std::get<MeasuredModes>(ComparisonReader(structure).read("modes", given).what);
}

MeasuredResponses measured_responses_of(Structure& structure, const py::dict& given) {
  return std::get<MeasuredResponses>(ComparisonReader(structure).read("responses", given).what);
}

UpdateOptions update_options_of(Structure& structure, const py::dict& arguments) {
  return {.substructure = cast_of<std::string>(arguments["substructure"], "substructure"),
          .frequencies = frequencies_of(arguments["frequencies"], arguments["std"], arguments["modes"]),
          .parameters = parameters_of(structure, arguments["parameters"]),
          .above = cast_of<double>(arguments["above"], "above"),
          .comparisons = comparisons_of(arguments["compare"], structure),
          .max_evaluations = cast_of<int>(arguments["max_evaluations"], "max_evaluations"),
          .known_to = known_to_of(arguments["known_to"]),
          .tolerance = cast_of<double>(arguments["tolerance"], "tolerance")};
}

void bind_update(py::module_& module) {
  module.def("update", &update_structure, py::arg("structure"), py::arg("arguments"), py::arg("progress") = py::none(),
             "Summary and datasets of an updating: see kalfem.update.");
}

}  // namespace kalfem::python
