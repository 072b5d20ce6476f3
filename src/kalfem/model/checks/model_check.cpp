#include "kalfem/model/checks/model_check.hpp"

#include <algorithm>
#include <set>

#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/model/assembly/mechanisms.hpp"
#include "kalfem/model/checks/single_checks.hpp"
#include "kalfem/model/model_items.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Severity = FindingSeverity;
using Topic = FindingTopic;

constexpr double follows_rigidly = 1e-6;  ///< of the size of the motion

std::vector<PlacedDof> placed(const FiniteElementModel& model, const std::vector<NodalDof>& dofs) {
  std::vector<PlacedDof> list;
  list.reserve(dofs.size());
  for (const auto& dof : dofs) list.push_back({model.mesh.nodes.col(dof.node), dof.direction});
  return list;
}

/// Directions of nodes that supports and constraints speak of, by position among all.
std::vector<bool> named_dofs(const FiniteElementModel& model, const AssembledModel& assembled) {
  std::vector<bool> named(static_cast<std::size_t>(6 * model.mesh.node_count()), false);
  for (Index j = 0; j < assembled.expansion.cols(); ++j)
    for (SparseMatrix::InnerIterator it(assembled.expansion, j); it; ++it)
      named[static_cast<std::size_t>(it.row())] = true;
  for (const auto& support : model.fixed)
    for (const auto node : support.nodes)
      for (int d = 0; d < 6; ++d)
        if (support.directions[static_cast<std::size_t>(d)]) named[static_cast<std::size_t>(6 * node + d)] = true;
  for (const auto& constraint : model.constraints)
    for (const auto& [dof, coefficient] : constraint.terms)
      named[static_cast<std::size_t>(6 * dof.node + dof.direction)] = true;
  return named;
}

/// Nodes that do not follow the rigid-body motions of the free degrees of freedom: they are fixed, or tied to what is.
std::vector<bool> nodes_that_stay(const FiniteElementModel& model, const AssembledModel& assembled,
                                  const RigidFrame& frame, const MatrixXd& motions) {
  const MatrixXd moved = assembled.expansion * motions;
  const auto named = named_dofs(model, assembled);
  std::vector<bool> stays(static_cast<std::size_t>(model.mesh.node_count()), false);
  for (std::size_t i = 0; i < named.size(); ++i) {
    const auto row = static_cast<Index>(i);
    if (!named[i]) continue;
    const auto rigid = rigid_motion({model.mesh.nodes.col(row / 6), static_cast<int>(row % 6)}, frame);
    if ((moved.row(row) - rigid).cwiseAbs().maxCoeff() > follows_rigidly) stays[i / 6] = true;
  }
  for (const auto& link : model.links)
    if (stays[static_cast<std::size_t>(link.master)])
      for (const auto slave : link.slaves) stays[static_cast<std::size_t>(slave)] = true;
  return stays;
}

/// Free degrees of freedom at which a rigid-body motion meets resistance rightly.
std::vector<bool> expected_forces(const FiniteElementModel& model, const AssembledModel& assembled,
                                  const std::vector<bool>& stays) {
  std::vector<bool> near(stays);  // nodes that share an element or another item with one that stays
  visit_items(model, [&](std::span<const Index> nodes) {
    const auto stay = [&](Index node) { return stays[static_cast<std::size_t>(node)]; };
    if (std::ranges::any_of(nodes, stay))
      for (const auto node : nodes) near[static_cast<std::size_t>(node)] = true;
  });
  std::vector<bool> expected(static_cast<std::size_t>(assembled.size()), false);
  for (Index j = 0; j < assembled.expansion.cols(); ++j)
    for (SparseMatrix::InnerIterator it(assembled.expansion, j); it; ++it)
      if (near[static_cast<std::size_t>(it.row() / 6)]) expected[static_cast<std::size_t>(j)] = true;
  for (const auto& ground : assembled.grounds)
    for (Index i = 0; i < ground.stiffness.size(); ++i)
      if (ground.stiffness[i] != 0.0) expected[static_cast<std::size_t>(i)] = true;
  return expected;
}

Index count_fixed(const FiniteElementModel& model) {
  std::set<NodalDof> fixed;
  for (const auto& support : model.fixed)
    for (const auto node : support.nodes)
      for (int d = 0; d < 6; ++d)
        if (support.directions[static_cast<std::size_t>(d)]) fixed.insert({node, d});
  return static_cast<Index>(fixed.size());
}

