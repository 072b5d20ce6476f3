// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/model_check_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "kalfem/base/natural_order.hpp"
#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/gauges/nearest_place.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/pictures/mesh_picture.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

std::string vector_text(const Eigen::Vector3d& vector) {
  return fmt::format("{}, {}, {}", four_digits(vector[0]), four_digits(vector[1]), four_digits(vector[2]));
}

std::string motions_text(const GroundingCheck& grounding, bool strained) {
  static constexpr std::array names = {"x", "y", "z", "about x", "about y", "about z"};
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (grounding.motions[i].exists && grounding.motions[i].strained == strained)
      text += std::string(text.empty() ? "" : ", ") + names[i];
  return text.empty() ? "none" : text;
}

std::string matrix_text(const MatrixCheck& matrix) {
  std::string text = matrix.asymmetry < 1e-12 ? "symmetric" : fmt::format("not symmetric by {:.2g}", matrix.asymmetry);
  if (matrix.semi_definite) text += *matrix.semi_definite ? ", positive semi-definite" : ", indefinite";
  if (matrix.negative_diagonal > 0) text += fmt::format(", {} negative diagonal entries", matrix.negative_diagonal);
  if (matrix.empty_diagonal > 0) text += fmt::format(", {} empty rows", matrix.empty_diagonal);
  return text;
}

/// A cross where something is wrong.
std::vector<PictureMark> marks_of(const ModelCheckReport& report) {
  std::vector<PictureMark> marks;
  for (const auto& finding : report.findings)
    if (finding.severity != FindingSeverity::note)
      for (const auto node : finding.nodes) marks.push_back({MarkKind::finding, node, ""});
  return marks;
}

/// Where the degrees of freedom of matrices stand; nothing where the case gives no coordinates.
std::vector<PlacedDof> places_of(const FiniteElementPart& part) {
  const auto& mesh = part.elements.mesh;
  if (mesh.nodes.isZero(0.0)) return {};
  const auto scalars = mesh.node_sets.find(scalar_points);
  std::vector<PlacedDof> places;
  for (const auto& [node, direction] : part.assembled.dofs) {
    const bool is_scalar = scalars != mesh.node_sets.end() && std::ranges::count(scalars->second, node) > 0;
    places.push_back({mesh.nodes.col(node), is_scalar ? -1 : direction, mesh.axes_of(node)});
  }
  return places;
}

/// Nodes at which the rest of the structure joins the part.
std::vector<Index> joined_nodes(const FiniteElementPart& part) {
  std::vector<Index> nodes;
  const std::set<std::string> boundary(part.boundary.begin(), part.boundary.end());
  for (const auto& dof : part.assembled.dofs)
    if (boundary.contains(dof_name(part.elements.mesh, dof))) nodes.push_back(dof.node);
  return nodes;
}

/// What speaks against the model first, each kind in the order of the deck.
std::vector<DeckNote> by_weight(std::vector<DeckNote> notes) {
  std::ranges::stable_sort(notes, std::greater{}, &DeckNote::kind);
  return notes;
}

/// The rows in the natural order of the names in their first column.
Table by_name(Table table) {
  std::ranges::stable_sort(table.rows, natural_less, [](const auto& row) -> const std::string& { return row.front(); });
  return table;
}

/// A vector without what rounding leaves of its zeros: less than 1e-12 of `size`, which its entries have else.
Eigen::Vector3d without_rounding(const Eigen::Vector3d& values, double size) {
  return (values.array().abs() < 1e-12 * size).select(0.0, values.array()).matrix();
}

}  // namespace

ModelCheckReport model_check_of(const FiniteElementPart& part, const ModelCheckOptions& given) {
  ModelCheckOptions options = given;
  const auto joined = joined_nodes(part);
  options.joined.insert(options.joined.end(), joined.begin(), joined.end());
  if (part.elements.mesh.cells.empty() && !part.elements.matrices.empty())
    return check_model(part.full, places_of(part), options);
  // The stiffness of a preload resists turns of the whole: the elements are checked without it.
  if (part.preload_stiffness.size() > 0) return check_model(part.elements, assemble(part.elements), options);
  options.factor = part.factor;
  return check_model(part.elements, part.assembled, part.full.stiffness, part.full.mass, options);
}

