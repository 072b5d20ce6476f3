// SPDX-License-Identifier: Apache-2.0
#include "calls.hpp"
#include "records.hpp"
#include "results.hpp"
#include "sensors.hpp"
#include "structure.hpp"

namespace kalfem::python {
namespace {

py::tuple simulate_structure(const Structure& structure, double duration, double sample_rate, const py::dict& sensors,
                             const py::dict& inputs, const py::object& seed, double tolerance,
                             const py::object& progress) {
  SimulateOptions options{
      .sensors = sensors_of(sensors), .duration = duration, .sample_rate = sample_rate, .tolerance = tolerance};
  const auto samples = static_cast<Eigen::Index>(std::llround(duration * sample_rate)) + 1;
  const Structure moved = driven(structure, inputs, 0.0, sample_rate, samples);
  auto [record, failure] = long_call(structure, progress, [&](const Progress& report) {
    options.progress = report;
    return simulate(moved, options);
  });
  if (!seed.is_none() && !failure) {
    set_relative_noise(sensors, record, options.sensors);
    add_noise(options.sensors, seed.cast<std::uint64_t>(), record);
  }
  Datasets data;
  data.add("time", times_of(record), "s", sample_rate);
  for (std::size_t i = 0; i < record.channels.size(); ++i)
    data.add("measurements/" + record.channels[i].name,
             Eigen::VectorXd(record.values.row(static_cast<Eigen::Index>(i)).transpose()), record.channels[i].unit,
             sample_rate);
  const std::string message =
      failure ? "the simulation stopped at " + std::to_string(failure->time) + " s: " + failure->reason : "";
  return py::make_tuple(data.take(), message);
}

}  // namespace

void bind_simulate(py::module_& module) {
  module.def("simulate", &simulate_structure, py::arg("structure"), py::arg("duration"), py::arg("sample_rate"),
             py::arg("sensors"), py::arg("inputs"), py::arg("seed"), py::arg("tolerance"),
             py::arg("progress") = py::none(), "Datasets of a simulation and why it stopped: see kalfem.simulate.");
}

}  // namespace kalfem::python
