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
#include "kalfem/updating/frf_residual.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// The comparison's modes, where it has shapes.
const d::ModalData* with_shapes(const Located<d::Comparison>& comparison) {
  const auto* modes = std::get_if<d::ModalData>(&comparison.value.data);
  return modes && has_shapes(*modes) ? modes : nullptr;
}

/// The points of the comparison that the case puts on other nodes than their coordinates, where these are sure.
std::vector<std::string> contradictions(const d::ModeFile& given, const PlacedPoints& placed,
                                        const FiniteElementPart& part) {
  std::vector<std::string> found;
  const auto number = [&](Eigen::Index node) {
    return std::to_string(part.elements.mesh.node_ids[static_cast<std::size_t>(node)]);
  };
  for (const auto& [place, sensor] : given.points) {
    const auto freedom = parse_freedom(sensor.value);
    if (!freedom || !freedom->node) continue;
    const auto point = std::ranges::find(placed.match.points, std::to_string(*freedom->node), &MatchedPoint::name);
    const auto named = std::ranges::find(part.nodes, place.substr(0, place.find('.')), &NamedNode::name);
    if (point == placed.match.points.end() || named == part.nodes.end() || !point->sure) continue;
    if (point->node != named->node)
      found.push_back("point " + point->name + " is given as " + named->name + " (node " + number(named->node) +
                      "), its coordinates say node " + number(point->node));
  }
  return found;
}

/// Points of a universal file's geometry at the nodes of the substructure.
std::optional<PlacedPoints> placed_points(const d::ModalData& given, const FiniteElementPartPtr& part) {
  const auto* file = std::get_if<d::ModeFile>(&given.measured);
  if (!file || !part) return {};
  try {
    const auto* format = measured_format(file->file.value);
    if (!format || format->name != "universal file") return {};
    PlacedPoints placed{match_points(read_test_points(file->file.value), part->elements.mesh)};
    placed.contradictions = contradictions(*file, placed, *part);
    return placed;
  } catch (const InvalidInput&) {  // the file has no geometry, or too little of it
    return {};
  }
}

/// The mesh of the substructure; null: it has none.
FiniteElementPartPtr mesh_of(const std::string& substructure, const Study& study) {
  const auto elements = std::ranges::find(study.structure->finite_elements, substructure,
                                          [](const auto& each) { return each.part->name; });
  return elements == study.structure->finite_elements.end() ? nullptr : FiniteElementPartPtr(elements->part);
}

/// The degrees of freedom of a small model, the named points of a large one.
std::vector<ReportedPoint> reported_points(const LinearModel& model) {
  constexpr Eigen::Index few = 40;
  std::vector<ReportedPoint> reported;
  const auto add = [&](const std::string& name, const std::string& dof, double weight) {
    const auto place = std::ranges::find(model.dofs, dof);
    if (place != model.dofs.end()) reported.push_back({name, place - model.dofs.begin(), weight});
  };
  if (model.size() <= few)
    for (const auto& dof : model.dofs) add(dof, dof, 1.0);
  else
    for (const auto& [name, combination] : model.points)
      if (combination.size() == 1) add(name, combination.begin()->first, combination.begin()->second);
  return reported;
}

CorrelatedComparison compared(const std::string& name, const Study& study, const d::ModalData& given,
                              const Eigen::VectorXd& values) {
  const LinearModel model = study.updating_plan->structure->model_of(given.substructure.value)->at(values).model;
  auto measured = modal_measurement(given, model);
  std::vector<ShapeSensor> sensors;
  for (std::size_t i = 0; i < measured.sensors.size(); ++i)
    sensors.push_back({measured.sensors[i], measured.places[i]});
  CorrelationOptions options{.above = given.above, .expansion = given.expansion};
  // An updating may start from less agreement than makes a pair.
  options.pairing.least_mac = std::max(options.pairing.least_mac, given.minimum_mac);
  auto correlation = correlate(measured.modes, measured.points, sensors, model, options);
  auto part = mesh_of(given.substructure.value, study);
  return {.name = name,
          .substructure = given.substructure.value,
          .correlation = std::move(correlation),
          .measured = std::move(measured.modes),
          .points = std::move(measured.points),
          .above = given.above,
          .part = part,
          .placed = placed_points(given, part),
          .reported = reported_points(model)};
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
  for (const auto& comparison : study.updating_plan->comparisons)
    if (const auto* responses = finest_responses(comparison.continuation_steps))
      outcome.responses.push_back({comparison.name, agreement_of(*responses, values)});
  outcome.seconds = watch.seconds();
  context.results.put(std::move(outcome));
}

}  // namespace

RunStep correlation_step() {
  return {
      .name = "correlate",
      .meaning =
          "compare measured modes and frequency responses with those of the model: MAC, COMAC, FRAC, mistakes of the "
          "set-up",
      .section = "update",
      .asked_for =
          [](const Study& study) {
            return study.updating && std::ranges::any_of(study.description->update->comparisons, [](const auto& each) {
                     return with_shapes(each.second) || std::holds_alternative<d::FrfData>(each.second.value.data);
                   });
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
