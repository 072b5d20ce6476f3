// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl/filesystem.h>

#include "bindings.hpp"
#include "calls.hpp"
#include "kalfem/api/finite_elements.hpp"
#include "kalfem/correlation/point_match.hpp"
#include "kalfem/formats/test_points.hpp"
#include "results.hpp"

namespace kalfem::python {
namespace {

Eigen::Vector3d place_of(const py::handle& given, const std::string& title) {
  const Eigen::VectorXd place = vector_of(given, title);
  if (place.size() != 3)
    throw InvalidInput(title + ": " + std::to_string(place.size()) + " coordinates", "a place is x, y, z in metres",
                       "give three");
  return place;
}

py::dict in_python(const PlaceFit& fit) {
  py::dict result;
  result["rotation"] = array_of(Eigen::MatrixXd(fit.rotation));
  result["shift"] = array_of(Eigen::VectorXd(fit.shift));
  result["scale"] = fit.scale;
  result["rms"] = fit.rms;
  return result;
}

py::dict matched(const FiniteElements& elements, const py::dict& places, const py::dict& axes, bool scale,
                 double noise) {
  std::vector<TestPoint> points;
  for (const auto& [name, place] : places) {
    TestPoint point{.name = py::str(name).cast<std::string>()};
    point.place = place_of(place, entry_of("points", point.name));
    if (axes.contains(name)) point.axes = axes[name].cast<Eigen::Matrix3d>();
    points.push_back(std::move(point));
  }
  const Mesh& mesh = elements.model().mesh;
  const auto match = match_points(points, mesh, {.scale = scale, .noise = noise});
  const auto number = [&](Eigen::Index node) -> py::object {
    if (node < 0) return py::none();
    return py::cast(mesh.node_ids[static_cast<std::size_t>(node)]);
  };
  py::dict result;
  py::list found, others;
  for (const auto& point : match.points) {
    py::dict entry;
    entry["name"] = point.name;
    entry["node"] = number(point.node);
    entry["distance"] = point.distance;
    entry["next_node"] = number(point.next);
    entry["next_distance"] = point.next_distance;
    entry["probability"] = point.probability;
    entry["sure"] = point.sure;
    entry["axes"] = array_of(Eigen::MatrixXd(point.axes));
    found.append(entry);
  }
  for (const auto& other : match.others) others.append(in_python(other));
  result["points"] = found;
  result["fit"] = in_python(match.fit);
  result["other_fits"] = others;
  result["noise"] = match.noise;
  return result;
}

py::tuple points_of_file(const std::filesystem::path& file, double unit) {
  py::dict places, axes;
  for (const auto& point : read_test_points(file, unit)) {
    places[py::str(point.name)] = array_of(Eigen::VectorXd(point.place));
    axes[py::str(point.name)] = array_of(Eigen::MatrixXd(point.axes));
  }
  return py::make_tuple(places, axes);
}

}  // namespace

void bind_match(py::module_& module) {
  module.def("match_points", &matched, py::arg("elements"), py::arg("points"), py::arg("axes"), py::arg("scale"),
             py::arg("noise"), "Points of a test at nodes: see kalfem.match_points.");
  module.def("read_test_points", &points_of_file, py::arg("file"), py::arg("unit"),
             "Places and axes of the points of a test's geometry: see kalfem.match_points.");
}

}  // namespace kalfem::python