Table findings_table(const ModelCheckReport& report) {
  Table table{"Findings", {"", "about", "found", "it follows", "to do"}, {}, {}};
  for (const auto& finding : report.findings)
    table.rows.push_back({to_string(finding.severity), to_string(finding.topic), finding.what,
                          finding.why.empty() ? "-" : finding.why, finding.fix.empty() ? "-" : finding.fix});
  return without_empty_columns(std::move(table));
}

Table properties_table(const ModelCheckReport& report) {
  Table table{"The whole", {"", "value"}, {}, {Align::left, Align::left}};
  const auto add = [&](const std::string& what, const std::string& value) { table.rows.push_back({what, value}); };
  add("nodes, cells, degrees of freedom",
      fmt::format("{}, {}, {}", report.nodes, report.cells, report.degrees_of_freedom));
  if (report.cells > 0)
    add("box [m]", fmt::format("{} to {}", vector_text(report.lowest), vector_text(report.highest)));
  if (report.mass) {
    const auto& [mass, centre, inertia] = *report.mass;
    add("mass [kg]", four_digits(mass));
    const double size = report.cells > 0 ? (report.highest - report.lowest).norm() : centre.norm();
    add("centre of gravity [m]", vector_text(without_rounding(centre, size)));
    if (report.moving_mass && report.moving_mass->minCoeff() < (1.0 - 1e-9) * mass)
      add("mass free to move along x, y, z [kg]", vector_text(*report.moving_mass));
    add("inertia about the centre of gravity: xx, yy, zz [kg m^2]", vector_text(inertia.diagonal()));
    add("inertia about the centre of gravity: xy, yz, xz [kg m^2]",
        vector_text(
            without_rounding({inertia(0, 1), inertia(1, 2), inertia(0, 2)}, inertia.diagonal().cwiseAbs().maxCoeff())));
  }
  if (report.grounding) {
    add("free rigid-body motions", motions_text(*report.grounding, false));
    add("restrained rigid-body motions", motions_text(*report.grounding, true));
  }
  add("directions held by supports", std::to_string(report.fixed_dofs));
  if (report.grounded_dofs > 0) add("degrees of freedom on springs to ground", std::to_string(report.grounded_dofs));
  add("stiffness matrix", matrix_text(report.stiffness_matrix));
  add("mass matrix", matrix_text(report.mass_matrix));
  if (report.parts.size() > 1) add("unconnected parts", std::to_string(report.parts.size()));
  if (report.coincident_pairs > 0)
    add("pairs of coincident nodes",
        fmt::format("{}, {} of them not connected", report.coincident_pairs, report.unjoined_pairs));
  if (report.free_nodes > 0) add("unconnected nodes", std::to_string(report.free_nodes));
  return table;
}

Table regions_table(const ModelCheckReport& report) {
  Table table{"Regions", {"region", "kind", "material", "cells", "length, area, volume", "mass [kg]"}, {}, {}};
  for (const auto& region : report.regions)
    table.rows.push_back({region.name, region.kind.empty() ? "none" : region.kind,
                          region.material.empty() ? "-" : region.material, std::to_string(region.cells),
                          four_digits(region.measure), four_digits(region.mass)});
  return by_name(std::move(table));
}

Table materials_table(const ModelCheckReport& report) {
  Table table{
      "Materials", {"material", "E [Pa]", "nu", "rho [kg/m^3]", "sqrt(E/rho) [m/s]", "resembles", "used by"}, {}, {}};
  for (const auto& material : report.materials) {
    std::string users;
    for (const auto& region : in_natural_order(material.used_by)) users += (users.empty() ? "" : ", ") + region;
    table.rows.push_back({material.name, four_digits(material.values.youngs_modulus),
                          four_digits(material.values.poissons_ratio), four_digits(material.values.density),
                          four_digits(material.wave_speed), material.resembles.empty() ? "-" : material.resembles,
                          users.empty() ? "nothing" : users});
  }
  return by_name(std::move(table));
}

