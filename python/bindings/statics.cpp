// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/statics.hpp"
#include "calls.hpp"
#include "kalfem/base/units.hpp"
#include "sensors.hpp"

namespace kalfem::python {
namespace {

/// Three numbers in SI, or texts with a unit.
Eigen::Vector3d vector_of_units(const py::handle& given, const std::string& unit, const std::string& argument) {
  if (!py::isinstance<py::sequence>(given) || py::isinstance<py::str>(given)) {
    const Eigen::VectorXd values = vector_of(given, argument);
    if (values.size() == 3) return values;
  } else if (const auto values = given.cast<py::sequence>(); values.size() == 3) {
    Eigen::Vector3d vector;
    for (Eigen::Index i = 0; i < 3; ++i)
      vector[i] = number_of(py::object(values[static_cast<std::size_t>(i)]), unit, argument);
    return vector;
  }
  throw InvalidInput(argument + ": three numbers are needed", "a vector has x, y and z", "give three");
}

py::dict dict_named(const py::handle& given, const std::string& argument) {
  if (py::isinstance<py::dict>(given)) return given.cast<py::dict>();
  throw InvalidInput(argument + ": " + std::string(py::str(py::repr(given))) + " is given", "a dictionary is needed",
                     "");
}

/// Reads one load case of a dictionary.
class LoadsReader {
public:
  explicit LoadsReader(const std::string& name) : argument_(entry_of("cases", name)) { loads_.name = name; }

  StaticLoads read(const py::handle& given) {
    for (const auto& [key, value] : dict_named(given, argument_)) read(key.cast<std::string>(), value);
    return loads_;
  }

private:
  void read(const std::string& key, const py::handle& value) {
    const std::string place = argument_ + "['" + key + "']";
    if (key == "forces" || key == "moments") {
      for (const auto& [at, vector] : dict_named(value, place)) {
        const auto where = py::str(at).cast<std::string>();
        AppliedForce force{.at = where};
        (key == "forces" ? force.force : force.moment) =
            vector_of_units(vector, key == "forces" ? "N" : "N m", place + "['" + where + "']");
        loads_.forces.push_back(force);
      }
    } else if (key == "pressures") {
      for (const auto& [on, pressure] : dict_named(value, place))
        loads_.pressures.push_back({on.cast<std::string>(), number_of(pressure, "Pa", place)});
    } else if (key == "gravity") {
      loads_.gravity = vector_of_units(value, "m/s^2", place);
    } else if (key == "rotation") {
      read_rotation(dict_named(value, place), place);
    } else if (key == "displacements") {
      for (const auto& [dof, motion] : dict_named(value, place)) {
        const auto name = dof.cast<std::string>();
        const bool turns = name.substr(name.rfind('.') + 1).starts_with("r");
        loads_.displacements.emplace_back(name, number_of(motion, turns ? "rad" : "m", place));
      }
    } else {
      const std::vector<std::string> known{"forces", "moments", "pressures", "gravity", "rotation", "displacements"};
      throw InvalidInput(argument_ + ": there is no entry '" + key + "'" + did_you_mean(key, known), "",
                         "give forces, moments, pressures, gravity, rotation or displacements");
    }
  }

  void read_rotation(const py::dict& given, const std::string& place) {
    Rotation rotation;
    for (const auto& [key, value] : given) {
      const auto name = key.cast<std::string>();
      if (name == "axis")
        rotation.axis = vector_of_units(value, "", place);
      else if (name == "about")
        rotation.about = vector_of_units(value, "m", place);
      else if (name == "speed")
        rotation.speed = number_of(value, "rad/s", place);
      else
        throw InvalidInput(
            place + ": there is no entry '" + name + "'" + did_you_mean(name, {"axis", "about", "speed"}), "",
            "give axis, about and speed");
    }
    loads_.rotation = rotation;
  }

  std::string argument_;
  StaticLoads loads_;
};

py::dict dict_of(const SupportReaction& reaction) {
  py::dict entry;
  entry["force"] = array_of(Eigen::VectorXd(reaction.force));
  entry["moment"] = array_of(Eigen::VectorXd(reaction.moment));
  entry["about"] = array_of(Eigen::VectorXd(reaction.centre));
  return entry;
}

py::dict dict_of(const StaticsCase& solved) {
  py::dict nodes, reactions, entry;
  py::list peaks;
  for (const auto& each : solved.nodes) {
    py::dict node;
    node["displacement"] = array_of(Eigen::VectorXd(each.displacement));
    node["stress"] = each.stress ? array_of(Eigen::VectorXd(*each.stress)) : py::object(py::none());
    node["von_mises"] = each.von_mises;
    node["layer"] = to_string(each.layer);
    nodes[py::str(each.name)] = node;
  }
  for (const auto& each : solved.reactions) reactions[py::str(each.name)] = dict_of(each);
  for (const auto& each : solved.peaks) {
    py::dict peak;
    peak["region"] = each.region;
    peak["stress"] = each.stress;
    peak["element"] = each.element;
    peak["node"] = each.node;
    peak["layer"] = to_string(each.layer);
    peak["of_beam"] = each.of_beam;
    peaks.append(peak);
  }
  entry["displacements"] = array_of(Eigen::MatrixXd(solved.displacements.transpose()));
  entry["nodes"] = nodes;
  entry["peaks"] = peaks;
  entry["reactions"] = reactions;
  entry["applied"] = dict_of(solved.applied);
  entry["reaction_sum"] = dict_of(solved.reaction_sum);
  entry["imbalance"] = solved.imbalance;
  return entry;
}

py::tuple statics_of(const FiniteElements& elements, const py::dict& cases) {
  std::vector<StaticLoads> loads;
  IssueList issues;
  for (const auto& [name, given] : cases) try {
      loads.push_back(LoadsReader(name.cast<std::string>()).read(given));
    } catch (const InvalidInput& error) {
      issues.add(error, {});
    }
  issues.raise();
  const auto result = LongCall(py::none()).run([&](const Progress&) { return statics(elements, loads); });
  py::dict solved;
  for (const auto& each : result.cases) solved[py::str(each.name)] = dict_of(each);
  return py::make_tuple(solved, result.warnings);
}

}  // namespace

void bind_statics(py::module_& module) {
  module.def("statics", &statics_of, py::arg("elements"), py::arg("cases"),
             "Solved load cases by name, and warnings: see kalfem.statics.");
}

}  // namespace kalfem::python
