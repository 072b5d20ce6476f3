#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/checks/single_checks.hpp"

namespace kalfem {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Severity = FindingSeverity;
using Topic = FindingTopic;

constexpr double same_mass = 1e-3;

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

/// Mass and supports, where the places of the degrees of freedom are known.
void check_places(const LinearModel& model, const std::vector<PlacedDof>& places, ModelCheckReport& report) {
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
                      report.findings);
  std::vector<bool> held(places.size(), false);
  for (const auto& ground : model.grounds)
    for (Index i = 0; i < model.size(); ++i)
      if (ground.stiffness[i] != 0.0) held[static_cast<std::size_t>(i)] = true;
  report.grounding = check_grounding(model.stiffness, rigid_motions(places, frame), held);
  report.stray_dofs = report::tell_grounding(*report.grounding, report.grounded_dofs > 0, model.dofs, report.findings);
}

}  // namespace

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
    check_places(model, places, report);
  if (report.count(Severity::error) == 0) lowest_frequencies(model, options.frequencies, report);
  tell_zero_modes(report);
  report::sort(report.findings);
  return report;
}

}  // namespace kalfem