void find_the_mechanisms(const FiniteElementModel& model, const AssembledModel& assembled,
                         const SparseMatrix& stiffness, ModelCheckReport& report) {
  try {
    report.mechanisms = find_mechanisms(model, assembled);
    report.stiffness_matrix.semi_definite = true;
  } catch (const InvalidInput&) {  // indefinite, or singular with large rounding
    const Index failing = report::indefinite_dof(stiffness);
    report.stiffness_matrix.semi_definite = failing < 0;
    if (failing < 0)
      report.findings.push_back({Severity::note, Topic::stiffness, "mechanisms were not looked for",
                                 "the stiffness matrix is too near to singular to be factored", ""});
    else
      report.findings.push_back({Severity::error, Topic::stiffness,
                                 "the stiffness matrix is indefinite, which shows first at " +
                                     dof_name(model.mesh, assembled.dofs[static_cast<std::size_t>(failing)]),
                                 "some motion would have negative energy",
                                 "check negative stiffnesses, and matrices from other codes"});
    return;
  }
  const auto count = static_cast<Index>(report.mechanisms.size());
  if (count > 0)
    report.findings.push_back({Severity::warning, Topic::connections,
                               std::to_string(count) + " motions beside those of the rigid body need no force, at " +
                                   report::listed(report.mechanisms, count),
                               "they are mechanisms: hinges, rotations that nothing holds, parts that hang on nothing",
                               "hold, join or fix these degrees of freedom unless they are meant to move"});
}

/// What the assembled matrices say about mass, supports and mechanisms.
void check_motion(const FiniteElementModel& model, const AssembledModel& assembled, const SparseMatrix& stiffness,
                  const std::vector<std::string>& names, const ModelCheckOptions& options, ModelCheckReport& report) {
  report.mass = mass_properties(assembled);
  report.moving_mass = moving_mass(model, assembled);
  report::tell_mass(*report.mass, *report.moving_mass, report.lowest, report.highest, report.findings);
  const RigidFrame frame = report::frame_of(report);
  const MatrixXd motions = rigid_motions(placed(model, assembled.dofs), frame);
  const auto stays = nodes_that_stay(model, assembled, frame, motions);
  report.grounding = check_grounding(stiffness, motions, expected_forces(model, assembled, stays));
  const bool supported = report.fixed_dofs > 0 || report.grounded_dofs > 0 || std::ranges::count(stays, true) > 0;
  report.stray_dofs = report::tell_grounding(*report.grounding, supported, names, report.findings);
  if (options.mechanisms && report.stiffness_matrix.negative_diagonal == 0)
    find_the_mechanisms(model, assembled, stiffness, report);
}

}  // namespace

std::string to_string(FindingTopic topic) {
  constexpr std::array names = {"mesh", "elements",  "materials", "units",
                                "mass", "stiffness", "grounding", "connections"};
  return names[static_cast<std::size_t>(topic)];
}

std::string to_string(FindingSeverity severity) {
  constexpr std::array names = {"note", "warning", "error"};
  return names[static_cast<std::size_t>(severity)];
}

Index ModelCheckReport::count(FindingSeverity severity) const {
  return std::ranges::count(findings, severity, &ModelFinding::severity);
}

ModelCheckReport check_model(const FiniteElementModel& model, const AssembledModel& assembled,
                             const ModelCheckOptions& options) {
  ModelCheckReport report;
  report.nodes = model.mesh.node_count();
  report.cells = static_cast<Index>(model.mesh.cells.size());
  report.degrees_of_freedom = assembled.size();
  report.fixed_dofs = count_fixed(model);
  report.grounded_dofs = report::count_grounded(assembled.grounds, assembled.size());
  report::set_box(model.mesh.nodes, report);
  report::check_materials(model, report);
  report::check_connections(model, options, report);
  report::check_elements(model, options, report);

  std::vector<std::string> names;
  for (const auto& dof : assembled.dofs) names.push_back(dof_name(model.mesh, dof));
  const SparseMatrix stiffness = evaluate(assembled.stiffness, assembled.parameters);
  const SparseMatrix mass = evaluate(assembled.mass, assembled.parameters);
  report.stiffness_matrix = report::check_matrix(stiffness, "stiffness matrix", Topic::stiffness,
                                                 options.definiteness && !options.mechanisms, names, report.findings);
  report.mass_matrix =
      report::check_matrix(mass, "mass matrix", Topic::mass, options.definiteness, names, report.findings);
  report::check_massless(names, mass, stiffness, report.findings);
  report::check_springs(model, assembled, stiffness, report);
  if (report.stiffness_matrix.finite && report.mass_matrix.finite)
    check_motion(model, assembled, stiffness, names, options, report);
  report::sort(report.findings);
  return report;
}

}  // namespace kalfem
