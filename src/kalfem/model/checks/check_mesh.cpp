// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/model/checks/model_check.hpp"
#include "kalfem/model/checks/single_checks.hpp"
#include "kalfem/model/mesh/connectivity.hpp"
#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem {
namespace {

using Eigen::Vector3d;
using Corners = Eigen::Matrix3Xd;

constexpr double coinciding = 1e9;  ///< aspect ratio where a side has no length
constexpr std::size_t worst_cells_told = 5;

double degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

double angle_between(const Vector3d& a, const Vector3d& b) { return degrees(std::atan2(a.cross(b).norm(), a.dot(b))); }

/// Corners of a face that are different nodes, in order.
std::vector<Vector3d> distinct_corners(const Mesh& mesh, const Cell& cell, const CornerRing& ring) {
  const auto nodes = mesh.nodes_of(cell);
  std::vector<Eigen::Index> kept;
  for (const int place : ring.places()) {
    const auto node = nodes[static_cast<std::size_t>(place)];
    if (std::ranges::find(kept, node) == kept.end()) kept.push_back(node);
  }
  std::vector<Vector3d> places;
  for (const auto node : kept) places.emplace_back(mesh.nodes.col(node));
  return places;
}

double aspect_ratio(const Mesh& mesh, const Cell& cell) {
  const auto nodes = mesh.nodes_of(cell);
  double shortest = std::numeric_limits<double>::infinity(), longest = 0.0;
  for (const auto& [a, b] : corner_sides(cell.shape)) {
    const auto one = nodes[static_cast<std::size_t>(a)], other = nodes[static_cast<std::size_t>(b)];
    if (one == other) continue;
    const double length = (mesh.nodes.col(one) - mesh.nodes.col(other)).norm();
    shortest = std::min(shortest, length);
    longest = std::max(longest, length);
  }
  if (longest == 0.0) return coinciding;
  return std::min(longest / shortest, coinciding);
}

/// Angles at the corners of a face, widening the range.
void widen(const std::vector<Vector3d>& face, double& smallest, double& largest) {
  const std::size_t n = face.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3d next = face[(i + 1) % n] - face[i], last = face[(i + n - 1) % n] - face[i];
    const double angle = next.isZero(0.0) || last.isZero(0.0) ? 0.0 : angle_between(next, last);
    smallest = std::min(smallest, angle);
    largest = std::max(largest, angle);
  }
}

Vector3d corner_normal(const std::vector<Vector3d>& face, std::size_t corner) {
  const std::size_t n = face.size();
  return (face[(corner + 1) % n] - face[corner]).cross(face[(corner + n - 1) % n] - face[corner]);
}

double warp(const std::vector<Vector3d>& face) {
  if (face.size() < 4) return 0.0;
  return std::max(angle_between(corner_normal(face, 0), corner_normal(face, 2)),
                  angle_between(corner_normal(face, 1), corner_normal(face, 3)));
}

double taper(const std::vector<Vector3d>& face) {
  if (face.size() < 4) return 1.0;
  double least = std::numeric_limits<double>::infinity(), sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double area = corner_normal(face, i).norm();
    least = std::min(least, area);
    sum += area;
  }
  return sum > 0.0 ? 4.0 * least / sum : 0.0;
}

// The scaled Jacobian is the least sine between two sides over the corners, against the mean normal, divided by that of
// the ideal corner (60 degrees in a triangle): 1 for the ideal shape, 0 for a flat corner, negative for a concave one.
/// Of a surface, its corners seen from the side of its mean normal.
double surface_jacobian(const std::vector<Vector3d>& face) {
  const std::size_t n = face.size();
  if (n < 3) return 0.0;
  Vector3d normal = Vector3d::Zero();
  for (std::size_t i = 0; i < n; ++i) normal += corner_normal(face, i);
  normal.normalize();
  double least = 1.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double lengths = (face[(i + 1) % n] - face[i]).norm() * (face[(i + n - 1) % n] - face[i]).norm();
    least = std::min(least, lengths > 0.0 ? corner_normal(face, i).dot(normal) / lengths : 0.0);
  }
  return n == 3 ? least * 2.0 / std::numbers::sqrt3 : least;
}

