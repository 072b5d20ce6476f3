// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/checks/model_check.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/model/assembly/hourglass.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/checks/single_checks.hpp"
#include "kalfem/model/mesh/connectivity.hpp"

namespace kalfem {

const std::vector<UsualMaterial>& usual_materials() {
  static const std::vector<UsualMaterial> materials = {{"steel", 1.85e11, 2.2e11, 7600.0, 8200.0},
                                                       {"aluminium", 6.6e10, 8.0e10, 2550.0, 2950.0},
                                                       {"titanium", 1.0e11, 1.25e11, 4350.0, 4850.0},
                                                       {"magnesium", 4.0e10, 4.8e10, 1700.0, 1900.0},
                                                       {"cast iron", 0.9e11, 1.85e11, 6900.0, 7500.0},
                                                       {"copper or brass", 0.9e11, 1.4e11, 8200.0, 9000.0},
                                                       {"nickel alloy", 1.7e11, 2.3e11, 8100.0, 9000.0},
                                                       {"zinc alloy", 8.0e10, 1.1e11, 6500.0, 7200.0},
                                                       {"tungsten or molybdenum", 3.0e11, 4.2e11, 1.0e4, 1.95e4},
                                                       {"lead", 1.3e10, 2.0e10, 1.1e4, 1.15e4},
                                                       {"glass", 5.0e10, 9.0e10, 2200.0, 2600.0},
                                                       {"ceramic", 2.0e11, 4.5e11, 2800.0, 4100.0},
                                                       {"carbon-fibre composite", 4.0e10, 3.0e11, 1400.0, 1800.0},
                                                       {"glass-fibre composite", 8.0e9, 5.0e10, 1500.0, 2200.0},
                                                       {"concrete or stone", 1.5e10, 8.0e10, 1900.0, 3000.0},
                                                       {"wood", 5.0e9, 2.0e10, 300.0, 1100.0},
                                                       {"plastic", 1.5e8, 1.2e10, 850.0, 1500.0},
                                                       {"rubber", 3.0e5, 2.0e8, 850.0, 1500.0},
                                                       {"foam or honeycomb", 1.0e5, 3.0e9, 10.0, 450.0}};
  return materials;
}

const std::vector<UsualUnits>& usual_units() {
  constexpr double inch = 0.0254, foot = 0.3048, pound = 0.45359237, gravity = 9.80665;
  static const std::vector<UsualUnits> units = {
      {"mm, t, s (N, MPa)", "mm", "t", "s", 1e-3, 1e3, 1.0},
      {"mm, kg, ms (kN, GPa)", "mm", "kg", "ms", 1e-3, 1.0, 1e-3},
      {"mm, kg, s (mN, kPa)", "mm", "kg", "s", 1e-3, 1.0, 1.0},
      {"mm, g, ms (N, MPa)", "mm", "g", "ms", 1e-3, 1e-3, 1e-3},
      {"inch, lbf s^2/in, s (lbf, psi)", "inch", "lbf s^2/in", "s", inch, pound * gravity / inch, 1.0},
      {"foot, slug, s (lbf)", "foot", "slug", "s", foot, pound * gravity / foot, 1.0},
      {"m, t, s (kN, kPa)", "m", "t", "s", 1.0, 1e3, 1.0},
      {"cm, g, s (dyn)", "cm", "g", "s", 1e-2, 1e-3, 1.0},
      {"cm, kg, s", "cm", "kg", "s", 1e-2, 1.0, 1.0}};
  return units;
}

std::optional<UsualMaterial> usual_material(double youngs_modulus, double density) {
  for (const auto& usual : usual_materials())
    if (youngs_modulus >= usual.least_modulus && youngs_modulus <= usual.most_modulus &&
        density >= usual.least_density && density <= usual.most_density)
      return usual;
  return {};
}

double wave_speed(const IsotropicMaterial& material) {
  return material.density > 0.0 && material.youngs_modulus > 0.0 ? std::sqrt(material.youngs_modulus / material.density)
                                                                 : 0.0;
}

// The numbers are read in each usual system of units: one that makes them a usual material is a guess.
std::vector<UnitsGuess> units_that_fit(const IsotropicMaterial& material) {
  std::vector<UnitsGuess> fitting;
  for (const auto& units : usual_units()) {
    const double pascals = units.kilograms / (units.metres * units.seconds * units.seconds),
                 density = units.kilograms / std::pow(units.metres, 3);
    if (const auto usual = usual_material(material.youngs_modulus * pascals, material.density * density))
      fitting.push_back({units, *usual});
  }
  return fitting;
}

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double strain_rounding = 1e-10;  ///< of a row's force against what cancels in it
constexpr double stray = 1e-6;
constexpr double dependent = 1e-9;  ///< of motions that are combinations of others
constexpr std::size_t most_forces_told = 10;

/// sum_j |K_ij| m_j.
VectorXd absolute_product(const SparseMatrix& matrix, const VectorXd& magnitudes) {
  VectorXd sum = VectorXd::Zero(matrix.rows());
  for (Index j = 0; j < matrix.cols(); ++j)
    for (SparseMatrix::InnerIterator it(matrix, j); it; ++it) sum[it.row()] += std::abs(it.value()) * magnitudes[j];
  return sum;
}

/// Each row of K Q as a part of what cancels in it.
MatrixXd relative_forces(const SparseMatrix& stiffness, const MatrixXd& motions) {
  const VectorXd scale = absolute_product(stiffness, motions.rowwise().lpNorm<Eigen::Infinity>());
  const VectorXd inverse = (scale.array() > 0.0).select(scale.cwiseInverse(), 0.0);
  return inverse.asDiagonal() * (stiffness * motions);
}

/// R of F = Q R, with the singular values of F, which may have fewer rows than columns.
MatrixXd triangular_factor(const MatrixXd& forces) {
  const Index columns = forces.cols();
  MatrixXd padded = MatrixXd::Zero(std::max(forces.rows(), columns), columns);
  padded.topRows(forces.rows()) = forces;
  const Eigen::HouseholderQR<MatrixXd> qr(padded);
  return qr.matrixQR().topRows(columns).triangularView<Eigen::Upper>();
}

}  // namespace

