// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/place.hpp"
#include "calls.hpp"
#include "options.hpp"
#include "records.hpp"
#include "results.hpp"
#include "sensors.hpp"
#include "structure.hpp"

namespace kalfem::python {

namespace {

py::dict by_parameter(const PlaceResult& result, const Eigen::VectorXd& deviation) {
  py::dict all;
  for (std::size_t i = 0; i < result.parameters.size() && deviation.size() > 0; ++i)
    all[py::str(result.parameters[i])] = deviation[static_cast<Eigen::Index>(i)];
  return all;
}

/// Counted from one.
py::object rank_of(const std::optional<std::size_t>& rank) {
  return rank ? py::object(py::int_(*rank + 1)) : py::object(py::none());
}

py::list sets_of(const PlaceResult& result, const std::vector<SensorSet>& sets) {
  py::list all;
  for (const auto& set : sets) {
    py::dict entry;
    entry["sensors"] = set.sensors;
    entry["rank"] = rank_of(set.rank);
    entry["criterion"] = set.criterion;
    entry["std"] = by_parameter(result, set.std);
    entry["std_by_filter"] = by_parameter(result, set.std_by_filter);
    all.append(entry);
  }
  return all;
}

py::dict dict_of(const PlaceResult& result) {
  py::list candidates;
  for (const auto& each : result.candidates) {
    py::dict entry;
    entry["name"] = each.name;
    entry["kept"] = each.kept;
    entry["moves"] = each.moves;
    entry["rank"] = rank_of(each.rank);
    entry["std_left"] = each.std_left;
    candidates.append(entry);
  }
  py::dict all;
  all["best"] = sets_of(result, result.best);
  all["checked"] = sets_of(result, result.checked);
  all["candidates"] = candidates;
  all["remarks"] = result.remarks;
  all["exact"] = result.exact;
  return all;
}

py::dict place_sensors(const Structure& structure, const py::object& t, const py::dict& inputs,
                       const py::dict& arguments, const py::dict& choice, const py::object& progress) {
  const EstimateOptions estimate = options_of(structure, arguments);
  const TimeGrid grid = grid_of(t);
  PlaceOptions options{
      .candidates = estimate.sensors,
      .keep = choice["keep"].cast<std::vector<std::string>>(),
      .count = choice["count"].cast<int>(),
      .unknowns = estimate.unknowns,
      .parameters = choice["parameters"].cast<std::vector<std::string>>(),
      .duration = static_cast<double>(grid.samples - 1) / grid.sample_rate,
      .sample_rate = grid.sample_rate,
      .known_to = estimate.known_to,
      .process_noise = estimate.process_noise,
      .criterion = choice_of<PlacementCriterion>("criterion", choice["criterion"],
                                                 {{"d_optimality", PlacementCriterion::d_optimality},
                                                  {"a_optimality", PlacementCriterion::a_optimality},
                                                  {"e_optimality", PlacementCriterion::e_optimality},
                                                  {"expected_deviation", PlacementCriterion::expected_deviation},
                                                  {"mutual_information", PlacementCriterion::mutual_information}}),
      .draws = choice["draws"].cast<int>(),
      .seed = choice["seed"].cast<std::uint64_t>(),
      .threads = estimate.threads};
  const Structure moved = driven(structure, inputs, grid.start, grid.sample_rate, grid.samples);
  return dict_of(long_call(structure, progress, [&](const Progress& report) {
    options.progress = report;
    return place(moved, options);
  }));
}

}  // namespace

void bind_place(py::module_& module) {
  module.def("place", &place_sensors, py::arg("structure"), py::arg("t"), py::arg("inputs"), py::arg("arguments"),
             py::arg("choice"), py::arg("progress") = py::none(), "Sets of sensors, the best first: see kalfem.place.");
}

}  // namespace kalfem::python