// The same in space: the triple product of the three sides at a corner over their lengths and the ideal corner's value.
// Corners of a collapsed cell, whose sides meet in one node, are left out: a wedge written as a hexahedron is no fault.
double solid_jacobian(const Mesh& mesh, const Cell& cell) {
  const auto nodes = mesh.nodes_of(cell);
  const auto neighbours = corner_neighbours(cell.shape);
  const double ideal = neighbours.size() == 4   ? std::numbers::sqrt2
                       : neighbours.size() == 6 ? 2.0 / std::numbers::sqrt3
                                                : 1.0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t corner = 0; corner < neighbours.size(); ++corner) {
    Eigen::Matrix3d edges;
    bool collapsed = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto other = nodes[static_cast<std::size_t>(neighbours[corner][i])];
      collapsed |= other == nodes[corner];
      edges.col(static_cast<Eigen::Index>(i)) = mesh.nodes.col(other) - mesh.nodes.col(nodes[corner]);
    }
    // Two sides that lead to one node span nothing either.
    for (std::size_t i = 0; i < 3; ++i)
      collapsed |= nodes[static_cast<std::size_t>(neighbours[corner][i])] ==
                   nodes[static_cast<std::size_t>(neighbours[corner][(i + 1) % 3])];
    if (collapsed) continue;
    const double lengths = edges.colwise().norm().prod();
    least = std::min(least, lengths > 0.0 ? ideal * edges.determinant() / lengths : 0.0);
  }
  return std::isfinite(least) ? least : 0.0;
}

}  // namespace

std::string to_string(QualityMeasure measure) {
  constexpr std::array names = {"aspect ratio", "smallest angle", "largest angle", "warp", "taper", "scaled Jacobian"};
  return names[static_cast<std::size_t>(measure)];
}

bool is_worse_when_larger(QualityMeasure measure) {
  return measure == QualityMeasure::aspect_ratio || measure == QualityMeasure::largest_angle ||
         measure == QualityMeasure::warp;
}

// Surfaces are measured on themselves, solids on each of their faces; a face that is collapsed to a side is left out.
// Aspect ratio and Jacobian belong to the whole cell.
CellQuality cell_quality(const Mesh& mesh, const Cell& cell) {
  double smallest = 180.0, largest = 0.0, most_warped = 0.0, most_tapered = 1.0, jacobian = 0.0;
  for (const auto& ring : corner_rings(cell.shape)) {
    const auto face = distinct_corners(mesh, cell, ring);
    if (face.size() < 3) continue;
    widen(face, smallest, largest);
    most_warped = std::max(most_warped, warp(face));
    most_tapered = std::min(most_tapered, taper(face));
    if (dimension(cell.shape) == 2) jacobian = surface_jacobian(face);
  }
  if (dimension(cell.shape) == 3) jacobian = solid_jacobian(mesh, cell);
  return {aspect_ratio(mesh, cell), std::min(smallest, largest), largest, most_warped, most_tapered, jacobian};
}

