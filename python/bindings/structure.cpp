// SPDX-License-Identifier: Apache-2.0
#include "structure.hpp"

#include <algorithm>

#include "sensors.hpp"

namespace kalfem::python {

using Eigen::Index;

namespace {

SparseMatrix matrix_of(const py::object& given, const char* letter) {
  if (given.is_none()) return {};
  if (py::hasattr(given, "tocsc")) {
    py::object columns = given.attr("tocsc")();
    return columns.attr("astype")("float64").cast<SparseMatrix>();
  }
  const Column dense = Column::ensure(given);
  if (!dense) PyErr_Clear();
  if (!dense || dense.ndim() != 2)
    throw InvalidInput(
        std::string(letter) + ": " + (dense ? std::to_string(dense.ndim()) + " dimensions" : "no array of numbers"),
        "a matrix is needed", "give a NumPy array of shape (n, n), or a SciPy sparse matrix");
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const Rows>(dense.data(), dense.shape(0), dense.shape(1)).sparseView();
}

/// "1", "2", ... where there are no names.
std::vector<std::string> names_of(const py::object& names, Index count) {
  if (!names.is_none()) return names.cast<std::vector<std::string>>();
  std::vector<std::string> numbers;
  for (Index i = 1; i <= count; ++i) numbers.push_back(std::to_string(i));
  return numbers;
}

LumpedPart lumped_of(const std::string& name, const py::object& mass, const py::object& damping,
                     const py::object& stiffness, const py::object& names) {
  LumpedMatrices matrices{
      .mass = matrix_of(mass, "M"), .damping = matrix_of(damping, "C"), .stiffness = matrix_of(stiffness, "K")};
  matrices.dofs = names_of(names, std::max({matrices.mass.rows(), matrices.damping.rows(), matrices.stiffness.rows()}));
  return lumped(name, std::move(matrices));
}

std::vector<double> ratios_of(const py::object& given) {
  return py::isinstance<py::float_>(given) || py::isinstance<py::int_>(given) ? std::vector{given.cast<double>()}
                                                                              : given.cast<std::vector<double>>();
}

void bind_lumped(py::module_& module) {
  py::class_<LumpedPart>(module, "Lumped", py::dynamic_attr(),
                         "A substructure of masses, springs and matrices. Made by lumped() or chain().")
      .def("mass", &LumpedPart::mass, py::arg("dof"), py::arg("kilograms"), "Add a mass [kg] under its own name.",
           py::return_value_policy::reference_internal)
      .def("spring", &LumpedPart::spring, py::arg("name"), py::arg("start"), py::arg("end"), py::arg("stiffness"),
           py::arg("damping") = 0.0, "Add a spring [N/m] and dashpot [N s/m] between two masses or to the ``ground``.",
           py::return_value_policy::reference_internal)
      .def("ground", &LumpedPart::ground, py::arg("name"), "Add one more ground beside ``ground``.",
           py::return_value_policy::reference_internal)
      .def(
          "modal_damping",
          [](LumpedPart& self, const py::object& ratios) -> LumpedPart& {
            return self.modal_damping(ratios_of(ratios));
          },
          py::arg("ratios"), "Damping ratio of every mode, or one a mode; the last one holds for all further ones.",
          py::return_value_policy::reference_internal)
      .def("rayleigh_damping", &LumpedPart::rayleigh_damping, py::arg("alpha"), py::arg("beta"),
           "C = alpha M + beta K, alpha [1/s], beta [s].", py::return_value_policy::reference_internal)
      .def_property_readonly("name", [](const LumpedPart& self) { return self.description().name; })
      .def("__repr__", [](const LumpedPart& self) {
        const auto& part = self.description();
        return "<kalfem.Lumped '" + part.name + "', " + std::to_string(dofs_of(part).size()) + " degrees of freedom>";
      });
  module.def("lumped", &lumped_of, py::arg("name"), py::kw_only(), py::arg("M") = py::none(), py::arg("C") = py::none(),
             py::arg("K") = py::none(), py::arg("names") = py::none(), R"(A lumped substructure, from matrices or empty.

Parameters
----------
name : str
    Its points are ``name.dof``.
M, C, K : array or SciPy sparse matrix, shape (n, n)
    Mass [kg], damping [N s/m] and stiffness [N/m], symmetric.
names : list of str, optional
    Of the rows, ``"1"``, ``"2"``, ... if they are not given.

Returns
-------
Lumped
    Masses, springs, grounds and damping can be added: ``lumped("wheel").mass("w", 1.5).spring("k", "ground", "w", 2e4)``.
)");
  module.def("chain", &kalfem::chain, py::arg("name"), py::arg("masses"), py::arg("mass"), py::arg("stiffness"),
             py::arg("damping") = 0.0, R"(Equal masses in a row, joined by springs.

Parameters
----------
name : str
    Its points are ``name.1``, ``name.2``, ...
masses : int
    How many there are.
mass, stiffness, damping : float
    Of each mass [kg] and spring [N/m], [N s/m].
)");
}

/// A signal for an input, or none.
template <class Add>
Structure& add_input(const py::object& values, const py::object& sample_rate, double start, const std::string& name,
                     const Add& add) {
  if (values.is_none()) return add(nullptr);
  if (sample_rate.is_none())
    throw InvalidInput("input '" + name + "': its samples have no sampling rate", "", "give sample_rate in Hz");
  const Samples samples{vector_of(values, "values"), sample_rate.cast<double>(), start};
  return add(&samples);
}

void bind_inputs(py::class_<Structure>& structure) {
  constexpr auto internal = py::return_value_policy::reference_internal;
  structure
      .def(
          "base_displacement",
          [](Structure& self, const std::string& name, const std::string& ground, const py::object& values,
             const py::object& rate, double start) -> Structure& {
            return add_input(values, rate, start, name, [&](const Samples* samples) -> Structure& {
              return samples ? self.base_displacement(name, ground, *samples) : self.base_displacement(name, ground);
            });
          },
          py::arg("name"), py::arg("ground"), py::arg("values") = py::none(), py::kw_only(),
          py::arg("sample_rate") = py::none(), py::arg("start") = 0.0, internal,
          "Move a ground, ``wheel.ground``, by a known displacement [m]: samples now, or `inputs` of the call later.")
      .def(
          "base_velocity",
          [](Structure& self, const std::string& name, const std::string& ground, const py::object& values,
             const py::object& rate, double start) -> Structure& {
            return add_input(values, rate, start, name, [&](const Samples* samples) -> Structure& {
              return samples ? self.base_velocity(name, ground, *samples) : self.base_velocity(name, ground);
            });
          },
          py::arg("name"), py::arg("ground"), py::arg("values") = py::none(), py::kw_only(),
          py::arg("sample_rate") = py::none(), py::arg("start") = 0.0, internal,
          "Move a ground by its velocity [m/s], as a geophone measures it: the integral, without its drift.")
      .def(
          "base_acceleration",
          [](Structure& self, const std::string& name, const py::object& values, const py::object& rate,
             double start) -> Structure& {
            return add_input(values, rate, start, name, [&](const Samples* samples) -> Structure& {
              return samples ? self.base_acceleration(name, *samples) : self.base_acceleration(name);
            });
          },
          py::arg("name"), py::arg("values") = py::none(), py::kw_only(), py::arg("sample_rate") = py::none(),
          py::arg("start") = 0.0, internal,
          "Accelerate all grounds alike [m/s^2]; displacements are then relative to them.")
      .def(
          "force",
          [](Structure& self, const std::string& name, const std::string& point, const py::object& values,
             const py::object& rate, double start) -> Structure& {
            return add_input(values, rate, start, name, [&](const Samples* samples) -> Structure& {
              return samples ? self.force(name, point, *samples) : self.force(name, point);
            });
          },
          py::arg("name"), py::arg("point"), py::arg("values") = py::none(), py::kw_only(),
          py::arg("sample_rate") = py::none(), py::arg("start") = 0.0, internal, "Apply a known force to a point [N].");
}

/// "Structure(2 bodies, 1 connector, 1 input)".
std::string in_words(const Structure& structure) {
  const auto& given = structure.description();
  const auto counted = [](std::size_t count, const std::string& one, const std::string& many) {
    return std::to_string(count) + " " + (count == 1 ? one : many);
  };
  const auto bodies =
      given.parts.substructures.size() + given.finite_elements.size() + given.read.finite_elements.size();
  return "Structure(" + counted(bodies, "body", "bodies") + ", " +
         counted(given.parts.connectors.size(), "connector", "connectors") + ", " +
         counted(given.parts.inputs.size(), "input", "inputs") + ")";
}

/// What a table of the structure shows.
py::dict contents_of(const Structure& structure) {
  const auto& given = structure.description();
  const auto& parts = given.parts;
  py::list substructures, connectors, inputs;
  for (const auto& part : parts.substructures)
    substructures.append(py::make_tuple(part.name, "lumped", dofs_of(part).size()));
  for (const auto& part : given.finite_elements)
    substructures.append(py::make_tuple(part.name(), "finite elements", 6 * part.model().mesh.node_count()));
  for (const auto& each : given.read.finite_elements)
    substructures.append(py::make_tuple(each.part->name, "finite elements", 6 * each.part->elements.mesh.node_count()));
  for (const auto& connector : parts.connectors) {
    py::dict values;
    const auto& parameters = connector.law->parameters();
    for (std::size_t i = 0; i < parameters.size(); ++i)
      values[py::str(parameters[i].name)] =
          py::make_tuple(connector.parameters[static_cast<Index>(i)], parameters[i].unit);
    connectors.append(py::make_tuple(connector.name, connector.from, connector.to, connector.law->name(), values));
  }
  for (const auto& input : parts.inputs) {
    const bool of_velocity = std::ranges::find(given.by_velocity, input.name) != given.by_velocity.end();
    inputs.append(py::make_tuple(input.name, of_velocity ? "m/s" : unit_of(input.kind), input.target));
  }
  py::dict all;
  all["substructures"] = substructures;
  all["connectors"] = connectors;
  all["inputs"] = inputs;
  return all;
}

}  // namespace

NamedValues values_of(const py::dict& values, const std::string& argument) {
  NamedValues all;
  for (const auto& [name, value] : values) {
    const auto key = name.cast<std::string>();
    all.push_back({key, number_of(value, "", entry_of(argument, key))});
  }
  return all;
}

Structure driven(const Structure& structure, const py::dict& inputs, double start, double sample_rate, Index samples) {
  Structure moved = structure;
  IssueList issues;
  for (const auto& [name, values] : inputs) {
    const auto key = name.cast<std::string>();
    const std::string argument = entry_of("inputs", key);
    try {
      const Eigen::VectorXd of_input = vector_of(values, argument);
      if (of_input.size() != samples)
        issues.add({}, argument + ": " + std::to_string(of_input.size()) + " samples, t has " + std::to_string(samples),
                   "every input has a value at every time", "");
      else
        moved.drive(key, {of_input, sample_rate, start});
    } catch (const InvalidInput& error) {
      for (const auto& issue : error.issues()) {
        const bool named = issue.what.starts_with(argument);
        issues.add({}, named ? issue.what : argument + ": " + issue.what, issue.why, issue.fix);
      }
    }
  }
  issues.raise();
  return moved;
}

void bind_structure(py::module_& module) {
  constexpr auto internal = py::return_value_policy::reference_internal;
  bind_lumped(module);
  py::class_<Structure> structure(module, "Structure", py::dynamic_attr(),
                                  R"(A structure: substructures, connectors between their points, and inputs.

Points and parameters have names, ``wheel.w`` and ``suspension.k``. Names may appear in any order: they are looked up
when the structure is used, and all problems are then raised together.

>>> import kalfem as kf
>>> s = kf.Structure()
>>> _ = s.add(kf.chain("body", 3, mass=1.0, stiffness=3e4))
>>> _ = s.connect("mount", "body.1", "ground", law="k*x + k3*x**3 + c*v", parameters=dict(k=1e4, k3=1e8, c=20.0))
>>> s.value("mount.k3")
100000000.0
)");
  structure.def(py::init<>())
      .def(
          "add", [](Structure& self, const LumpedPart& part) -> Structure& { return self.add(part); }, py::arg("part"),
          internal, "Add a substructure: lumped(), chain() or read_deck().")
      .def(
          "add", [](Structure& self, const FiniteElements& part) -> Structure& { return self.add(part); },
          py::arg("part"), internal)
      .def(
          "connect",
          [](Structure& self, const std::string& name, const std::string& start, const std::string& end,
             const py::object& law, const py::dict& parameters) -> Structure& {
            return self.connect(name, start, end, law_of(law, values_of(parameters, "parameters")));
          },
          py::arg("name"), py::arg("start"), py::arg("end"), py::arg("law"), py::arg("parameters") = py::dict(),
          internal,
          R"(Add a connector between two points, or a point and a ground.

Parameters
----------
name : str
    Its parameters are ``name.k`` and so on.
start, end : str
    Points, ``body.1``, or grounds, ``wheel.ground``; ``ground`` never moves.
law : str or callable
    The name of a law of the library (:func:`kalfem.laws` lists them), a formula of the deformation ``x`` [m], its rate
    ``v`` [m/s] and its acceleration ``a`` [m/s^2] that gives the force [N], or a function ``f(x, v, *parameters)`` of
    arrays of shape (points,) that returns the forces. A function is slow: every step calls Python, all sigma points
    at once, and holds the GIL. A compiled one, ``double f(double x, double v, const double* parameters)``, is as fast
    as a law of C++: from ``numba.cfunc('float64(float64, float64, CPointer(float64))')``, or a function of a library
    that ctypes has loaded, with its ``argtypes`` and ``restype``. Functions have no internal states.
parameters : dict of str to float
    Values in SI units; of a function in the order of its arguments.
)")
      .def(
          "modal_damping",
          [](Structure& self, const py::object& ratios) -> Structure& { return self.modal_damping(ratios_of(ratios)); },
          py::arg("ratios"), internal, "Damp the modes of the whole structure by ratios to critical.")
      .def_property_readonly("parameters", &Structure::parameters,
                             "Names of all numbers that can be estimated or updated, such as ``suspension.k``.")
      .def_property_readonly("points", &Structure::points, "Names of all points for sensors and connectors.")
      .def_property_readonly("contents", &contents_of, R"(What the structure consists of.

A dictionary of lists of tuples: ``substructures`` (name, kind, degrees of freedom), ``connectors`` (name, start, end, law,
values with units), ``inputs`` (name, unit, target).)")
      .def("value", &Structure::value, py::arg("parameter"), "Value of a parameter [its SI unit].")
      .def(
          "at", [](const Structure& self, const py::dict& values) { return self.at(values_of(values, "values")); },
          py::arg("values"), "The structure at other values of its parameters; it stays as it is itself.")
      .def(
          "copy", [](const Structure& self) { return Structure(self); }, "An independent copy.")
      .def("_repr_html_",
           [](const py::object& self) { return py::module_::import("kalfem.display").attr("structure_html")(self); })
      .def("__repr__", &in_words);
  bind_inputs(structure);
}

}  // namespace kalfem::python