// A rigid-body motion Q must need no force. Each row of K Q is judged against the sum of the absolute values that
// cancel in it, so that the limit is a matter of rounding and not of units.
//   1. each of the six motions by itself: does it exist, does it strain something;
//   2. an orthonormal basis of those that exist, by QR with pivoting: plane models have fewer than six;
//   3. combinations without force: the small singular values of K Q, from the R of its QR factorisation, as a held
//      point off the origin lets only combinations pass;
//   4. rows with a force where nothing holds the model.
GroundingCheck check_grounding(const SparseMatrix& stiffness, const MatrixXd& rigid_motions,
                               const std::vector<bool>& held) {
  GroundingCheck grounding;
  const Index n = stiffness.rows();
  if (n == 0) {
    for (auto& motion : grounding.motions) motion.exists = false;
    return grounding;
  }
  const VectorXd sizes = rigid_motions.colwise().norm();
  const double largest = sizes.maxCoeff();
  for (Index d = 0; d < 6; ++d) {
    auto& motion = grounding.motions[static_cast<std::size_t>(d)];
    motion.exists = sizes[d] > dependent * largest;
    if (motion.exists) motion.largest = relative_forces(stiffness, rigid_motions.col(d)).cwiseAbs().maxCoeff();
    motion.strained = motion.largest > strain_rounding;
  }
  const MatrixXd scaled =
      rigid_motions * (sizes.array() > dependent * largest).select(sizes.cwiseInverse(), 0.0).matrix().asDiagonal();
  Eigen::ColPivHouseholderQR<MatrixXd> qr(scaled);
  qr.setThreshold(dependent);
  grounding.existing = static_cast<int>(qr.rank());
  if (grounding.existing == 0) return grounding;
  const MatrixXd basis = qr.householderQ() * MatrixXd::Identity(n, qr.rank());
  const MatrixXd forces = relative_forces(stiffness, basis);
  const Eigen::JacobiSVD<MatrixXd> combinations(triangular_factor(forces));
  grounding.free = static_cast<int>((combinations.singularValues().array() < strain_rounding).count());
  for (Index i = 0; i < n; ++i)
    if (const double ratio = forces.row(i).cwiseAbs().maxCoeff(); ratio > stray && !held[static_cast<std::size_t>(i)])
      grounding.stray.push_back({i, ratio});
  grounding.stray_count = static_cast<Index>(grounding.stray.size());
  std::ranges::sort(grounding.stray, std::greater{}, &StrayForce::ratio);
  if (grounding.stray.size() > most_forces_told) grounding.stray.resize(most_forces_told);
  return grounding;
}

