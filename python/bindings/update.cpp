// SPDX-License-Identifier: Apache-2.0
#include "calls.hpp"
#include "results.hpp"
#include "sensors.hpp"

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

py::dict summary_of(const UpdateResult& result) {
  py::dict summary, parameters, updating;
  for (const auto& each : result.parameters) {
    py::dict entry;
    entry["initial"] = each.initial;
    entry["estimate"] = number(each.value);
    entry["std"] = number(each.std);
    entry["std_robust"] = number(each.std_robust);
    entry["interval_95"] = py::make_tuple(number(each.interval_95.lower), number(each.interval_95.upper));
    entry["unit"] = each.unit;
    parameters[py::str(each.name)] = entry;
  }
  const auto reasons = result.verdict.reasons();
  updating["parameters"] = parameters;
  updating["converged"] = result.converged;
  updating["termination"] = result.reason;
  summary["title"] = "update";
  summary["status"] = result.usable() ? "ok" : "unusable";
  summary["message"] = result.usable() || reasons.empty() ? "" : sentence_of(reasons.front());
  summary["verdict"] = python::summary_of(result.verdict);
  summary["updating"] = updating;
  return summary;
}

py::tuple update_structure(const Structure& structure, const std::string& substructure, const py::object& frequencies,
                           const py::object& std, const py::object& modes, const py::object& parameters, double above,
                           int max_evaluations, const py::object& progress) {
  const UpdateOptions options{.substructure = substructure,
                              .frequencies = frequencies_of(frequencies, std, modes),
                              .parameters = parameters_of(structure, parameters),
                              .above = above,
                              .max_evaluations = max_evaluations};
  const auto result = long_call(structure, progress, [&](const Progress&) { return update(structure, options); });
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
  return py::make_tuple(summary_of(result), data.take());
}

}  // namespace

void bind_update(py::module_& module) {
  module.def("update", &update_structure, py::arg("structure"), py::arg("substructure"), py::arg("frequencies"),
             py::arg("std"), py::arg("modes"), py::arg("parameters"), py::arg("above"), py::arg("max_evaluations"),
             py::arg("progress") = py::none(), "Summary and datasets of an updating: see kalfem.update.");
}

}  // namespace kalfem::python
