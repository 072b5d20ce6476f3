// SPDX-License-Identifier: Apache-2.0
#include "kalfem/vibration/driven_motion.hpp"

#include <algorithm>
#include <iterator>

#include "kalfem/identification/driven_substructure.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Place = DrivenSubstructure::Place;

/// The acceleration that an accelerated base adds to points, one row per point. Their displacements are relative to the
/// base, with or without this term.
MatrixXd base_accelerations(const DrivenMotionProblem& problem, const std::vector<std::string>& points) {
  MatrixXd added = MatrixXd::Zero(std::ssize(points), problem.samples);
  const auto& directions = problem.model->base_accelerations();
  const auto& signals = problem.structure->signals;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const auto input = static_cast<Index>(i);
    if (directions.col(input).isZero(0.0)) continue;
    const VectorXd signal =
        signals[i]->sample(problem.start, 1.0 / problem.sample_rate, problem.samples).col(0).matrix();
    for (std::size_t p = 0; p < points.size(); ++p)
      added.row(static_cast<Index>(p)) +=
          problem.model->motion(points[p]).dofs.dot(directions.col(input)) * signal.transpose();
  }
  return added;
}

BoundaryMotion boundary_motion(const DrivenMotionProblem& problem, const std::vector<std::string>& points) {
  using enum ObservedQuantity;
  const Index n_b = std::ssize(points), samples = problem.samples;
  BoundaryMotion motion{MatrixXd(n_b, samples), MatrixXd(n_b, samples), MatrixXd(n_b, samples)};
  for (Index b = 0; b < n_b; ++b) {
    const std::string& point = points[static_cast<std::size_t>(b)];
    for (const auto& [quantity, rows] :
         {std::pair{displacement, &motion.displacement}, std::pair{velocity, &motion.velocity},
          std::pair{acceleration, &motion.acceleration}}) {
      const auto* estimated = problem.estimated(point, quantity);
      if (!estimated)
        throw InvalidInput("the filter's model does not contain the motion of '" + point + "'",
                           "this motion drives the substructure",
                           "include the point in the filter's model or make it an interface");
      rows->row(b) = estimated->transpose();
    }
  }
  return motion;
}

PredictionStart start_of(const DrivenMotionProblem& problem, const Place& place) {
  PredictionStart start{problem.start, {}, {}};
  const LinearModel& model = *place.part.model;
  if (model.points_only) return start;
  start.displacement = start.velocity = VectorXd::Zero(model.size());
  for (Index i = 0; i < model.size(); ++i) {
    const std::string point = place.part.name + "." + model.dofs[static_cast<std::size_t>(i)];
    if (const auto* estimated = problem.estimated(point, ObservedQuantity::displacement))
      start.displacement[i] = (*estimated)[0];
    if (const auto* estimated = problem.estimated(point, ObservedQuantity::velocity))
      start.velocity[i] = (*estimated)[0];
  }
  return start;
}

/// Names and rows of the reported points of the substructure, its boundary among them, and behind them of its gauges.
struct ReportedRows {
  std::vector<std::string> points, gauges;
  SparseRows rows;
};

ReportedRows reported_rows(const CoupledModel& model, const Place& place) {
  ReportedRows reported;
  std::vector<Eigen::Triplet<double>> entries;
  const auto own = [&](const std::string& name) { return name.starts_with(place.part.name + "."); };
  const auto add = [&](const VectorXd& all, Index row) {
    const VectorXd dofs = all(place.dofs);
    for (Index i = 0; i < dofs.size(); ++i)
      if (dofs[i] != 0.0) entries.emplace_back(row, i, dofs[i]);
  };
  std::ranges::copy_if(model.reported_points(), std::back_inserter(reported.points), own);
  std::ranges::copy_if(model.gauges(), std::back_inserter(reported.gauges), own);
  Index row = 0;
  for (const auto& point : reported.points) add(model.motion(point).dofs, row++);
  for (const auto& gauge : reported.gauges) add(model.strain(gauge), row++);
  reported.rows.resize(row, place.part.model->size());
  reported.rows.setFromTriplets(entries.begin(), entries.end());
  return reported;
}

}  // namespace

std::vector<std::string> driving_points(const StructureModel& structure, const CoupledModel& model,
                                        const std::string& substructure) {
  return DrivenSubstructure(structure, model, substructure).points();
}

// The substructure is solved relative to an accelerated base: the base acceleration is subtracted from the boundary
// before the prediction and added to the predicted points after it. Displacements stay relative to the base, as in the
// estimation.
std::vector<DrivenQuantity> predict(const DrivenMotionProblem& problem, const Progress& progress) {
  using enum ObservedQuantity;
  const DrivenSubstructure drive(*problem.structure, *problem.model, problem.substructure);
  const auto [points, gauges, rows] = reported_rows(*problem.model, drive.place());
  BoundaryMotion boundary = boundary_motion(problem, drive.points());
  boundary.acceleration -= base_accelerations(problem, drive.points());
  auto motion =
      drive.predict(rows, boundary, start_of(problem, drive.place()),
                    {.sample_rate = problem.sample_rate, .newmark_substeps = problem.substeps, .progress = progress});
  const Index n = std::ssize(points);
  motion.acceleration.topRows(n) += base_accelerations(problem, points);
  std::vector<DrivenQuantity> predicted;
  for (Index i = 0; i < n; ++i) {
    const auto& point = points[static_cast<std::size_t>(i)];
    predicted.push_back({point, displacement, motion.displacement.row(i)});
    predicted.push_back({point, acceleration, motion.acceleration.row(i)});
  }
  for (std::size_t i = 0; i < gauges.size(); ++i)
    predicted.push_back({gauges[i], strain, motion.displacement.row(n + static_cast<Index>(i))});
  return predicted;
}

}  // namespace kalfem
