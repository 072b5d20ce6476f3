#include "kalfem/pipeline/run_steps.hpp"

#include <algorithm>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/identification/driven_substructure.hpp"
#include "kalfem/pipeline/reported_quantities.hpp"
#include "kalfem/study/filter_checks.hpp"

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

/// Names and rows of the reported points of the substructure, its boundary among them.
struct ReportedRows {
  std::vector<std::string> names;
  SparseRows rows;
};

ReportedRows reported_rows(const CoupledModel& model, const Place& place) {
  ReportedRows reported;
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& name : model.reported_points()) {
    if (!name.starts_with(place.part.name + ".")) continue;
    const VectorXd dofs = model.motion(name).dofs(place.dofs);
    for (Index i = 0; i < dofs.size(); ++i)
      if (dofs[i] != 0.0) entries.emplace_back(static_cast<Index>(reported.names.size()), i, dofs[i]);
    reported.names.push_back(name);
  }
  reported.rows.resize(static_cast<Index>(reported.names.size()), place.part.model->size());
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
  const auto& estimation = *results.estimation;
  PredictionOutcome outcome{study.prediction->substructure.value, {}, 0.0};
  const DrivenSubstructure drive(*study.structure, model, outcome.substructure);
  const auto [names, rows] = reported_rows(model, drive.place());
  const auto samples = estimation.measurements.samples();
  const auto base = [&](const std::vector<std::string>& points) {
    return MatrixXd(base_accelerations(study, model, points, estimation.measurements.start, samples).transpose());
  };
  BoundaryMotion boundary = boundary_motion(study, estimation, drive.points());
  boundary.acceleration -= base(drive.points());
  auto motion = drive.predict(
      rows, boundary, start_of(estimation, drive.place()),
      {.sample_rate = study.sample_rate(), .newmark_substeps = study.prediction->substeps, .progress = progress});
  motion.acceleration += base(names);
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const auto& [quantity, predicted] :
         {std::pair{displacement, &motion.displacement}, std::pair{acceleration, &motion.acceleration}}) {
      PointQuantity point{names[i], quantity, predicted->row(static_cast<Index>(i)).transpose(), {}, {}, {}, {}};
      if (results.simulation)
        if (const auto* truth = find_quantity(results.simulation->points, names[i], quantity))
          compare(point, truth->mean, {estimation.settled, study.sample_rate(), estimation.band});
      outcome.points.push_back(std::move(point));
    }
  outcome.seconds = watch.seconds();
  return outcome;
}

}  // namespace kalfem
