// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/validate.hpp"
#include "calls.hpp"
#include "options.hpp"
#include "records.hpp"
#include "results.hpp"
#include "sensors.hpp"
#include "structure.hpp"

namespace kalfem::python {

using Eigen::Index;

namespace {

py::dict summary_of(const ValidateResult& result) {
  py::dict summary, sensors;
  for (const auto& [sensor, unit, nrmse, noise, one_step] : result.sensors) {
    py::dict entry;
    entry["nrmse"] = number(nrmse);
    entry["noise"] = number(noise);
    entry["one_step"] = number(one_step);
    sensors[py::str(sensor)] = entry;
  }
  summary["sensors"] = sensors;
  summary["compared_from"] = result.compared_from;
  summary["failure"] = result.failure;
  summary["verdict"] = python::summary_of(result.verdict);
  return summary;
}

py::dict datasets_of(const ValidateResult& result) {
  Datasets data;
  const Record& record = result.measured;
  data.add("time", times_of(record), "s", record.sample_rate);
  for (std::size_t j = 0; j < result.sensors.size(); ++j) {
    const auto row = static_cast<Index>(j);
    const auto& [sensor, unit, nrmse, noise, one_step] = result.sensors[j];
    data.add(sensor + "/measured", Eigen::VectorXd(record.values.row(row).transpose()), unit, record.sample_rate);
    if (result.simulated.size() > 0)
      data.add(sensor + "/simulated", Eigen::VectorXd(result.simulated.row(row).transpose()), unit, record.sample_rate);
  }
  return data.take();
}

py::tuple validate_structure(const Structure& structure, const py::object& t, const py::object& y,
                             const py::dict& inputs, const py::dict& values, const std::optional<double>& lead_in,
                             bool from_rest, const py::dict& arguments) {
  const EstimateOptions estimate = options_of(structure, arguments);
  ValidateOptions options{.sensors = estimate.sensors,
                          .values = values_of(values, "values"),
                          .lead_in = lead_in,
                          .from_rest = from_rest,
                          .process_noise = estimate.process_noise,
                          .filter = estimate.filter,
                          .substeps = estimate.substeps,
                          .threads = estimate.threads};
  std::vector<std::string> names;
  for (const auto& sensor : options.sensors) names.push_back(sensor.name);
  const TimeGrid grid = grid_of(t);
  const Record record = record_of(grid, y, names);
  set_relative_noise(arguments["sensors"], record, options.sensors);
  const Structure moved = driven(structure, inputs, grid.start, grid.sample_rate, grid.samples);
  const auto result =
      long_call(structure, py::none(), [&](const Progress&) { return validate(moved, record, options); });
  return py::make_tuple(summary_of(result), datasets_of(result));
}

}  // namespace

void bind_validate(py::module_& module) {
  module.def("validate", &validate_structure, py::arg("structure"), py::arg("t"), py::arg("y"), py::arg("inputs"),
             py::arg("values"), py::arg("lead_in"), py::arg("from_rest"), py::arg("arguments"),
             "Errors of a structure along a record, and datasets: see kalfem.validate.");
}

}  // namespace kalfem::python
