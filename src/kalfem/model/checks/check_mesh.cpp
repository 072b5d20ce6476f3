#include <algorithm>
#include <cmath>

#include "kalfem/model/checks/single_checks.hpp"
#include "kalfem/model/mesh/cell_corners.hpp"
#include "kalfem/model/mesh/connectivity.hpp"

namespace kalfem::report {
namespace {

using Eigen::Index;
using Severity = FindingSeverity;
using Topic = FindingTopic;

constexpr std::size_t most_shown = 1000;

std::string node_name(const Mesh& mesh, Index node) {
  return "n" + std::to_string(mesh.node_ids[static_cast<std::size_t>(node)]);
}

std::string cell_name(const Mesh& mesh, Index index) {
  const Cell& cell = mesh.cells[static_cast<std::size_t>(index)];
  return to_string(cell.shape) + " " + std::to_string(cell.id);
}

std::vector<bool> touched_nodes(const FiniteElementModel& model) {
  std::vector<bool> touched(static_cast<std::size_t>(model.mesh.node_count()), false);
  visit_items(model, [&](std::span<const Index> nodes) {
    for (const auto node : nodes) touched[static_cast<std::size_t>(node)] = true;
  });
  return touched;
}

void add_node(const Mesh& mesh, Index node, std::vector<std::string>& names, ModelFinding& finding) {
  if (names.size() < most_named) names.push_back(node_name(mesh, node));
  if (finding.nodes.size() < most_shown) finding.nodes.push_back(node);
}

void check_free_nodes(const FiniteElementModel& model, const std::vector<bool>& touched, ModelCheckReport& report) {
  const Mesh& mesh = model.mesh;
  std::vector<bool> in_cell(touched.size(), false);
  for (const auto node : mesh.connectivity) in_cell[static_cast<std::size_t>(node)] = true;
  ModelFinding lone{Severity::note, Topic::mesh, "", "they do not move and carry no load",
                    "nothing, or remove them from the mesh"},
      inactive{Severity::warning, Topic::mesh, "", "these elements are not part of the model",
               "give their regions a property or remove them from the mesh"};
  std::vector<std::string> lone_names, inactive_names;
  Index lone_count = 0, inactive_count = 0;
  for (Index node = 0; node < mesh.node_count(); ++node) {
    const auto i = static_cast<std::size_t>(node);
    if (touched[i]) continue;
    ++(in_cell[i] ? inactive_count : lone_count);
    in_cell[i] ? add_node(mesh, node, inactive_names, inactive) : add_node(mesh, node, lone_names, lone);
  }
  report.free_nodes = lone_count + inactive_count;
  lone.what =
      "nothing is connected to " + std::to_string(lone_count) + " of the nodes: " + listed(lone_names, lone_count);
  inactive.what = std::to_string(inactive_count) +
                  " nodes belong only to elements without a property: " + listed(inactive_names, inactive_count);
  if (lone_count > 0) report.findings.push_back(lone);
  if (inactive_count > 0) report.findings.push_back(inactive);
}

void check_coincidence(const FiniteElementModel& model, const std::vector<bool>& touched, double part,
                       ModelCheckReport& report) {
  const Mesh& mesh = model.mesh;
  const double tolerance = part * (report.highest - report.lowest).norm();
  const auto pairs = coincident_nodes(mesh.nodes, touched, tolerance);
  const auto joined = directly_joined(model, pairs);
  report.coincident_pairs = static_cast<Index>(pairs.size());
  ModelFinding finding{
      Severity::warning, Topic::connections, "", "the parts that they belong to are not connected there",
      "merge the nodes or connect them by a link or spring, unless a joint without stiffness is intended"};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (joined[i]) continue;
    ++report.unjoined_pairs;
    const auto [one, other] = pairs[i];
    if (names.size() < most_named) names.push_back(node_name(mesh, one) + " and " + node_name(mesh, other));
    for (const auto node : {one, other})
      if (finding.nodes.size() < most_shown) finding.nodes.push_back(node);
  }
  finding.what = std::to_string(report.unjoined_pairs) + " pairs of nodes coincide (within " + to_string(tolerance) +
                 " m) and are not connected: " + listed(names, report.unjoined_pairs);
  if (report.unjoined_pairs > 0) report.findings.push_back(std::move(finding));
}

void check_parts(const FiniteElementModel& model, ModelCheckReport& report) {
  const auto parts = connected_parts(model);
  for (const auto& part : parts) report.parts.push_back(static_cast<Index>(part.size()));
  if (parts.size() < 2) return;
  ModelFinding finding{Severity::warning, Topic::connections, "", "they move independently",
                       "merge coincident nodes, or connect the parts by links, constraints or springs"};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& part = parts[i];
    if (names.size() < most_named)
      names.push_back(std::to_string(part.size()) + (part.size() == 1 ? " node" : " nodes") + " with " +
                      node_name(model.mesh, part.front()));
    if (i > 0)
      for (const auto node : part)
        if (finding.nodes.size() < most_shown) finding.nodes.push_back(node);
  }
  finding.what = "the structure consists of " + std::to_string(parts.size()) +
                 " unconnected parts: " + listed(names, static_cast<Index>(parts.size()));
  report.findings.push_back(std::move(finding));
}