Table quality_table(const ModelCheckReport& report) {
  Table table{"Element quality: worst value (number beyond the usual limit)", {"region"}, {}, {}};
  for (int m = 0; m < quality_measures; ++m) table.columns.push_back(to_string(static_cast<QualityMeasure>(m)));
  for (const auto& region : report.quality) {
    if (region.measured == 0) continue;
    auto& row = table.rows.emplace_back(std::vector<std::string>{region.region});
    for (const auto& measure : region.measures)
      row.push_back(four_digits(measure.worst) + (measure.beyond > 0 ? fmt::format(" ({})", measure.beyond) : ""));
  }
  return by_name(std::move(table));
}

Table places_table(const FiniteElementPart& part) {
  Table table{"Named nodes", {"name", "node", "at x, y, z [m]", "distance from the given place [m]"}, {}, {}};
  const auto& mesh = part.elements.mesh;
  const bool has_places = !mesh.nodes.isZero(0.0);  // matrices may come without
  for (const auto& [name, node, distance] : part.nodes)
    table.rows.push_back({name, std::to_string(mesh.node_ids[static_cast<std::size_t>(node)]),
                          has_places ? vector_text(mesh.nodes.col(node)) : "-",
                          distance ? four_digits(*distance) : "-"});
  return table;
}

Table gauges_table(const FiniteElementPart& part) {
  Table table{"Strain gauges", {"gauge", "element", "shape", "at x, y, z [m]", "along", "side"}, {}, {}};
  const auto& mesh = part.elements.mesh;
  for (const auto& gauge : part.gauges) {
    const Cell& cell = mesh.cells[static_cast<std::size_t>(gauge.cell)];
    const Eigen::Vector3d place = corner_places(mesh, cell) * corner_shares(cell.shape, gauge.natural);
    const std::string side = to_string(gauge.surface);
    table.rows.push_back({gauge.name, std::to_string(cell.id), to_string(cell.shape), vector_text(place),
                          vector_text(gauge.direction), side.empty() ? "-" : side});
  }
  return table;
}

Table notes_table(const std::vector<DeckNote>& notes) {
  Table table{"In the deck, but ignored", {"", "what", "first at", "times", "it follows"}, {}, {}};
  for (const auto& note : by_weight(notes))
    table.rows.push_back(
        {to_string(note.kind), note.what,
         note.where.line > 0 ? fmt::format("{}:{}", note.where.file, note.where.line) : note.where.file,
         std::to_string(note.count), note.consequence});
  return table;
}

std::string model_check_text(const ModelCheckReport& report, const std::vector<DeckNote>& notes) {
  std::string text;
  const auto add_note = [&](const DeckNote& note) {
    const bool is_missing = note.kind == DeckNoteKind::missing;
    text += std::string(to_string(note.kind)) + ": " +
            to_string(Issue{note.where, note_subject(note), note.consequence,
                            is_missing ? "to accept this in a case: accept_missing: [" + note.what + "]" : ""}) +
            "\n";
  };
  const auto ordered = by_weight(notes);
  const auto first_other =
      std::ranges::find_if(ordered, [](const auto& note) { return note.kind != DeckNoteKind::missing; });
  std::for_each(ordered.begin(), first_other, add_note);
  for (const auto& finding : report.findings)
    text += to_string(finding.severity) + ": " + to_string(Issue{{}, finding.what, finding.why, finding.fix}) + "\n";
  std::for_each(first_other, ordered.end(), add_note);
  if (!text.empty()) text += "\n";
  for (const auto& table :
       {properties_table(report), regions_table(report), materials_table(report), quality_table(report)})
    if (!table.rows.empty()) text += to_text(table) + "\n";
  return text;
}

Section model_check_section(const std::string& name, const FiniteElementModel& model, const ModelCheckReport& report,
                            const std::vector<DeckNote>& notes) {
  Section section{"Model check of '" + name + "'", "", {}};
  section.text = fmt::format("Errors: {}, warnings: {}, notes: {}.", report.count(FindingSeverity::error),
                             report.count(FindingSeverity::warning), report.count(FindingSeverity::note));
  if (!model.mesh.cells.empty())
    section.items.emplace_back(
        Picture{.title = "Mesh", .caption = "", .svg = mesh_picture_svg(model, {.marks = marks_of(report)})});
  for (auto table : {findings_table(report), properties_table(report), regions_table(report), materials_table(report),
                     quality_table(report), notes_table(notes)})
    if (!table.rows.empty()) section.items.emplace_back(std::move(table));
  return section;
}

}  // namespace kalfem
