// SPDX-License-Identifier: Apache-2.0
#include "calls.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/updating/mode_pairing.hpp"
#include "sensors.hpp"

namespace kalfem::python {
namespace {

py::tuple modes_of_structure(const Structure& structure, Eigen::Index count,
                             const std::optional<std::string>& substructure) {
  auto found = long_call(structure, py::none(), [&](const Progress&) {
    return substructure ? kalfem::modes_of(structure, *substructure, count) : modes(structure, count);
  });
  return py::make_tuple(found.dofs, array_of(std::move(found.frequencies)), array_of(std::move(found.damping)),
                        array_of(std::move(found.shapes)));
}

Eigen::MatrixXcd frf_of(const Structure& structure, const py::object& frequencies, const std::string& input,
                        const py::dict& outputs) {
  std::vector<OutputDescription> asked;
  for (const auto& [name, output] : outputs_of(outputs)) {
    asked.push_back(output);
    asked.back().name = name;
  }
  const Eigen::VectorXd lines = vector_of(frequencies, "frequencies");
  return long_call(structure, py::none(),
                   [&](const Progress&) { return frequency_responses(structure, lines, input, asked); });
}

template <class Kind>
Kind named(const char* argument, const std::string& name, const std::vector<std::pair<std::string, Kind>>& known) {
  std::vector<std::string> names;
  for (const auto& [each, kind] : known) {
    if (each == name) return kind;
    names.push_back(each);
  }
  throw InvalidInput(std::string(argument) + ": there is no '" + name + "'" + did_you_mean(name, names), "", "");
}

py::dict dict_of(const ComputedResponse& response) {
  const auto values = [](const Eigen::VectorXcd& found) {
    return found.size() > 0 ? array_of(Eigen::VectorXcd(found)) : py::object(py::none());
  };
  py::dict entry;
  entry["unit"] = response.unit;
  entry["full"] = values(response.full);
  entry["reduced"] = values(response.reduced);
  py::list peaks;
  for (const auto& [frequency, damping, magnitude] : response.peaks)
    peaks.append(py::make_tuple(frequency, damping, magnitude));
  entry["peaks"] = peaks;
  entry["difference"] = py::none();
  if (const auto& difference = response.difference)
    entry["difference"] = py::make_tuple(difference->at_resonances, difference->between, difference->between_at);
  return entry;
}

py::dict responses_of(const Structure& structure, const py::object& frequencies, const std::vector<std::string>& inputs,
                      const py::dict& outputs, const std::string& model, const std::string& method,
                      const py::object& progress) {
  FrequencyResponseOptions options{
      .frequencies = vector_of(frequencies, "frequencies"),
      .inputs = inputs,
      .outputs = {},
      .model = named<ResponseModel>(
          "model", model,
          {{"full", ResponseModel::full}, {"reduced", ResponseModel::reduced}, {"both", ResponseModel::both}}),
      .method = named<ResponseMethod>("method", method,
                                      {{"modal", ResponseMethod::modal}, {"direct", ResponseMethod::direct}})};
  for (const auto& [name, output] : outputs_of(outputs)) {
    options.outputs.push_back(output);
    options.outputs.back().name = name;
  }
  const auto found = long_call(structure, progress, [&](const Progress& report) {
    options.progress = report;
    return frequency_responses(structure, options);
  });
  py::list responses;
  for (const auto& response : found.responses) responses.append(dict_of(response));
  py::dict all;
  all["frequencies"] = array_of(Eigen::VectorXd(found.frequencies));
  all["responses"] = responses;
  all["warnings"] = found.warnings;
  return all;
}

Eigen::MatrixXcd shapes_of(const py::object& given, const char* argument) {
  using Shapes = py::array_t<std::complex<double>, py::array::f_style | py::array::forcecast>;
  const auto shapes = Shapes::ensure(given);
  if (!shapes) PyErr_Clear();
  if (!shapes || shapes.ndim() < 1 || shapes.ndim() > 2)
    throw InvalidInput(std::string(argument) + ": no array of shapes", "shapes are columns, points x modes",
                       "give an array of shape (points, modes), or (points,) of one mode");
  const Eigen::Index columns = shapes.ndim() == 1 ? 1 : shapes.shape(1);
  return Eigen::Map<const Eigen::MatrixXcd>(shapes.data(), shapes.shape(0), columns);
}

Eigen::MatrixXd mac(const py::object& a, const py::object& b) {
  const Eigen::MatrixXcd one = shapes_of(a, "a"), other = shapes_of(b, "b");
  if (one.rows() != other.rows())
    throw InvalidInput("b: shapes at " + std::to_string(other.rows()) + " points, a has " + std::to_string(one.rows()),
                       "shapes are compared point by point", "give both at the same points");
  return complex_mac_matrix(one, other);
}

}  // namespace

void bind_vibration(py::module_& module) {
  module.def("modes", &modes_of_structure, py::arg("structure"), py::arg("count"), py::arg("substructure"));
  module.def("frf", &frf_of, py::arg("structure"), py::arg("frequencies"), py::arg("input"), py::arg("outputs"));
  module.def("frequency_responses", &responses_of, py::arg("structure"), py::arg("frequencies"), py::arg("inputs"),
             py::arg("outputs"), py::arg("model"), py::arg("method"), py::arg("progress") = py::none());
  module.def("mac", &mac, py::arg("a"), py::arg("b"));
}

}  // namespace kalfem::python
