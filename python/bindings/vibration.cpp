// SPDX-License-Identifier: Apache-2.0
#include "calls.hpp"
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
  module.def("mac", &mac, py::arg("a"), py::arg("b"));
}

}  // namespace kalfem::python
