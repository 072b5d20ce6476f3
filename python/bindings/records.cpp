// SPDX-License-Identifier: Apache-2.0
#include "records.hpp"

#include "kalfem/base/units.hpp"
#include "kalfem/records/time_stamps.hpp"

namespace kalfem::python {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

std::string count_of(Index count, const std::string& what) { return std::to_string(count) + " " + what; }

Record from_mapping(const TimeGrid& grid, const py::object& y, const std::vector<std::string>& names) {
  Record record{.sample_rate = grid.sample_rate, .start = grid.start};
  record.values.resize(std::ssize(names), grid.samples);
  IssueList issues;
  std::vector<std::string> known;
  for (const auto& key : py::list(y.attr("keys")())) known.push_back(py::str(key));
  for (Index row = 0; const auto& name : names) {
    record.channels.push_back({name});
    const std::string argument = entry_of("y", name);
    if (std::ranges::find(known, name) == known.end()) {
      issues.add({}, "y: there is no channel '" + name + "'" + did_you_mean(name, known), "each sensor has its channel",
                 "name the sensor as the channel");
    } else if (const VectorXd values = vector_of(y[py::str(name)], argument); values.size() != grid.samples) {
      issues.add({}, argument + ": " + count_of(values.size(), "samples") + ", t has " + std::to_string(grid.samples),
                 "every channel has a value at every time", "write NaN where a sample is missing");
    } else {
      record.values.row(row) = values.transpose();
    }
    ++row;
  }
  issues.raise();
  return record;
}

Record from_array(const TimeGrid& grid, const py::object& y, const std::vector<std::string>& names) {
  const Column values = Column::ensure(y);
  if (!values) PyErr_Clear();
  const Index channels = !values || values.ndim() != 2 ? 1 : values.shape(1);
  if (!values || values.ndim() < 1 || values.ndim() > 2 || values.shape(0) != grid.samples ||
      channels != std::ssize(names))
    throw InvalidInput("y: " + (values ? "an array of shape " + std::string(py::str(py::getattr(values, "shape")))
                                       : std::string("no array of numbers")),
                       count_of(grid.samples, "times and ") + count_of(std::ssize(names), "sensors are given"),
                       "give an array of shape (samples, sensors), or a dictionary of name to samples");
  Record record{.sample_rate = grid.sample_rate, .start = grid.start};
  for (const auto& name : names) record.channels.push_back({name});
  record.values = Eigen::Map<const Eigen::MatrixXd>(values.data(), channels, grid.samples);  // rows there, columns here
  return record;
}

}  // namespace

TimeGrid grid_of(const py::object& t) {
  const VectorXd stamps = vector_of(t, "t");
  if (stamps.size() < 2)
    throw InvalidInput("t: " + count_of(stamps.size(), "times"), "at least two are needed", "give an array in seconds");
  if (!stamps.allFinite()) throw InvalidInput("t: a time is not finite", "", "give an array in seconds");
  const auto even = even_times(stamps);
  if (!even)
    throw InvalidInput("t: the times are not even", "a filter moves by equal steps",
                       "resample the record, with NaN where samples are missing");
  return {even->start, 1.0 / even->interval, stamps.size()};
}

Record record_of(const TimeGrid& grid, const py::object& y, const std::vector<std::string>& names) {
  return py::hasattr(y, "keys") ? from_mapping(grid, y, names) : from_array(grid, y, names);
}

}  // namespace kalfem::python
