// SPDX-License-Identifier: Apache-2.0
#include "bindings.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/measured_file_reader.hpp"
#include "results.hpp"

namespace kalfem::python {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Every sample at its own time: start + k interval, or as the file has it.
VectorXd times_of(const MeasuredChannel& channel) {
  if (channel.times.size() > 0) return channel.times;
  VectorXd times(channel.values.size());
  for (Index k = 0; k < times.size(); ++k) times[k] = channel.start + static_cast<double>(k) * channel.interval;
  return times;
}

py::dict place_of(const MeasuredPlace& place) {
  py::dict entry;
  entry["node"] = place.node ? py::object(py::int_(*place.node)) : py::none();
  entry["direction"] = place.direction;
  return entry;
}

const char* kind_of(MeasuredFunctionKind kind) {
  switch (kind) {
    case MeasuredFunctionKind::frequency_response:
      return "frequency response";
    case MeasuredFunctionKind::coherence:
      return "coherence";
    case MeasuredFunctionKind::auto_spectrum:
      return "auto spectrum";
    case MeasuredFunctionKind::cross_spectrum:
      return "cross spectrum";
    case MeasuredFunctionKind::other:
      break;
  }
  return "other";
}

py::dict entry_of(MeasuredChannel& channel) {
  py::dict entry;
  const bool timed = channel.times.size() > 0 || channel.interval > 0.0;
  entry["name"] = channel.name;
  entry["unit"] = channel.unit;
  entry["quantity"] = channel.quantity;
  entry["description"] = channel.description;
  entry["place"] = place_of(channel.place);
  entry["start"] = channel.start;
  entry["interval"] = channel.interval;
  entry["t"] = timed ? array_of(times_of(channel)) : py::none();
  entry["values"] = array_of(std::move(channel.values));
  return entry;
}

py::dict entry_of(MeasuredFunction& function) {
  py::dict entry;
  entry["name"] = function.name;
  entry["unit"] = function.unit;
  entry["kind"] = kind_of(function.kind);
  entry["description"] = function.description;
  entry["response"] = place_of(function.response);
  entry["reference"] = place_of(function.reference);
  entry["frequency"] = array_of(std::move(function.lines));
  entry["values"] = array_of(std::move(function.values));
  return entry;
}

py::dict entry_of(MeasuredShape& shape) {
  py::dict entry;
  entry["name"] = shape.name;
  entry["frequency"] = shape.frequency;
  entry["damping"] = shape.damping;
  entry["nodes"] = shape.nodes;
  entry["values"] = array_of(std::move(shape.values));
  return entry;
}

py::dict nodes_of(const std::vector<MeasuredNode>& nodes) {
  py::dict all;
  for (const auto& node : nodes) all[py::int_(node.number)] = node.position;
  return all;
}

template <class Parts>
py::list entries_of(Parts& parts) {
  py::list all;
  for (auto& part : parts) all.append(entry_of(part));
  return all;
}

py::dict read_file(const std::string& path, bool large) {
  MeasuredFile file = [&] {
    const py::gil_scoped_release released;
    return read_measured_file(path, {.large = large});
  }();
  py::dict content;
  content["format"] = file.format;
  content["description"] = file.description;
  content["channels"] = entries_of(file.channels);
  content["functions"] = entries_of(file.functions);
  content["shapes"] = entries_of(file.shapes);
  content["nodes"] = nodes_of(file.nodes);
  content["skipped"] = file.skipped;
  content["notes"] = file.notes;
  return content;
}

}  // namespace

void bind_formats(py::module_& module) {
  module.def("read", &read_file, py::arg("file"), py::arg("large") = false,
             "Everything that a measured file holds: see kalfem.read.");
  module.def(
      "unit_factor",
      [](const std::string& unit, const std::string& expected) { return parse_unit_as(unit, expected).factor; },
      py::arg("unit"), py::arg("expected"), "Factor that turns numbers of a unit into the SI unit of a quantity.");
}

}  // namespace kalfem::python
