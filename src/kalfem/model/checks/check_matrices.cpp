// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/model/checks/single_checks.hpp"

namespace kalfem::report {
namespace {

using Eigen::Index;
using Severity = FindingSeverity;
using Topic = FindingTopic;

constexpr double visible_asymmetry = 1e-9;
constexpr double small_part = 1e-10;  ///< of the diagonal, added so that a singular matrix counts as semi-definite
constexpr std::size_t most_dofs_told = 5;
constexpr std::array motion_names = {"along x", "along y", "along z", "about x", "about y", "about z"};

double largest_entry(const SparseMatrix& matrix) {
  double largest = 0.0;
  for (Index j = 0; j < matrix.cols(); ++j)
    for (SparseMatrix::InnerIterator it(matrix, j); it; ++it) {
      if (!std::isfinite(it.value())) return std::abs(it.value());
      largest = std::max(largest, std::abs(it.value()));
    }
  return largest;
}

/// Largest |A_ij - A_ji|. Both are walked side by side where A has a symmetric pattern, without the memory of their
/// difference.
double largest_asymmetry(const SparseMatrix& matrix) {
  const SparseMatrix turned = matrix.transpose();
  double largest = 0.0;
  for (Index j = 0; j < matrix.cols(); ++j) {
    SparseMatrix::InnerIterator one(matrix, j), other(turned, j);
    while (one && other && one.row() == other.row()) {
      largest = std::max(largest, std::abs(one.value() - other.value()));
      ++one, ++other;
    }
    if (one || other) return largest_entry(SparseMatrix(matrix - turned));
  }
  return largest;
}

}  // namespace

std::string to_string(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string listed(const std::vector<std::string>& names, Index count) {
  std::string text;
  const std::size_t first = std::min(names.size(), most_dofs_told);
  for (std::size_t i = 0; i < first; ++i) text += (i == 0 ? "" : ", ") + names[i];
  if (const auto more = count - static_cast<Index>(first); more > 0) text += " and " + std::to_string(more) + " more";
  return text;
}

// A semi-definite matrix has a Cholesky factor once a little is added to its diagonal. So the matrix is scaled to a
// unit diagonal, which makes one small part serve all units, and factored; where that fails, the column tells the
// place. A zero on the diagonal with entries beside it shows the same without a factor.
Index indefinite_dof(const SparseMatrix& matrix) {
  const Eigen::VectorXd diagonal = matrix.diagonal();
  for (Index j = 0; j < matrix.cols(); ++j)
    for (SparseMatrix::InnerIterator it(matrix, j); it; ++it)
      if (diagonal[j] == 0.0 && it.value() != 0.0) return j;  // [0 a; a b] has a negative eigenvalue
  const Eigen::VectorXd scale =
      (diagonal.array() > 0.0).select(diagonal.cwiseMax(1e-300).cwiseSqrt().cwiseInverse(), 1.0);
  SparseMatrix further(matrix.rows(), matrix.cols());
  further.reserve(Eigen::VectorXi::Ones(matrix.cols()));
  for (Index i = 0; i < matrix.rows(); ++i) further.insert(i, i) = diagonal[i] > 0.0 ? small_part : 1.0;
  try {
    const SparseFactor factor(SparseMatrix(SparseMatrix(scale.asDiagonal() * matrix * scale.asDiagonal()) + further));
    return -1;
  } catch (const NotPositiveDefinite& error) {
    return error.column();
  }
}

// Runs from cheap to expensive and stops where a later test would have no meaning: finite entries, not all zero,
// symmetry relative to the largest entry, signs on the diagonal, definiteness by a factorisation on request. A
// negative diagonal entry already proves that the matrix is indefinite, so no factor is formed then.
MatrixCheck check_matrix(const SparseMatrix& matrix, const std::string& name, FindingTopic topic, bool definite,
                         const std::vector<std::string>& dofs, std::vector<ModelFinding>& findings) {
  MatrixCheck report;
  const double largest = largest_entry(matrix);
  report.finite = std::isfinite(largest);
  if (!report.finite) {
    findings.push_back({Severity::error, topic, "the " + name + " has entries that are not finite",
                        "nothing can be computed from it", "check for divisions by zero in its source"});
    return report;
  }
  if (largest == 0.0) {
    if (matrix.rows() > 0)
      findings.push_back(
          {Severity::error, topic, "the " + name + " is zero", "there are no modes", "check the input files"});
    return report;
  }
  report.asymmetry = largest_asymmetry(matrix) / largest;
  if (report.asymmetry > visible_asymmetry)
    findings.push_back({Severity::error, topic,
                        "the " + name + " is not symmetric: entries differ by " + to_string(report.asymmetry) +
                            " of the largest entry between both triangles",
                        "all methods need symmetric matrices",
                        "export the symmetric part, or check that both triangles were read"});
  const Eigen::VectorXd diagonal = matrix.diagonal();
  std::vector<std::string> negative;
  for (Index i = 0; i < diagonal.size(); ++i) {
    if (diagonal[i] == 0.0) ++report.empty_diagonal;
    if (diagonal[i] >= 0.0) continue;
    if (negative.size() < most_dofs_told) negative.push_back(dofs[static_cast<std::size_t>(i)]);
    ++report.negative_diagonal;
  }
  if (report.negative_diagonal > 0) {
    report.semi_definite = false;
    findings.push_back(
        {Severity::error, topic,
         "the " + name + " has negative entries on its diagonal: " + listed(negative, report.negative_diagonal),
         "energies must not be negative", "check the signs in its source"});
  } else if (definite) {
    const Index failing = indefinite_dof(matrix);
    report.semi_definite = failing < 0;
    if (failing >= 0)
      findings.push_back({Severity::error, topic,
                          "the " + name + " is indefinite, first seen at " + dofs[static_cast<std::size_t>(failing)],
                          "some motion would have negative energy",
                          "check signs, subtracted masses and stiffnesses, and that both triangles agree"});
  }
  return report;
}

// A rigid-body motion needs no force unless something holds it. Which motions are held is a fact to report; forces at
// degrees of freedom that nothing holds are a fault, of the model or of the code that condensed it.
std::vector<std::string> tell_grounding(const GroundingCheck& grounding, bool supported,
                                        const std::vector<std::string>& dofs, std::vector<ModelFinding>& findings) {
  std::string held, free;
  for (std::size_t d = 0; d < 6; ++d) {
    if (!grounding.motions[d].exists) continue;
    std::string& list = grounding.motions[d].strained ? held : free;
    list += (list.empty() ? "" : ", ") + std::string(motion_names[d]);
  }
  if (grounding.existing > 0) {
    const std::string motions = std::to_string(grounding.existing) + " rigid-body motions";
    if (grounding.free == grounding.existing)
      findings.push_back(
          {Severity::note, Topic::grounding, "the structure is free: all its " + motions + " need no force",
           supported ? "the supports restrain none of them" : "it has that number of modes at 0 Hz", ""});
    else if (grounding.free == 0)
      findings.push_back(
          {Severity::note, Topic::grounding, "the structure is restrained in all its " + motions, "", ""});
    else
      findings.push_back({Severity::note, Topic::grounding,
                          "the structure is restrained in " + std::to_string(grounding.existing - grounding.free) +
                              " of its " + motions + (held.empty() ? "" : " (restrained: " + held + ")") +
                              (free.empty() ? "" : ", free: " + free),
                          std::to_string(grounding.free) + " combinations need no force and give modes at 0 Hz", ""});
  }
  std::vector<std::string> names;
  for (const auto& stray : grounding.stray) names.push_back(dofs[static_cast<std::size_t>(stray.dof)]);
  if (grounding.stray_count > 0)
    findings.push_back(
        {supported || grounding.free < grounding.existing ? Severity::warning : Severity::note, Topic::grounding,
         "grounding check: a rigid-body motion causes forces at " + listed(names, grounding.stray_count) + ", up to " +
             to_string(grounding.stray.front().ratio) +
             " of the forces that should cancel, although nothing restrains it there",
         "a spring between nodes at different places, a constraint that does not allow rigid-body "
         "motion, or condensed matrices tie the structure to the ground",
         "let such springs act along the line between their nodes or make the nodes coincide; check the "
         "constraints there"});
  return names;
}

// Signs of wrong offsets and units: a centre of mass outside the box, moments of inertia that no body has.
void tell_mass(const MassProperties& mass, const Eigen::Vector3d& moving, const Eigen::Vector3d& lowest,
               const Eigen::Vector3d& highest, bool needed, std::vector<ModelFinding>& findings) {
  if (!(moving.maxCoeff() > 0.0)) {
    findings.push_back({needed ? Severity::error : Severity::note, Topic::mass, "no moving degree of freedom has mass",
                        needed ? "there are no modes" : "statics need none, but gravity, rotation and modes do",
                        "give the materials a density or add masses"});
    return;
  }
  const double margin = 0.05 * (highest - lowest).norm();
  if (((mass.centre - lowest).array() < -margin).any() || ((mass.centre - highest).array() > margin).any())
    findings.push_back({Severity::warning, Topic::mass,
                        "the centre of mass (" + to_string(mass.centre[0]) + ", " + to_string(mass.centre[1]) + ", " +
                            to_string(mass.centre[2]) + ") lies outside the model",
                        "this is only possible if a large mass has an offset",
                        "check offsets of masses and the mass matrix"});
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(mass.inertia, Eigen::EigenvaluesOnly);
  const auto& moments = principal.eigenvalues();
  const double largest = moments[2];
  if (moments[0] < -1e-6 * largest || moments[2] > (moments[0] + moments[1]) * (1.0 + 1e-3) + 1e-12 * largest)
    findings.push_back({Severity::warning, Topic::mass,
                        "the principal moments of inertia " + to_string(moments[0]) + ", " + to_string(moments[1]) +
                            ", " + to_string(moments[2]) + " are physically impossible",
                        "each must be at most the sum of the other two",
                        "check inertias of masses and the mass matrix"});
}

void check_massless(const std::vector<std::string>& dofs, const SparseMatrix& mass, const SparseMatrix& stiffness,
                    std::vector<ModelFinding>& findings) {
  const Eigen::VectorXd m = mass.diagonal(), k = stiffness.diagonal();
  std::vector<std::string> names;
  Index count = 0;
  for (Index i = 0; i < m.size(); ++i) {
    if (m[i] != 0.0 || k[i] != 0.0) continue;
    if (names.size() < 8) names.push_back(dofs[static_cast<std::size_t>(i)]);
    ++count;
  }
  if (count > 0)
    findings.push_back(
        {Severity::error, Topic::mass,
         std::to_string(count) + " degrees of freedom have neither mass nor stiffness: " + listed(names, count),
         "their motion is undetermined", "fix them or give them mass or stiffness"});
}

Index count_grounded(const std::vector<GroundCoupling>& grounds, Index size) {
  Index count = 0;
  for (Index i = 0; i < size; ++i)
    count += std::ranges::any_of(grounds, [&](const auto& g) { return g.stiffness[i] != 0.0 || g.damping[i] != 0.0; });
  return count;
}

RigidFrame frame_of(const ModelCheckReport& report) {
  const double size = (report.highest - report.lowest).norm();
  return {0.5 * (report.lowest + report.highest), size > 0.0 ? 0.5 * size : 1.0};
}

void set_box(const Eigen::Matrix3Xd& places, ModelCheckReport& report) {
  if (places.cols() == 0) return;
  report.lowest = places.rowwise().minCoeff();
  report.highest = places.rowwise().maxCoeff();
}

void sort(std::vector<ModelFinding>& findings) {
  std::ranges::stable_sort(findings, [](const ModelFinding& a, const ModelFinding& b) {
    return a.severity != b.severity ? a.severity > b.severity : a.topic < b.topic;
  });
}

}  // namespace kalfem::report

namespace kalfem {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Severity = FindingSeverity;
using Topic = FindingTopic;

constexpr double same_mass = 1e-3;

// With rigid motions R about the middle of the box, R^T M R = [m I, -m [c x]; m [c x], J]. The arm c of the centre of
// mass follows from the skew part of the lower left block, and the inertia about it from the parallel-axis theorem.
/// Mass, centre and inertia from R^T M R about the centre of the box; nothing where not the same mass moves along x, y
/// and z, as in a plane model.
std::optional<MassProperties> placed_mass(const SparseMatrix& mass, const std::vector<PlacedDof>& places,
                                          const Vector3d& middle) {
  const MatrixXd motions = rigid_motions(places, {middle, 1.0});
  const Eigen::Matrix<double, 6, 6> matrix = motions.transpose() * (mass * motions);
  MassProperties properties;
  const auto masses = matrix.diagonal().head<3>();
  properties.mass = masses.mean();
  if (masses.maxCoeff() - masses.minCoeff() > same_mass * masses.maxCoeff()) return {};
  if (!(properties.mass > 0.0)) return properties;
  const Eigen::Matrix3d coupling = matrix.bottomLeftCorner<3, 3>() / properties.mass;
  const Vector3d arm =
      0.5 * Vector3d(coupling(2, 1) - coupling(1, 2), coupling(0, 2) - coupling(2, 0), coupling(1, 0) - coupling(0, 1));
  properties.centre = middle + arm;
  properties.inertia = matrix.bottomRightCorner<3, 3>() -
                       properties.mass * (arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
  return properties;
}

void lowest_frequencies(const LinearModel& model, Index count, ModelCheckReport& report) {
  const Index available = (model.mass.diagonal().array() > 0.0).count();
  if (count <= 0 || available == 0) return;
  try {
    const auto modes = lowest_modes(model.stiffness, model.mass, {.count = std::min(count, available)});
    for (const double value : modes.values)
      report.lowest_frequencies.push_back(std::sqrt(std::max(value, 0.0)) / (2.0 * std::numbers::pi));
  } catch (const InvalidInput& error) {
    for (const auto& issue : error.issues())
      report.findings.push_back({Severity::error, Topic::stiffness, issue.what, issue.why, issue.fix});
  }
}

void tell_zero_modes(ModelCheckReport& report) {
  const auto zeros = std::ranges::count(report.lowest_frequencies, 0.0);
  if (report.grounding && zeros > report.grounding->free)
    report.findings.push_back({Severity::warning, Topic::connections,
                               std::to_string(zeros) +
                                   " modes are at 0 Hz, but the structure can move as a rigid body only in " +
                                   std::to_string(report.grounding->free) + " ways",
                               "the others are mechanisms or disconnected parts",
                               "check the matrices and the coordinates given for their degrees of freedom"});
  if (!report.grounding && zeros > 6)
    report.findings.push_back({Severity::warning, Topic::connections, std::to_string(zeros) + " modes are at 0 Hz",
                               "a single body has at most six rigid-body modes",
                               "check for mechanisms and disconnected parts"});
}

// Box, mass and grounding need to know where the degrees of freedom are; matrices without a map go without them.
/// Mass and supports, where the places of the degrees of freedom are known.
void check_places(const LinearModel& model, const std::vector<PlacedDof>& places, const ModelCheckOptions& options,
                  ModelCheckReport& report) {
  Eigen::Matrix3Xd nodes(3, static_cast<Index>(places.size()));
  Index count = 0;
  for (const auto& dof : places)
    if (dof.direction >= 0) nodes.col(count++) = dof.place;
  if (count == 0) return;
  report::set_box(nodes.leftCols(count), report);
  const RigidFrame frame = report::frame_of(report);
  report.mass = placed_mass(model.mass, places, frame.centre);
  if (report.mass)
    report::tell_mass(*report.mass, Vector3d::Constant(report.mass->mass), report.lowest, report.highest,
                      options.needs_mass, report.findings);
  std::vector<bool> held(places.size(), false);
  for (const auto& ground : model.grounds)
    for (Index i = 0; i < model.size(); ++i)
      if (ground.stiffness[i] != 0.0) held[static_cast<std::size_t>(i)] = true;
  report.grounding = check_grounding(model.stiffness, rigid_motions(places, frame), held);
  report.stray_dofs = report::tell_grounding(*report.grounding, report.grounded_dofs > 0, model.dofs, report.findings);
}

}  // namespace

// Matrices first, then places, then modes: frequencies of matrices with errors would only repeat them in other words.
ModelCheckReport check_model(const LinearModel& model, const std::vector<PlacedDof>& places,
                             const ModelCheckOptions& options) {
  ModelCheckReport report;
  report.degrees_of_freedom = model.size();
  report.grounded_dofs = report::count_grounded(model.grounds, model.size());
  report.stiffness_matrix = report::check_matrix(model.stiffness, "stiffness matrix", Topic::stiffness,
                                                 options.definiteness, model.dofs, report.findings);
  report.mass_matrix =
      report::check_matrix(model.mass, "mass matrix", Topic::mass, options.definiteness, model.dofs, report.findings);
  report::check_massless(model.dofs, model.mass, model.stiffness, report.findings);
  if (static_cast<Index>(places.size()) == model.size() && report.stiffness_matrix.finite && report.mass_matrix.finite)
    check_places(model, places, options, report);
  if (report.count(Severity::error) == 0) lowest_frequencies(model, options.frequencies, report);
  tell_zero_modes(report);
  report::sort(report.findings);
  return report;
}

}  // namespace kalfem
