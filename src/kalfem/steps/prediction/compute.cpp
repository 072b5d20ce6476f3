// SPDX-License-Identifier: Apache-2.0

#include <algorithm>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/identification/driven_substructure.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/prediction/compute.hpp"
#include "kalfem/steps/prediction/outcome.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/filter_checks.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Place = DrivenSubstructure::Place;

/// The acceleration that an accelerated base adds to points, one column per point. Their displacements are relative to
/// the base, with or without this term.
MatrixXd base_accelerations(const Study& study, const CoupledModel& model, const std::vector<std::string>& points,
                            double start, Index samples) {
  MatrixXd added = MatrixXd::Zero(samples, static_cast<Index>(points.size()));
  const auto& directions = model.base_accelerations();
  for (std::size_t i = 0; i < study.structure->signals.size(); ++i) {
    const auto input = static_cast<Index>(i);
    if (directions.col(input).isZero(0.0)) continue;
    const VectorXd signal =
        study.structure->signals[i]->sample(start, 1.0 / study.sample_rate(), samples).col(0).matrix();
    for (std::size_t p = 0; p < points.size(); ++p)
      added.col(static_cast<Index>(p)) += model.motion(points[p]).dofs.dot(directions.col(input)) * signal;
  }
  return added;
}

BoundaryMotion boundary_motion(const Study& study, const EstimationOutcome& estimation,
                               const std::vector<std::string>& points) {
  using enum ObservedQuantity;
  const auto n_b = static_cast<Index>(points.size()), samples = estimation.measurements.samples();
  BoundaryMotion motion{MatrixXd(n_b, samples), MatrixXd(n_b, samples), MatrixXd(n_b, samples)};
  for (Index b = 0; b < n_b; ++b) {
    const std::string& point = points[static_cast<std::size_t>(b)];
    for (const auto& [quantity, rows] :
         {std::pair{displacement, &motion.displacement}, std::pair{velocity, &motion.velocity},
          std::pair{acceleration, &motion.acceleration}}) {
      const auto* estimated = find_quantity(estimation.points, point, quantity);
      if (!estimated) throw not_estimated(study.prediction->substructure, point);
      rows->row(b) = estimated->mean.transpose();
    }
  }
  return motion;
}

/// The estimated initial state of a lumped substructure. A finite-element one starts in the static shape of its
/// boundary motion.
PredictionStart start_of(const EstimationOutcome& estimation, const Place& place) {
  PredictionStart start{estimation.measurements.start, {}, {}};
  if (place.part.model->points_only) return start;
  start.displacement = start.velocity = VectorXd::Zero(place.part.model->size());
  for (Index i = 0; i < place.part.model->size(); ++i) {
    const std::string point = place.part.name + "." + place.part.model->dofs[static_cast<std::size_t>(i)];
    if (const auto* estimated = find_quantity(estimation.points, point, ObservedQuantity::displacement))
      start.displacement[i] = estimated->mean[0];
    if (const auto* estimated = find_quantity(estimation.points, point, ObservedQuantity::velocity))
      start.velocity[i] = estimated->mean[0];
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

// The substructure is solved relative to an accelerated base: the base acceleration is subtracted from the boundary
// before the prediction and added to the predicted points after it. Displacements stay relative to the base, as in the
// estimation.
PredictionOutcome run_prediction(const Study& study, const CoupledModel& model, const StudyResults& results,
                                 const Progress& progress) {
  using enum ObservedQuantity;
  const Stopwatch watch;
  const auto& estimation = results.get<EstimationOutcome>();
  PredictionOutcome outcome{study.prediction->substructure.value, {}, 0.0};
  const DrivenSubstructure drive(*study.structure, model, outcome.substructure);
  const auto [points, gauges, rows] = reported_rows(model, drive.place());
  const auto samples = estimation.measurements.samples();
  const auto base = [&](const std::vector<std::string>& names) {
    return MatrixXd(base_accelerations(study, model, names, estimation.measurements.start, samples).transpose());
  };
  BoundaryMotion boundary = boundary_motion(study, estimation, drive.points());
  boundary.acceleration -= base(drive.points());
  auto motion = drive.predict(
      rows, boundary, start_of(estimation, drive.place()),
      {.sample_rate = study.sample_rate(), .newmark_substeps = study.prediction->substeps, .progress = progress});
  const auto n = static_cast<Index>(points.size());
  motion.acceleration.topRows(n) += base(points);
  TruthComparison comparison(estimation.settled, study.sample_rate(), estimation.band);
  const auto add = [&](const std::string& name, ObservedQuantity quantity, const VectorXd& predicted) {
    PointQuantity point{name, quantity, predicted, {}, {}, {}, {}};
    if (const auto* simulation = results.find<SimulationOutcome>())
      if (const auto* truth = find_quantity(simulation->points, name, quantity)) comparison.compare(point, truth->mean);
    outcome.points.push_back(std::move(point));
  };
  for (Index i = 0; i < n; ++i) {
    add(points[static_cast<std::size_t>(i)], displacement, motion.displacement.row(i));
    add(points[static_cast<std::size_t>(i)], acceleration, motion.acceleration.row(i));
  }
  for (std::size_t i = 0; i < gauges.size(); ++i)
    add(gauges[i], strain, motion.displacement.row(n + static_cast<Index>(i)));
  outcome.seconds = watch.seconds();
  return outcome;
}

}  // namespace kalfem
