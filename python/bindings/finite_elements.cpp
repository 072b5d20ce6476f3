// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "kalfem/base/units.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/formats/updated_deck.hpp"
#include "kalfem/formats/vtu.hpp"
#include "kalfem/model/statics/geometric_stiffness.hpp"
#include "kalfem/model/unit_system.hpp"
#include "sensors.hpp"

namespace kalfem::python {
namespace {

/// "mm t s": a unit of length, of mass and of time, in any order.
UnitSystem units_of(const std::string& words) {
  UnitSystem units;
  std::string word;
  const auto take = [&] {
    if (word.empty()) return;
    const Unit unit = parse_unit(word);
    const auto is = [&](const char* si) { return compatible(unit.dimension, parse_unit(si).dimension); };
    if (is("m"))
      units.length = unit.factor;
    else if (is("kg"))
      units.mass = unit.factor;
    else if (is("s"))
      units.time = unit.factor;
    else
      throw InvalidInput("units: '" + word + "' is no unit of length, mass or time", "these three give all others",
                         "write units=\"mm t s\"");
    word.clear();
  };
  for (const char c : words)
    if (c == ' ' || c == ',')
      take();
    else
      word += c;
  take();
  return units;
}

void name_node(FiniteElements& elements, const std::string& name, const py::handle& where) {
  if (py::isinstance<py::int_>(where)) {
    elements.node(name, where.cast<std::int64_t>());
    return;
  }
  const Eigen::VectorXd place = vector_of(where, entry_of("nodes", name));
  if (place.size() != 3)
    throw InvalidInput(entry_of("nodes", name) + ": " + std::to_string(place.size()) + " coordinates",
                       "a place is x, y, z in metres", "give three, or the number of the node");
  elements.node(name, Eigen::Vector3d(place));
}

MassKind mass_kind_named(const std::string& name) {
  if (name == "consistent") return MassKind::consistent;
  if (name == "lumped") return MassKind::lumped;
  throw InvalidInput("mass_matrix: '" + name + "' is given" + did_you_mean(name, {"consistent", "lumped"}), "",
                     "give consistent or lumped, or None for what the deck says");
}

/// What reading a deck gives: the substructure, and the notes of the reader.
FiniteElements read(const std::filesystem::path& file, const std::string& units, const py::object& name,
                    const py::dict& nodes, const std::vector<std::string>& accept, std::optional<std::int64_t> subcase,
                    const std::optional<std::string>& mass_matrix) {
  Deck deck = read_deck(file, {.subcase = subcase});
  if (mass_matrix) deck.model.mass_kind = mass_kind_named(*mass_matrix);
  IssueList issues;
  accept_missing(deck.notes, accept, issues);
  issues.raise();
  to_si(deck.model, units_of(units));
  if (deck.preload) {
    to_si(*deck.preload, units_of(units));
    deck.model.matrices.push_back(preload_matrices(deck.model, *deck.preload));
  }
  const std::string stem = file.stem().string();
  FiniteElements elements(name.is_none() ? stem : name.cast<std::string>(), deck.model);
  for (const auto& [set, members] : deck.model.mesh.node_sets)
    if (members.size() == 1 && set != scalar_points && !nodes.contains(set.c_str()))
      elements.node(set, deck.model.mesh.node_ids[static_cast<std::size_t>(members.front())]);
  for (const auto& [key, where] : nodes) name_node(elements, key.cast<std::string>(), where);
  return elements;
}

/// A path, or a pair of path and the matrix's name in it.
std::optional<NamedMatrixFile> matrix_file_of(const py::dict& given, const char* key) {
  if (!given.contains(key) || given[key].is_none()) return {};
  const py::object file = given[key];
  if (!py::isinstance<py::tuple>(file)) return NamedMatrixFile{file.cast<std::filesystem::path>()};
  const auto [path, name] = file.cast<std::pair<std::filesystem::path, std::string>>();
  return NamedMatrixFile{path, name};
}

void add_factor(FiniteElementModel& model, const std::string& name, const py::dict& given, const UnitSystem& units) {
  FactorMatrixFiles files{.stiffness = matrix_file_of(given, "stiffness"),
                          .mass = matrix_file_of(given, "mass"),
                          .damping = matrix_file_of(given, "damping"),
                          .units = units};
  double value = 1.0;
  for (const auto& [key, each] : given) {
    const auto argument = key.cast<std::string>();
    if (argument == "dofs")
      files.dof_map = each.cast<std::filesystem::path>();
    else if (argument == "directions")
      files.directions = each.cast<int>();
    else if (argument == "value")
      value = each.cast<double>();
    else if (argument != "stiffness" && argument != "mass" && argument != "damping")
      throw InvalidInput(entry_of("factors", name) + ": '" + argument + "' is given" +
                             did_you_mean(argument, {"stiffness", "mass", "damping", "dofs", "directions", "value"}),
                         "", "give stiffness, mass, damping, dofs, directions or value");
  }
  add_matrix_factor(model, name, files, value);
}

FiniteElements read_matrix_files(const std::vector<std::filesystem::path>& files,
                                 const std::optional<std::filesystem::path>& dofs, int directions,
                                 const std::string& name, const py::dict& nodes, const py::dict& factors,
                                 const std::optional<std::filesystem::path>& coordinates, const std::string& units) {
  const UnitSystem system = units_of(units);
  Deck deck = read_matrix_deck({.sets = {{.files = files, .dof_map = dofs, .directions = directions}},
                                .coordinates = coordinates,
                                .units = system});
  IssueList issues;
  for (const auto& [key, each] : factors) try {
      add_factor(deck.model, key.cast<std::string>(), each.cast<py::dict>(), system);
    } catch (const InvalidInput& error) {
      issues.add(error, {});
    }
  issues.raise();
  FiniteElements elements(name, std::move(deck.model));
  for (const auto& [key, where] : nodes) name_node(elements, key.cast<std::string>(), where);
  return elements;
}

FactorOf factor_of_named(const std::string& what) {
  if (what == "stiffness") return FactorOf::stiffness;
  if (what == "mass") return FactorOf::mass;
  if (what == "both") return FactorOf::both;
  throw InvalidInput("of: '" + what + "' is given" + did_you_mean(what, {"stiffness", "mass", "both"}), "",
                     "give stiffness, mass or both");
}

py::list notes_of(const std::filesystem::path& file) {
  py::list notes;
  for (const auto& note : read_deck(file).notes)
    notes.append(py::make_tuple(to_string(note.kind), note.what, note.consequence, note.count,
                                note.where.file + ":" + std::to_string(note.where.line)));
  return notes;
}

py::dict written_deck(const std::filesystem::path& file, const std::map<std::string, double>& values,
                      const std::filesystem::path& folder, const std::string& units,
                      std::optional<std::int64_t> subcase) {
  std::vector<DeckValue> wanted;
  for (const auto& [parameter, value] : values) wanted.push_back({parameter, value});
  const auto deck = updated_deck(file, wanted, {.subcase = subcase}, units_of(units));
  py::dict result;
  result["file"] = deck.texts.empty() ? py::object(py::none()) : py::cast(write_deck(deck, folder).string());
  py::list changes, unwritten;
  for (const auto& change : deck.changes) {
    py::dict entry;
    entry["parameter"] = change.parameter;
    entry["file"] = change.where.file;
    entry["line"] = change.where.line;
    entry["card"] = change.card;
    entry["field"] = change.field;
    entry["before"] = change.before;
    entry["after"] = change.after;
    entry["remark"] = change.remark;
    changes.append(entry);
  }
  for (const auto& left : deck.unwritten) {
    py::dict entry;
    entry["parameter"] = left.parameter;
    entry["why"] = left.why;
    entry["fix"] = left.fix;
    unwritten.append(entry);
  }
  result["changes"] = changes;
  result["unwritten"] = unwritten;
  return result;
}

ReductionMethod method_named(const std::string& name) {
  const std::vector<std::pair<std::string, ReductionMethod>> methods{{"craig_bampton", ReductionMethod::craig_bampton},
                                                                     {"rubin", ReductionMethod::rubin},
                                                                     {"macneal", ReductionMethod::macneal},
                                                                     {"guyan", ReductionMethod::guyan}};
  std::vector<std::string> known;
  for (const auto& [each, method] : methods) {
    if (each == name) return method;
    known.push_back(each);
  }
  throw InvalidInput("method: '" + name + "' is given" + did_you_mean(name, known), "",
                     "give craig_bampton, rubin, macneal or guyan");
}

FiniteElements reduced(const FiniteElements& self, std::optional<double> up_to, const py::list& boundary,
                       std::optional<Eigen::Index> modes, const std::string& method) {
  FiniteElements elements = self;
  std::vector<std::string> names;
  for (const auto& each : boundary) {
    if (!py::isinstance<py::int_>(each)) {
      names.push_back(each.cast<std::string>());
      continue;
    }
    names.push_back("n" + std::to_string(each.cast<std::int64_t>()));
    elements.node(names.back(), each.cast<std::int64_t>());
  }
  return elements.reduce({.method = method_named(method), .modes = {.count = modes, .cutoff = up_to}}, names);
}

/// A vector of that many numbers, named in messages.
Eigen::VectorXd numbers_of(const py::handle& given, const std::string& argument, Eigen::Index count) {
  Eigen::VectorXd values = vector_of(given, argument);
  if (values.size() != count)
    throw InvalidInput(argument + ": " + std::to_string(values.size()) + " numbers are given",
                       std::to_string(count) + " are needed", "");
  return values;
}

Layer layer_named(const std::string& surface, const std::string& gauge) {
  for (const Layer layer : {Layer::top, Layer::middle, Layer::bottom})
    if (surface == to_string(layer)) return layer;
  throw InvalidInput("strain gauge '" + gauge + "': surface is '" + surface + "'",
                     "a shell has a top, a middle and a bottom", "give one of these names");
}

FiniteElements with_gauge(const FiniteElements& self, const std::string& name, const py::object& where,
                          const py::object& direction, const std::optional<std::string>& surface,
                          const py::object& fibre, const std::string& region) {
  GaugeDescription gauge{.name = name, .region = region};
  if (surface) gauge.surface = layer_named(*surface, name);
  if (py::isinstance<py::int_>(where))
    gauge.place = where.cast<std::int64_t>();
  else
    gauge.place = Eigen::Vector3d(numbers_of(where, "where", 3));
  if (!direction.is_none()) gauge.direction = Eigen::Vector3d(numbers_of(direction, "direction", 3));
  if (!fibre.is_none()) gauge.fibre = Eigen::Vector2d(numbers_of(fibre, "fibre", 2));
  FiniteElements elements = self;
  return elements.gauge(std::move(gauge));
}

void write_mesh(const FiniteElements& self, const std::filesystem::path& file, const py::dict& fields) {
  std::vector<NodalField> shown;
  for (const auto& [name, values] : fields) shown.push_back({name.cast<std::string>(), values.cast<Eigen::MatrixXd>()});
  write_vtu(file, self.model().mesh, shown);
}

std::vector<double> ratios_of(const py::object& given) {
  if (py::isinstance<py::sequence>(given)) return given.cast<std::vector<double>>();
  return {given.cast<double>()};
}

}  // namespace

void bind_finite_elements(py::module_& module) {
  py::class_<FiniteElements>(module, "FiniteElements", py::dynamic_attr(),
                             R"(A finite-element substructure: methods give a changed copy. Made by read_deck().

Its points are ``name.node.x``; its parameters ``name.steel.youngs_modulus``, ``name.skin.thickness`` and so on.)")
      .def(
          "node",
          [](const FiniteElements& self, const std::string& name, const py::object& where) {
            FiniteElements elements = self;
            name_node(elements, name, where);
            return elements;
          },
          py::arg("name"), py::arg("where"), "Name a node, by its number in the mesh or the nearest place [m].")
      .def("gauge", &with_gauge, py::arg("name"), py::arg("where"), py::kw_only(), py::arg("direction") = py::none(),
           py::arg("surface") = py::none(), py::arg("fibre") = py::none(), py::arg("region") = "",
           R"(Bond a strain gauge to an element; its strain is ``strain("frame.g1")``.

Parameters
----------
name : str
where : int or (x, y, z)
    The element by its number, for its centre, or a place [m]: the nearest element.
direction : (x, y, z)
    In global axes; laid into the surface of a shell. Not needed on a beam.
surface : str
    ``top``, ``middle`` or ``bottom`` of a shell, by the element's normal; required there.
fibre : (y, z)
    Place in a beam's section from its centroid [m], in local axes.
region : str
    Only elements of this region count.
)")
      .def(
          "fix", [](FiniteElements self, const std::string& node) { return self.fix(node); }, py::arg("node"),
          "Hold all six motions of a named node.")
      .def(
          "factor",
          [](FiniteElements self, const std::string& name, const std::vector<std::string>& elements,
             const std::string& of, double value) { return self.factor(name, elements, factor_of_named(of), value); },
          py::arg("name"), py::arg("elements"), py::kw_only(), py::arg("of") = "stiffness", py::arg("value") = 1.0,
          R"(Give elements a factor, the parameter ``frame.west.factor``.

Parameters
----------
name : str
elements : list of str
    Sets of elements, regions, materials, or numbers of elements, ``"101-250"``.
of : {"stiffness", "mass", "both"}
    What of the elements it multiplies.
value : float
    Of the factor in the structure as given.
)")
      .def(
          "modal_damping",
          [](FiniteElements self, const py::object& ratios, double up_to) {
            return self.modal_damping(ratios_of(ratios), up_to);
          },
          py::arg("ratios"), py::arg("up_to") = 500.0,
          "Damping ratios, one a mode; the last one holds for further modes up to a frequency [Hz].")
      .def(
          "rayleigh_damping",
          [](FiniteElements self, double alpha, double beta) { return self.rayleigh_damping(alpha, beta); },
          py::arg("alpha"), py::arg("beta"), "C = alpha M + beta K, alpha [1/s], beta [s].")
      .def("reduce", &reduced, py::arg("up_to") = py::none(), py::arg("boundary") = py::list(), py::kw_only(),
           py::arg("modes") = py::none(), py::arg("method") = "craig_bampton",
           R"(Use a superelement instead of the full model.

Parameters
----------
up_to : float, optional
    Fixed-interface modes up to this frequency [Hz] are kept.
boundary : list of str or int
    Named nodes, ``"tip"`` (its translations) or ``"tip.rx"``, and nodes by their number, which get the name ``n12``.
    Points that connectors and forces touch are kept in any case.
modes : int, optional
    At least so many modes are kept.
method : str
    ``craig_bampton``, ``rubin``, ``macneal`` or ``guyan``.
)")
      .def(
          "natural_frequencies",
          [](const FiniteElements& self, Eigen::Index count) {
            const py::gil_scoped_release released;
            return natural_frequencies(self, count);
          },
          py::arg("count") = 10, "Lowest natural frequencies of the full model [Hz], shape (count,).")
      .def_property_readonly("name", &FiniteElements::name)
      .def_property_readonly(
          "node_positions",
          [](const FiniteElements& self) -> Eigen::MatrixXd { return self.model().mesh.nodes.transpose(); },
          "Coordinates of the nodes [m], shape (nodes, 3).")
      .def_property_readonly("node_numbers", [](const FiniteElements& self) { return self.model().mesh.node_ids; })
      .def("write_vtu", &write_mesh, py::arg("file"), py::arg("fields") = py::dict(), R"(Write the mesh for ParaView.

Parameters
----------
file : path
fields : dict of str to array, shape (components, nodes)
    Shown over the nodes.
)")
      .def("__repr__", [](const FiniteElements& self) {
        return "<kalfem.FiniteElements '" + self.name() + "', " + std::to_string(self.model().mesh.node_count()) +
               " nodes>";
      });
  module.def("read_deck", &read, py::arg("file"), py::kw_only(), py::arg("units") = "m kg s",
             py::arg("name") = py::none(), py::arg("nodes") = py::dict(),
             py::arg("accept") = std::vector<std::string>{}, py::arg("subcase") = py::none(),
             py::arg("mass_matrix") = py::none(),
             R"(Read a finite-element model of Nastran (.bdf) or of Abaqus and CalculiX (.inp).

Parameters
----------
file : path
units : str
    In which the deck is: a unit of length, of mass and of time, ``"mm t s"``.
name : str, optional
    Of the substructure; the file's name without its ending if it is not given.
nodes : dict of str to int or (x, y, z)
    Names of nodes, by their number or the nearest place [m]. Node sets of one node give it their name.
accept : list of str
    What the deck holds, and the model may lack: ``"*FRICTION"``.
subcase : int, optional
    SUBCASE of a Nastran deck whose structure is meant. A preload that the deck states (STATSUB, a static step before a
    perturbation) is part of the stiffness, as the matrices "preload".
mass_matrix : {"consistent", "lumped"}, optional
    In the place of what the deck says. Lumped beams of Nastran have no mass at their rotations; a simulation of the
    full model needs one there.
)");
  module.def("read_matrices", &read_matrix_files, py::arg("files"), py::kw_only(), py::arg("dofs") = py::none(),
             py::arg("directions") = 0, py::arg("name") = "matrices", py::arg("nodes") = py::dict(),
             py::arg("factors") = py::dict(), py::arg("coordinates") = py::none(), py::arg("units") = "m kg s",
             R"(A substructure from stiffness and mass matrices of another code, and factors of its parts.

Parameters
----------
files : list of path
    Matrix Market, OP4, DMIG, HDF5, MATLAB and so on. Which is stiffness, mass and damping follows from the usual names.
dofs : path, optional
    Degrees of freedom of the rows, where the files do not say them: ``node.direction`` or nodes alone, one a line.
directions : int
    Directions per node, where `dofs` lists nodes alone: 3 or 6.
name : str
    Of the substructure.
nodes : dict of str to int or (x, y, z)
    Names of nodes.
factors : dict of str to dict
    K = K_0 + sum a_i K_i, M and C likewise: the files ``stiffness``, ``mass``, ``damping`` of each (a path, or path and
    name of the matrix), ``value`` (1), and ``dofs``, ``directions`` where its rows are not those of `files`. Each is the
    parameter ``name.factor_name.factor``.
coordinates : path, optional
    Table (CSV) with node, x, y, z.
units : str
    Of all files, ``"mm t s"``.

Examples
--------
>>> bridge = kf.read_matrices(["K0.mtx", "M0.mtx"], dofs="rows.dof", factors={"piers": {"stiffness": "K1.mtx"}})  # doctest: +SKIP
)");
  module.def("deck_notes", &notes_of, py::arg("file"),
             "What a deck holds and the model does not use: tuples of kind, what, consequence, count and place.");
  module.def("write_updated_deck", &written_deck, py::arg("file"), py::arg("values"), py::arg("folder"), py::kw_only(),
             py::arg("units") = "m kg s", py::arg("subcase") = py::none(),
             R"(Write a deck with other values of some parameters, and everything else as it is, byte for byte.

Parameters
----------
file : path
    A deck of Nastran, Abaqus or CalculiX. Files that it includes are written beside it.
values : dict of str to float
    SI values of parameters as an updating names them, without the substructure: ``"mat7.youngs_modulus"``,
    ``"pshell3.thickness"``, ``"conm2_12.mass"``, ``"celas4.stiffness"``.
folder : path
units : str
    In which the deck is, ``"mm t s"``: fields keep them.
subcase : int, optional
    As for read_deck().

Returns
-------
dict
    ``file``, where the deck stands (None where nothing changes); ``changes``, a dict for each changed field
    (``parameter``, ``file``, ``line``, ``card``, ``field``, ``before``, ``after``, ``remark``); ``unwritten``, a dict
    for each value that no field states (``parameter``, ``why``, ``fix``).
)");
}

}  // namespace kalfem::python