namespace {

using Severity = FindingSeverity;
using Topic = FindingTopic;

constexpr double follows_rigidly = 1e-6;  ///< of the size of the motion

/// Which nodes are scalar points.
std::vector<bool> scalar_nodes(const Mesh& mesh) {
  std::vector<bool> scalar(static_cast<std::size_t>(mesh.node_count()), false);
  if (const auto set = mesh.node_sets.find(scalar_points); set != mesh.node_sets.end())
    for (const auto node : set->second) scalar[static_cast<std::size_t>(node)] = true;
  return scalar;
}

std::vector<PlacedDof> placed(const FiniteElementModel& model, const std::vector<NodalDof>& dofs) {
  const auto scalar = scalar_nodes(model.mesh);
  std::vector<PlacedDof> list;
  list.reserve(dofs.size());
  for (const auto& dof : dofs)
    list.push_back({model.mesh.nodes.col(dof.node), scalar[static_cast<std::size_t>(dof.node)] ? -1 : dof.direction,
                    model.mesh.axes_of(dof.node)});
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

// Free degrees of freedom are moved rigidly and expanded to all: who does not come along is fixed or tied to what is.
/// Nodes that do not follow the rigid-body motions of the free degrees of freedom: they are fixed, or tied to what is.
std::vector<bool> nodes_that_stay(const FiniteElementModel& model, const AssembledModel& assembled,
                                  const RigidFrame& frame, const MatrixXd& motions) {
  const MatrixXd moved = assembled.expansion * motions;
  const auto named = named_dofs(model, assembled);
  const auto scalar = scalar_nodes(model.mesh);
  std::vector<bool> stays(static_cast<std::size_t>(model.mesh.node_count()), false);
  for (std::size_t i = 0; i < named.size(); ++i) {
    const auto row = static_cast<Index>(i);
    if (!named[i] || scalar[i / 6]) continue;
    const auto rigid =
        rigid_motion({model.mesh.nodes.col(row / 6), static_cast<int>(row % 6), model.mesh.axes_of(row / 6)}, frame);
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

/// K held against the rigid-body motions that strain nothing has a factor only if there are no others: the search for
/// them is needed where it has none. A factor that is at hand shows the same.
void find_the_mechanisms(const FiniteElementModel& model, const AssembledModel& assembled,
                         const SparseMatrix& stiffness, const SparseMatrix& mass, const ModelCheckOptions& options,
                         ModelCheckReport& report) {
  report.factor = options.factor;
  if (!report.factor && assembled.size() > 0)
    if (auto factor = factor_held(model, assembled, stiffness, mass))
      report.factor = std::make_shared<const StiffnessFactor>(std::move(*factor));
  if (report.factor) {
    report.stiffness_matrix.semi_definite = true;
    return;
  }
  try {
    report.mechanisms = find_mechanisms(model, assembled, stiffness);
    report.stiffness_matrix.semi_definite = true;
  } catch (const InvalidInput&) {  // indefinite, or singular with large rounding
    const Index failing = report::indefinite_dof(stiffness);
    report.stiffness_matrix.semi_definite = failing < 0;
    if (failing < 0)
      report.findings.push_back({Severity::note, Topic::stiffness, "mechanisms were not searched for",
                                 "the stiffness matrix is almost singular and cannot be factored", ""});
    else
      report.findings.push_back({Severity::error, Topic::stiffness,
                                 "the stiffness matrix is indefinite, first seen at " +
                                     dof_name(model.mesh, assembled.dofs[static_cast<std::size_t>(failing)]),
                                 "some motion would have negative energy",
                                 "check negative stiffnesses, and matrices from other codes"});
    return;
  }
  const auto count = static_cast<Index>(report.mechanisms.size());
  if (count == 0) return;
  const auto [why, fix] = mechanism_reason(model);
  report.findings.push_back({Severity::warning, Topic::connections,
                             std::to_string(count) + " motions other than rigid-body motions need no force, at " +
                                 report::listed(report.mechanisms, count),
                             why, fix});
}

/// What the assembled matrices say about mass, supports and mechanisms.
void check_motion(const FiniteElementModel& model, const AssembledModel& assembled, const SparseMatrix& stiffness,
                  const SparseMatrix& mass, const std::vector<std::string>& names, const ModelCheckOptions& options,
                  ModelCheckReport& report) {
  report.mass = mass_properties(model, assembled, mass);
  report.moving_mass = moving_mass(model, assembled, mass);
  report::tell_mass(*report.mass, *report.moving_mass, report.lowest, report.highest, options.needs_mass,
                    report.findings);
  const RigidFrame frame = report::frame_of(report);
  const MatrixXd motions = rigid_motions(placed(model, assembled.dofs), frame);
  const auto stays = nodes_that_stay(model, assembled, frame, motions);
  report.grounding = check_grounding(stiffness, motions, expected_forces(model, assembled, stays));
  const bool supported = report.fixed_dofs > 0 || report.grounded_dofs > 0 || std::ranges::count(stays, true) > 0;
  report.stray_dofs = report::tell_grounding(*report.grounding, supported, names, report.findings);
  if (options.mechanisms && report.stiffness_matrix.negative_diagonal == 0)
    find_the_mechanisms(model, assembled, stiffness, mass, options, report);
}

/// Whether M is a sum of parts that each are positive semi-definite, as those of elements and bodies are: of matrices
/// from elsewhere nobody knows.
bool is_sum_of_bodies(const FiniteElementModel& model) {
  const auto is_body = [](const PointMass& mass) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> moments(mass.inertia, Eigen::EigenvaluesOnly);
    return mass.mass >= 0.0 && moments.eigenvalues()[0] >= -1e-12 * std::abs(moments.eigenvalues()[2]);
  };
  const auto adds_mass = [](const auto& property) {
    if (const auto* shell = std::get_if<ShellProperty>(&property.second)) return shell->nonstructural_mass >= 0.0;
    if (const auto* beam = std::get_if<BeamProperty>(&property.second)) return beam->nonstructural_mass >= 0.0;
    const auto* laminate = std::get_if<LaminateProperty>(&property.second);
    return laminate == nullptr || (laminate->mass >= 0.0 && laminate->rotary_inertia >= 0.0);
  };
  const auto has_density = [](const auto& material) { return material.second.density >= 0.0; };
  const auto has_mass = [](const NodalMatrices& matrices) { return matrices.mass.nonZeros() > 0; };
  return std::ranges::all_of(model.masses, is_body) && std::ranges::all_of(model.materials, has_density) &&
         std::ranges::all_of(model.properties, adds_mass) && std::ranges::none_of(model.matrices, has_mass);
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
  return check_model(model, assembled, evaluate(assembled.stiffness, assembled.parameters),
                     evaluate(assembled.mass, assembled.parameters), options);
}

ModelCheckReport check_model(const FiniteElementModel& model, const AssembledModel& assembled,
                             const SparseMatrix& stiffness, const SparseMatrix& mass,
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
  report.stiffness_matrix = report::check_matrix(stiffness, "stiffness matrix", Topic::stiffness,
                                                 options.definiteness && !options.mechanisms, names, report.findings);
  const bool bodies = is_sum_of_bodies(model);
  if (options.needs_mass || mass.nonZeros() > 0)
    report.mass_matrix =
        report::check_matrix(mass, "mass matrix", Topic::mass, options.definiteness && !bodies, names, report.findings);
  if (options.definiteness && bodies && report.mass_matrix.finite) report.mass_matrix.semi_definite = true;
  report::check_massless(names, mass, stiffness, report.findings);
  report::check_springs(model, assembled, stiffness, report);
  if (report.stiffness_matrix.finite && report.mass_matrix.finite)
    check_motion(model, assembled, stiffness, mass, names, options, report);
  report::sort(report.findings);
  return report;
}

}  // namespace kalfem
