// SPDX-License-Identifier: Apache-2.0
#include "mode_sets.hpp"

#include "calls.hpp"
#include "kalfem/api/correlate.hpp"
#include "kalfem/api/update.hpp"
#include "kalfem/formats/mode_file.hpp"
#include "results.hpp"

namespace kalfem::python {
namespace {

using Eigen::Index;

/// One number a mode.
template <class Member>
Eigen::VectorXd column_of(const ModeSet& set, Member member) {
  Eigen::VectorXd values(std::ssize(set.modes));
  for (Index i = 0; i < values.size(); ++i) values[i] = set.modes[static_cast<std::size_t>(i)].*member;
  return values;
}

template <class Member>
void take_column(const py::dict& given, const char* key, Member member, ModeSet& set) {
  if (!given.contains(key) || given[key].is_none()) return;
  const Eigen::VectorXd values = vector_of(given[key], key);
  if (values.size() != std::ssize(set.modes))
    throw InvalidInput(std::string(key) + ": " + std::to_string(values.size()) + " values",
                       "there are " + std::to_string(set.modes.size()) + " frequencies", "give one a mode");
  for (std::size_t i = 0; i < set.modes.size(); ++i) set.modes[i].*member = values[static_cast<Index>(i)];
}

py::dict in_python(const ModeSet& set) {
  py::dict all, nodes;
  Eigen::MatrixXcd shapes(std::ssize(set.points), std::ssize(set.modes));
  for (Index i = 0; i < shapes.cols(); ++i) shapes.col(i) = set.modes[static_cast<std::size_t>(i)].shape;
  all["points"] = set.points;
  all["frequencies"] = array_of(column_of(set, &ModeSet::Mode::frequency));
  all["frequency_std"] = array_of(column_of(set, &ModeSet::Mode::frequency_std));
  all["dampings"] = array_of(column_of(set, &ModeSet::Mode::damping));
  all["damping_std"] = array_of(column_of(set, &ModeSet::Mode::damping_std));
  all["degrees_of_freedom"] = array_of(column_of(set, &ModeSet::Mode::degrees_of_freedom));
  all["shapes"] = array_of(shapes);
  if (!set.modes.empty() && set.modes.front().shape_covariance.size() > 0) {
    py::list covariances;
    for (const auto& mode : set.modes) covariances.append(array_of(mode.shape_covariance));
    all["covariances"] = covariances;
  }
  for (const auto& node : set.nodes)
    nodes[py::int_(node.number)] = py::make_tuple(node.position[0], node.position[1], node.position[2]);
  all["nodes"] = nodes;
  return all;
}

ModeSetOptions options_of(const py::dict& given) {
  return {.deviation = given["deviation"].cast<std::optional<double>>(),
          .shape_deviation = given["shape_deviation"].cast<std::optional<double>>(),
          .dampings = given["dampings"].cast<bool>(),
          .damping_deviation = given["damping_deviation"].cast<std::optional<double>>(),
          .max_complexity = given["max_complexity"].cast<double>()};
}

/// By the names of the arguments of kalfem.MeasuredModes.
py::dict measured(const py::dict& set, const std::string& substructure,
                  const std::vector<std::pair<std::string, std::string>>& points, const py::dict& options) {
  const auto modes = measured_modes(mode_set_of(set), substructure, points, options_of(options));
  const auto count = std::ssize(modes.frequencies);
  Eigen::VectorXd frequencies(count), std(count);
  for (Index i = 0; i < count; ++i) {
    frequencies[i] = modes.frequencies[static_cast<std::size_t>(i)].frequency;
    std[i] = modes.frequencies[static_cast<std::size_t>(i)].std;
  }
  py::dict all;
  all["substructure"] = modes.substructure;
  all["frequencies"] = array_of(frequencies);
  all["std"] = array_of(std);
  all["points"] = modes.points;
  all["sensors"] = modes.sensors;
  if (modes.shapes.size() > 0) all["shapes"] = array_of(modes.shapes);
  all["shape_std"] = modes.shape_std;
  if (!modes.shape_covariances.empty()) {
    py::list covariances;
    for (const auto& each : modes.shape_covariances) covariances.append(array_of(each));
    all["shape_covariances"] = covariances;
  }
  if (!modes.dampings.empty()) {
    all["dampings"] = modes.dampings;
    all["damping_std"] = modes.damping_stds;
  }
  return all;
}

ExpansionMethod expansion_of(const std::string& word) {
  for (const auto method : {ExpansionMethod::model, ExpansionMethod::serep, ExpansionMethod::dynamic})
    if (word == word_of(method)) return method;
  throw InvalidInput("expansion: there is no '" + word + "'", "", "give model, serep or dynamic");
}

/// By the names of the fields of kalfem.ShapeExpansion.
py::object in_python(const ShapeExpansion& expansion, const std::vector<std::string>& dofs) {
  if (expansion.shapes.empty()) return py::none();
  const auto columns = [&](Eigen::VectorXd ExpandedShape::*values) {
    Eigen::MatrixXd all(std::ssize(dofs), std::ssize(expansion.shapes));
    for (Index i = 0; i < all.cols(); ++i) all.col(i) = expansion.shapes[static_cast<std::size_t>(i)].*values;
    return array_of(all);
  };
  std::vector<std::size_t> pairs;
  std::vector<double> bands;
  for (const auto& shape : expansion.shapes) {
    pairs.push_back(shape.measured);
    bands.push_back(shape.band);
  }
  py::dict all;
  all["method"] = std::string(word_of(expansion.method));
  all["stiffness_error"] = expansion.mixing.stiffness_error;
  all["noise"] = expansion.mixing.noise;
  all["dofs"] = dofs;
  all["pairs"] = pairs;
  all["bands"] = bands;
  all["shapes"] = columns(&ExpandedShape::shape);
  all["std"] = columns(&ExpandedShape::deviation);
  all["model"] = columns(&ExpandedShape::model);
  return all;
}

py::list agreement_with(const Structure& given, const py::dict& responses) {
  Structure structure = given;
  py::list all;
  for (const auto& each : correlate(structure, measured_responses_of(structure, responses))) {
    py::dict entry;
    entry["name"] = each.name;
    entry["frac"] = each.frac;
    entry["size"] = each.size;
    entry["phase"] = each.phase;
    entry["is_turned"] = each.is_turned();
    all.append(entry);
  }
  return all;
}

py::dict correlated(const Structure& given, const py::dict& modes, const std::string& expansion) {
  Structure structure = given;
  const auto measured = measured_modes_of(structure, modes);
  const auto found = correlate(structure, measured, {.expansion = expansion_of(expansion)});
  py::list pairs, mistakes;
  py::dict comac, all;
  for (const auto& pair : found.pairs) {
    py::dict entry;
    entry["measured"] = pair.measured_frequency;
    entry["mode"] = pair.model_mode;
    entry["model"] = pair.model_mode ? py::object(py::float_(pair.model_frequency)) : py::none();
    entry["error"] = pair.model_mode ? py::object(py::float_(pair.relative_error)) : py::none();
    entry["mac"] = pair.mac;
    pairs.append(entry);
  }
  for (const auto& sensor : found.sensors) comac[py::str(sensor.name)] = sensor.comac;
  for (const auto& mistake : found.mistakes) {
    py::dict entry;
    entry["kind"] = std::string(word_of(mistake.kind));
    entry["sensors"] = mistake.sensors;
    entry["place"] = mistake.place;
    entry["text"] = mistake.in_words();
    entry["mac_before"] = mistake.mac_before;
    entry["mac_after"] = mistake.mac_after;
    entry["evidence"] = mistake.evidence;
    mistakes.append(entry);
  }
  all["pairs"] = pairs;
  all["frequencies"] = array_of(found.frequencies);
  all["mac"] = array_of(found.mac);
  all["auto_mac"] = array_of(found.auto_mac);
  all["orthogonality"] = found.orthogonality.size() > 0 ? array_of(found.orthogonality) : py::none();
  all["comac"] = comac;
  all["mistakes"] = mistakes;
  all["expansion"] = in_python(found.expansion, found.dofs);
  return all;
}

}  // namespace

ModeSet mode_set_of(const py::dict& given) {
  ModeSet set{.points = given["points"].cast<std::vector<std::string>>()};
  set.modes.resize(static_cast<std::size_t>(vector_of(given["frequencies"], "frequencies").size()));
  take_column(given, "frequencies", &ModeSet::Mode::frequency, set);
  take_column(given, "frequency_std", &ModeSet::Mode::frequency_std, set);
  take_column(given, "dampings", &ModeSet::Mode::damping, set);
  take_column(given, "damping_std", &ModeSet::Mode::damping_std, set);
  take_column(given, "degrees_of_freedom", &ModeSet::Mode::degrees_of_freedom, set);
  const auto shapes = given["shapes"].cast<Eigen::MatrixXcd>();
  if (shapes.rows() != std::ssize(set.points) || shapes.cols() != std::ssize(set.modes))
    throw InvalidInput("shapes: they are " + std::to_string(shapes.rows()) + " x " + std::to_string(shapes.cols()),
                       "there are " + std::to_string(set.points.size()) + " points and " +
                           std::to_string(set.modes.size()) + " frequencies",
                       "give one row a point");
  for (std::size_t i = 0; i < set.modes.size(); ++i) set.modes[i].shape = shapes.col(static_cast<Index>(i));
  if (given.contains("covariances") && !given["covariances"].is_none()) {
    const auto covariances = given["covariances"].cast<std::vector<Eigen::MatrixXd>>();
    for (std::size_t i = 0; i < set.modes.size(); ++i) {
      if (covariances.size() != set.modes.size() || covariances[i].rows() != 2 * shapes.rows() ||
          covariances[i].cols() != 2 * shapes.rows())
        throw InvalidInput("covariances: they do not fit", "each mode has one, 2 points x 2 points", "");
      set.modes[i].shape_covariance = covariances[i];
    }
  }
  return set;
}

void bind_mode_sets(py::module_& module) {
  module.def(
      "read_modes", [](const std::string& file) { return in_python(read_modes(file)); }, py::arg("file"),
      "Modes of a file: see kalfem.read_modes.");
  module.def("measured_modes", &measured, py::arg("modes"), py::arg("substructure"), py::arg("points"),
             py::arg("options"), "Modes as a comparison: see kalfem.ModeSet.measured.");
  module.def("correlate", &correlated, py::arg("structure"), py::arg("modes"), py::arg("expansion"),
             "Measured modes beside those of a model: see kalfem.correlate.");
  module.def("correlate_responses", &agreement_with, py::arg("structure"), py::arg("responses"),
             "Measured frequency responses beside those of a model: see kalfem.correlate_responses.");
}

}  // namespace kalfem::python
