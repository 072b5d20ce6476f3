#include "kalfem/casefile/prediction_stage.hpp"

#include <algorithm>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/casefile/reported_quantities.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Place = CoupledModel::Placed;

/// The boundary of a finite-element substructure, or the degrees of freedom that connectors touch.
std::vector<Index> boundary_of(const Study& study, const Place& place) {
  std::vector<Index> boundary;
  const auto& dofs = place.part.model.dofs;
  for (const auto& elements : study.finite_elements)
    if (elements.part->name == place.part.name)
      for (const auto& name : elements.part->boundary) boundary.push_back(std::ranges::find(dofs, name) - dofs.begin());
  if (!boundary.empty()) return boundary;
  for (Index i = 0; i < place.part.model.size(); ++i)
    if (std::ranges::any_of(study.model->system().connectors,
                            [&](const auto& connector) { return connector.deformation[place.offset + i] != 0.0; }))
      boundary.push_back(i);
  return boundary;
}

/// Qualified name under which the motion of a degree of freedom is reported.
std::string reported_name(const Place& place, Index dof) {
  const auto& model = place.part.model;
  const std::string& name = model.dofs[static_cast<std::size_t>(dof)];
  if (model.points_only)
    for (const auto& [point, combination] : model.points)
      if (combination.size() == 1 && combination.contains(name) && combination.at(name) == 1.0)
        return place.part.name + "." + point;
  return place.part.name + "." + name;
}

BoundaryMotion boundary_motion(const Study& study, const EstimationStage& estimation, const Place& place,
                               const std::vector<Index>& boundary) {
  using enum ObservedQuantity;
  const auto n_b = static_cast<Index>(boundary.size()), samples = estimation.measurements.samples();
  BoundaryMotion motion{MatrixXd(n_b, samples), MatrixXd(n_b, samples), MatrixXd(n_b, samples)};
  for (Index b = 0; b < n_b; ++b) {
    const std::string point = reported_name(place, boundary[static_cast<std::size_t>(b)]);
    for (const auto& [quantity, rows] :
         {std::pair{displacement, &motion.displacement}, std::pair{velocity, &motion.velocity},
          std::pair{acceleration, &motion.acceleration}}) {
      const auto* estimated = find_quantity(estimation.points, point, quantity);
      if (!estimated)
        throw InvalidInput(study.given.predict->substructure.issue(
            "the observer does not estimate the motion of '" + point + "'", "the substructure is driven by it",
            "hold the point in the observer or make it an interface"));
      rows->row(b) = estimated->mean.transpose();
    }
  }
  return motion;
}

/// The estimated start of a lumped substructure; a finite-element one starts as its boundary bends it.
PredictionStart start_of(const EstimationStage& estimation, const Place& place) {
  PredictionStart start{estimation.measurements.start, {}, {}};
  if (place.part.model.points_only) return start;
  start.displacement = start.velocity = VectorXd::Zero(place.part.model.size());
  for (Index i = 0; i < place.part.model.size(); ++i) {
    const std::string point = place.part.name + "." + place.part.model.dofs[static_cast<std::size_t>(i)];
    if (const auto* estimated = find_quantity(estimation.points, point, ObservedQuantity::displacement))
      start.displacement[i] = estimated->mean[0];
    if (const auto* estimated = find_quantity(estimation.points, point, ObservedQuantity::velocity))
      start.velocity[i] = estimated->mean[0];
  }
  return start;
}

/// Inputs that act on the substructure itself: moving grounds, forces at points.
std::vector<AppliedInput> applied_inputs(const Study& study, const Place& place) {
  std::vector<AppliedInput> applied;
  const auto& inputs = study.model->system().inputs;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    Input own = inputs[i];
    bool acts = false;
    for (auto* load : {&own.value, &own.rate, &own.acceleration}) {
      *load = VectorXd(load->segment(place.offset, place.part.model.size()));
      acts = acts || !load->isZero();
    }
    if (acts) applied.push_back({own, study.signals[i]});
  }
  return applied;
}

/// Names and rows of the reported points of the substructure, its boundary among them.
struct ReportedRows {
  std::vector<std::string> names;
  SparseRows rows;
};

ReportedRows reported_rows(const Study& study, const Place& place) {
  ReportedRows reported;
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& name : study.model->reported_points()) {
    if (!name.starts_with(place.part.name + ".")) continue;
    const VectorXd dofs = study.model->motion(name).dofs.segment(place.offset, place.part.model.size());
    for (Index i = 0; i < dofs.size(); ++i)
      if (dofs[i] != 0.0) entries.emplace_back(static_cast<Index>(reported.names.size()), i, dofs[i]);
    reported.names.push_back(name);
  }
  reported.rows.resize(static_cast<Index>(reported.names.size()), place.part.model.size());
  reported.rows.setFromTriplets(entries.begin(), entries.end());
  return reported;
}

}  // namespace

PredictionStage predict_stage(const Study& study, const StudyResults& results, const Progress& progress) {
  using enum ObservedQuantity;
  const Stopwatch watch;
  const auto& estimation = *results.estimation;
  PredictionStage stage{study.given.predict->substructure.value, {}, 0.0};
  const Place place = study.model->find_substructure(stage.substructure);
  const BaseDrivenSubstructure driven(place.part.model, boundary_of(study, place));
  const auto [names, rows] = reported_rows(study, place);
  const auto motion = driven.predict(
      rows, boundary_motion(study, estimation, place, driven.boundary()), applied_inputs(study, place),
      start_of(estimation, place),
      {.sample_rate = study.sample_rate(), .newmark_substeps = study.given.predict->substeps, .progress = progress});
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const auto& [quantity, predicted] :
         {std::pair{displacement, &motion.displacement}, std::pair{acceleration, &motion.acceleration}}) {
      PointQuantity point{names[i], quantity, predicted->row(static_cast<Index>(i)).transpose(), {}, {}, {}, {}};
      if (results.simulation)
        if (const auto* truth = find_quantity(results.simulation->points, names[i], quantity))
          compare(point, truth->mean, {estimation.settled, study.sample_rate(), estimation.band});
      stage.points.push_back(std::move(point));
    }
  stage.seconds = watch.seconds();
  return stage;
}

}  // namespace kalfem
