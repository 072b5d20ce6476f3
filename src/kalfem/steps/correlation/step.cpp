// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/formats/measured_file_reader.hpp"
#include "kalfem/formats/measured_selection.hpp"
#include "kalfem/formats/test_points.hpp"
#include "kalfem/steps/correlation/outcome.hpp"
#include "kalfem/steps/correlation/report.hpp"
#include "kalfem/steps/run_step.hpp"
#include "kalfem/steps/updating/outcome.hpp"
#include "kalfem/study/updating_setup.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// The comparison's modes, where it has shapes.
const d::ModalData* with_shapes(const Located<d::Comparison>& comparison) {
  const auto* modes = std::get_if<d::ModalData>(&comparison.value.data);
  return modes && has_shapes(*modes) ? modes : nullptr;
}

/// The points of the comparison that the case puts on other nodes than their coordinates, where these are sure.
std::vector<std::string> contradictions(const d::ModeFile& given, const PlacedPoints& placed) {
  std::vector<std::string> found;
  const auto number = [&](Eigen::Index node) {
    return std::to_string(placed.part->elements.mesh.node_ids[static_cast<std::size_t>(node)]);
  };
  for (const auto& [place, sensor] : given.points) {
    const auto freedom = parse_freedom(sensor.value);
    if (!freedom || !freedom->node) continue;
    const auto point = std::ranges::find(placed.match.points, std::to_string(*freedom->node), &MatchedPoint::name);
    const auto named = std::ranges::find(placed.part->nodes, place.substr(0, place.find('.')), &NamedNode::name);
    if (point == placed.match.points.end() || named == placed.part->nodes.end() || !point->sure) continue;
    if (point->node != named->node)
      found.push_back("point " + point->name + " is given as " + named->name + " (node " + number(named->node) +
                      "), its coordinates say node " + number(point->node));
  }
  return found;
}

/// Points of a universal file's geometry at the nodes of the substructure.
std::optional<PlacedPoints> placed_points(const d::ModalData& given, const Study& study) {
  const auto* file = std::get_if<d::ModeFile>(&given.measured);
  const auto elements = std::ranges::find(study.structure->finite_elements, given.substructure.value,
                                          [](const auto& each) { return each.part->name; });
  if (!file || elements == study.structure->finite_elements.end()) return {};
  try {
    const auto* format = measured_format(file->file.value);
    if (!format || format->name != "universal file") return {};
    PlacedPoints placed{elements->part,
                        match_points(read_test_points(file->file.value), elements->part->elements.mesh)};
    placed.contradictions = contradictions(*file, placed);
    return placed;
  } catch (const InvalidInput&) {  // the file has no geometry, or too little of it
    return {};
  }
}

CorrelatedComparison compared(const std::string& name, const Study& study, const d::ModalData& given,
                              const Eigen::VectorXd& values) {
  const LinearModel model = study.updating_plan->structure->model_of(given.substructure.value)->at(values).model;
  auto measured = modal_measurement(given, model);
  std::vector<ShapeSensor> sensors;
  for (std::size_t i = 0; i < measured.sensors.size(); ++i)
    sensors.push_back({measured.sensors[i], measured.places[i]});
  CorrelationOptions options{.above = given.above};
  // An updating may start from less agreement than makes a pair.
  options.pairing.least_mac = std::max(options.pairing.least_mac, given.minimum_mac);
  auto correlation = correlate(measured.modes, measured.points, sensors, model, options);
  return {name,
          given.substructure.value,
          std::move(correlation),
          std::move(measured.modes),
          std::move(measured.points),
          given.above,
          placed_points(given, study)};
}

void run_correlation(RunContext& context) {
  const Study& study = context.study;
  const Stopwatch watch;
  CorrelationOutcome outcome{.comparisons = {}};
  const auto* updating = context.results.find<UpdatingOutcome>();
  outcome.updated = updating != nullptr;
  const Eigen::VectorXd values = updating ? updating->values : initial_values(study.updating->parameters);
  for (const auto& [name, comparison] : study.description->update->comparisons)
    if (const auto* given = with_shapes(comparison))
      outcome.comparisons.push_back(compared(name, study, *given, values));
  outcome.seconds = watch.seconds();
  context.results.put(std::move(outcome));
}

}  // namespace

RunStep correlation_step() {
  return {.name = "correlate",
          .meaning = "pair measured modes with those of the model: MAC, COMAC, mistakes of the set-up",
          .section = "update",
          .asked_for =
              [](const Study& study) {
                return study.updating &&
                       std::ranges::any_of(study.description->update->comparisons,
                                           [](const auto& each) { return with_shapes(each.second) != nullptr; });
              },
          .run = &run_correlation,
          .ran = &has_outcome<CorrelationOutcome>,
          .seconds = &seconds_of<CorrelationOutcome>,
          .summarise =
              [](const Study&, const StudyResults& results, nlohmann::ordered_json& summary) {
                summary["correlation"] = correlation_summary(results.get<CorrelationOutcome>());
              },
          .tell = [](const Study&,
                     const StudyResults& results) { return console_correlation(results.get<CorrelationOutcome>()); },
          .sections = [](const Study&, const StudyResults& results) -> std::vector<PlacedSection> {
            return {{PagePlace::updating, correlation_section(results.get<CorrelationOutcome>())}};
          }};
}

}  // namespace kalfem