/// Why a limit of a measure matters.
std::string consequence(QualityMeasure measure) {
  switch (measure) {
    case QualityMeasure::aspect_ratio:
      return "such elements are too stiff in bending and make the matrices ill-conditioned";
    case QualityMeasure::smallest_angle:
    case QualityMeasure::largest_angle:
      return "strains of elements with such corners are inaccurate";
    case QualityMeasure::warp:
      return "warped shells couple membrane and bending wrongly";
    case QualityMeasure::taper:
      return "such quadrilaterals are too stiff";
    case QualityMeasure::scaled_jacobian:
      return "elements near zero are almost flat or not convex; below zero they are inside out";
  }
  return "";
}

void tell_quality(const Mesh& mesh, const RegionQuality& quality, const QualityLimits& limits,
                  std::vector<ModelFinding>& findings) {
  for (const auto& of : quality.measures) {
    if (of.beyond == 0) continue;
    const bool inverted = of.measure == QualityMeasure::scaled_jacobian && of.worst <= 0.0;
    const bool many = of.beyond * 10 > quality.measured;
    std::vector<std::string> names;
    ModelFinding finding{inverted ? Severity::error
                         : many   ? Severity::warning
                                  : Severity::note,
                         Topic::elements, "", consequence(of.measure), "improve the mesh there"};
    for (const auto cell : of.worst_cells) {
      names.push_back(cell_name(mesh, cell));
      for (const auto node : mesh.nodes_of(mesh.cells[static_cast<std::size_t>(cell)])) finding.nodes.push_back(node);
    }
    finding.what = std::to_string(of.beyond) + " of " + std::to_string(quality.measured) + " elements of region '" +
                   quality.region + "' have " + (of.measure == QualityMeasure::aspect_ratio ? "an " : "a ") +
                   to_string(of.measure) + (is_worse_when_larger(of.measure) ? " above " : " below ") +
                   to_string(limits.limits[static_cast<std::size_t>(of.measure)]) + ", the worst " +
                   to_string(of.worst) + ": " + listed(names, of.beyond);
    findings.push_back(std::move(finding));
  }
}

/// Lines without length.
void check_lines(const Mesh& mesh, const std::string& region, double size, std::vector<ModelFinding>& findings) {
  std::vector<std::string> names;
  Index count = 0;
  for (const auto index : mesh.regions.at(region)) {
    const Cell& cell = mesh.cells[static_cast<std::size_t>(index)];
    if (dimension(cell.shape) != 1 || cell_measure(mesh, cell) > 1e-9 * size) continue;
    if (names.size() < most_named) names.push_back(cell_name(mesh, index));
    ++count;
  }
  if (count > 0)
    findings.push_back(
        {Severity::error, Topic::elements,
         std::to_string(count) + " beams of region '" + region + "' have no length: " + listed(names, count),
         "a beam needs an axis", "remove them or connect their nodes by a link"});
}

}  // namespace

void check_connections(const FiniteElementModel& model, const ModelCheckOptions& options, ModelCheckReport& report) {
  const auto touched = touched_nodes(model);
  check_free_nodes(model, touched, report);
  check_coincidence(model, touched, options.coincidence, report);
  check_parts(model, report);
}

void check_elements(const FiniteElementModel& model, const ModelCheckOptions& options, ModelCheckReport& report) {
  const double size = (report.highest - report.lowest).norm();
  for (const auto& [region, property] : model.properties) {
    if (!model.mesh.regions.contains(region)) continue;
    check_lines(model.mesh, region, size, report.findings);
    RegionQuality quality = region_quality(model.mesh, region, options.quality);
    if (quality.measured == 0) continue;
    tell_quality(model.mesh, quality, options.quality, report.findings);
    report.quality.push_back(std::move(quality));
  }
}

}  // namespace kalfem::report