// One pass over a region: per measure the worst value, the mean, and how many cells are beyond the limit. Of those only
// the few worst are kept for the message.
RegionQuality region_quality(const Mesh& mesh, const std::string& region, const QualityLimits& limits) {
  RegionQuality quality{.region = region, .cells = {}, .measures = {}};
  std::array<std::vector<std::pair<double, Eigen::Index>>, quality_measures> bad;
  for (int m = 0; m < quality_measures; ++m)
    quality.measures[static_cast<std::size_t>(m)].measure = static_cast<QualityMeasure>(m);
  const auto cells = mesh.regions.find(region);
  if (cells == mesh.regions.end()) return quality;
  for (const auto index : cells->second) {
    const Cell& cell = mesh.cells[static_cast<std::size_t>(index)];
    ++quality.cells[cell.shape];
    if (dimension(cell.shape) < 2) continue;
    const CellQuality values = cell_quality(mesh, cell);
    for (std::size_t m = 0; m < values.size(); ++m) {
      auto& of = quality.measures[m];
      const double sign = is_worse_when_larger(of.measure) ? 1.0 : -1.0;
      if (quality.measured == 0 || sign * values[m] > sign * of.worst) of.worst = values[m];
      of.mean += values[m];
      if (sign * values[m] <= sign * limits.limits[m]) continue;
      ++of.beyond;
      bad[m].emplace_back(-sign * values[m], index);
    }
    ++quality.measured;
  }
  for (std::size_t m = 0; m < bad.size(); ++m) {
    auto& of = quality.measures[m];
    if (quality.measured > 0) of.mean /= static_cast<double>(quality.measured);
    const auto told = std::min(worst_cells_told, bad[m].size());
    std::ranges::partial_sort(bad[m], bad[m].begin() + static_cast<std::ptrdiff_t>(told));
    for (std::size_t i = 0; i < told; ++i) of.worst_cells.push_back(bad[m][i].second);
  }
  return quality;
}

}  // namespace kalfem

namespace kalfem::report {
namespace {

using Eigen::Index;
using Severity = FindingSeverity;
using Topic = FindingTopic;

std::string node_name(const Mesh& mesh, Index node) {
  return "n" + std::to_string(mesh.node_ids[static_cast<std::size_t>(node)]);
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

// Nodes that nothing touches, and nodes of cells without a property: the first are harmless, the second are often a
// region that was forgotten.
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

// Two nodes at one place that nothing joins are mostly a crack that the mesher left. Pairs that an element, a link or a
// spring joins on purpose are not told.
void check_coincidence(const FiniteElementModel& model, std::vector<bool> touched, double part,
                       ModelCheckReport& report) {
  const Mesh& mesh = model.mesh;
  if (const auto scalars = mesh.node_sets.find(scalar_points); scalars != mesh.node_sets.end())
    for (const auto node : scalars->second) touched[static_cast<std::size_t>(node)] = false;  // they have no place
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

// Parts that each are held, or joined by something outside the model, such as the connectors of a case, are legitimate:
// whether a support holds all motions of its part is a question of mechanisms.
void check_parts(const FiniteElementModel& model, const std::vector<Index>& joined, ModelCheckReport& report) {
  const auto parts = connected_parts(model);
  for (const auto& part : parts) report.parts.push_back(static_cast<Index>(part.size()));
  if (!has_loose_parts(model, parts, joined)) return;
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
      return "elements near zero are almost flat, below zero they are folded at a corner: strains there are inaccurate";
  }
  return "";
}

// Severity follows from what the measure does: an element that is folded at a corner, or many beyond a limit, are a
// warning. Elements whose Jacobian is not positive at an integration point are refused by the assembly.
void tell_quality(const Mesh& mesh, const RegionQuality& quality, const QualityLimits& limits,
                  std::vector<ModelFinding>& findings) {
  for (const auto& of : quality.measures) {
    if (of.beyond == 0) continue;
    const bool folded = of.measure == QualityMeasure::scaled_jacobian && of.worst <= 0.0;
    const bool many = of.beyond * 10 > quality.measured;
    std::vector<std::string> names;
    ModelFinding finding{folded || many ? Severity::warning : Severity::note, Topic::elements, "",
                         consequence(of.measure), "improve the mesh there"};
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

std::string cell_name(const Mesh& mesh, Index index) {
  const Cell& cell = mesh.cells[static_cast<std::size_t>(index)];
  return to_string(cell.shape) + " " + std::to_string(cell.id);
}

void check_connections(const FiniteElementModel& model, const ModelCheckOptions& options, ModelCheckReport& report) {
  const auto touched = touched_nodes(model);
  check_free_nodes(model, touched, report);
  check_coincidence(model, touched, options.coincidence, report);
  check_parts(model, options.joined, report);
}

void check_elements(const FiniteElementModel& model, const ModelCheckOptions& options, ModelCheckReport& report) {
  if (auto coincident = coincident_elements_finding(model)) report.findings.push_back(std::move(*coincident));
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
