#include "kalfem/casefile/stages.hpp"

#include <chrono>

#include "kalfem/base/random.hpp"
#include "kalfem/casefile/estimation_stage.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

class Stopwatch {
public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

InitialState initial_state(const Study& study) {
  const auto& system = study.model->system();
  InitialState start = at_rest(system.size(), system.connector_states());
  for (const auto& [point, given] : study.given.simulate->initial) {
    const Index index = study.model->dof_index(point);
    if (index < 0)
      throw InvalidInput(
          Issue{{study.file, 0},
                "simulate.initial: '" + point + "' is no degree of freedom" + did_you_mean(point, system.dofs),
                "",
                ""});
    start.displacement[index] = given.displacement;
    start.velocity[index] = given.velocity;
  }
  return start;
}

std::vector<MeasurementChain> chains_of(const std::vector<StudySensor>& sensors) {
  std::vector<MeasurementChain> chains;
  for (const auto& sensor : sensors) chains.push_back(sensor.chain);
  return chains;
}

/// Adds white noise of each sensor's own stream, so that one sensor more does not change the others.
void add_noise(const Study& study, SimulationStage& stage) {
  const auto& clean = stage.reference.sensors;
  stage.measurements = {study.given.simulate->sample_rate, 0.0, {}, clean};
  for (std::size_t i = 0; i < study.sensors.size(); ++i) {
    const auto column = static_cast<Index>(i);
    const auto& sensor = study.sensors[i];
    stage.noise.push_back(sensor.deviation(rms(clean.col(column))));
    stage.measurements.channels.push_back({sensor.name, sensor.unit});
    RandomStream random(study.given.simulate->seed, sensor.name);
    for (Index k = 0; k < clean.rows(); ++k)
      stage.measurements.values(k, column) += stage.noise.back() * random.normal();
  }
}

SimulationStage simulate_stage(const Study& study, const Progress& progress, std::string& failure) {
  const auto& given = *study.given.simulate;
  std::vector<OutputDescription> outputs;
  for (const auto& sensor : study.sensors) outputs.push_back(sensor.output);
  const Stopwatch watch;
  SimulationOptions options;
  options.integrator = given.integrator;
  options.duration = given.duration;
  options.hht_alpha = given.hht_alpha;
  options.spectral_radius = given.spectral_radius;
  options.progress = progress;
  SimulationStage stage;
  stage.reference = simulate_reference(
      study.model->system(), study.signals, initial_state(study), make_outputs(*study.model, outputs),
      chains_of(study.sensors), options,
      {.sample_rate = given.sample_rate, .max_substeps = given.max_substeps, .tolerance = given.tolerance});
  if (stage.reference.simulation.failure)
    failure = "the simulation stopped at " + shortest(stage.reference.simulation.failure->time) +
              " s: " + stage.reference.simulation.failure->reason;
  else if (!stage.reference.converged && !study.sensors.empty())
    failure = "the reference did not converge: halving the step to 1/" + std::to_string(stage.reference.substeps) +
              " of a sample still changes a sensor's record by " + shortest(stage.reference.last_change) +
              " of its rms; raise simulate.max_substeps or simulate.tolerance";
  else
    add_noise(study, stage);
  stage.seconds = watch.seconds();
  return stage;
}

const Substructure& substructure_of(const Study& study, const std::string& name) {
  for (const auto& part : study.model->substructures())
    if (part.name == name) return part;
  throw std::logic_error("substructure was checked when the case was read");
}

/// Degrees of freedom of the substructure that a connector touches.
std::vector<Index> boundary_of(const Study& study, const Substructure& part, Index offset) {
  std::vector<Index> boundary;
  for (Index i = 0; i < part.model.size(); ++i)
    for (const auto& connector : study.model->system().connectors)
      if (connector.deformation[offset + i] != 0.0) {
        boundary.push_back(i);
        break;
      }
  return boundary;
}

const PointQuantity* find_point(const std::vector<PointQuantity>& points, const std::string& name,
                                ObservedQuantity quantity) {
  for (const auto& point : points)
    if (point.point == name && point.quantity == quantity) return &point;
  return nullptr;
}

/// Forces of the inputs on the substructure (moving grounds, forces at points), n x samples.
MatrixXd applied_forces(const Study& study, const Substructure& part, Index offset, double start, Index samples) {
  MatrixXd forces = MatrixXd::Zero(part.model.size(), samples);
  const double step = 1.0 / study.sample_rate();
  for (Index i = 0; i < study.model->system().input_count(); ++i) {
    const auto& input = study.model->system().inputs[static_cast<std::size_t>(i)];
    const auto sampled = study.signals[static_cast<std::size_t>(i)]->sample(start, step, samples);
    const auto rows = [&](const VectorXd& direction) { return direction.segment(offset, part.model.size()); };
    forces += rows(input.value) * sampled.col(0).matrix().transpose() +
              rows(input.rate) * sampled.col(1).matrix().transpose() +
              rows(input.acceleration) * sampled.col(2).matrix().transpose();
  }
  return forces;
}

PredictionStage predict_stage(const Study& study, const StudyResults& results) {
  using enum ObservedQuantity;
  const Stopwatch watch;
  const auto& estimation = *results.estimation;
  PredictionStage stage{study.given.predict->substructure.value, {}, 0.0};
  const auto& part = substructure_of(study, stage.substructure);
  const Index offset = study.model->dof_index(part.name + "." + part.model.dofs.front());
  const BaseDrivenSubstructure driven(part.model, boundary_of(study, part, offset));

  const Index samples = estimation.measurements.samples();
  const auto n_b = static_cast<Index>(driven.boundary().size());
  BoundaryMotion boundary{MatrixXd(n_b, samples), MatrixXd(n_b, samples), MatrixXd(n_b, samples)};
  VectorXd start = VectorXd::Zero(part.model.size()), start_rate = start;
  for (Index i = 0; i < part.model.size(); ++i) {
    const std::string point = part.name + "." + part.model.dofs[static_cast<std::size_t>(i)];
    if (const auto* estimated = find_point(estimation.points, point, displacement)) start[i] = estimated->mean[0];
    if (const auto* estimated = find_point(estimation.points, point, velocity)) start_rate[i] = estimated->mean[0];
  }
  for (Index b = 0; b < n_b; ++b) {
    const std::string point =
        part.name + "." + part.model.dofs[static_cast<std::size_t>(driven.boundary()[static_cast<std::size_t>(b)])];
    for (const auto& [quantity, rows] :
         {std::pair{displacement, &boundary.displacement}, std::pair{velocity, &boundary.velocity},
          std::pair{acceleration, &boundary.acceleration}}) {
      const auto* estimated = find_point(estimation.points, point, quantity);
      if (!estimated)
        throw InvalidInput(study.given.predict->substructure.issue(
            "the observer does not estimate the motion of '" + point + "'", "the substructure is driven by it",
            "hold the point in the observer or make it an interface"));
      rows->row(b) = estimated->mean.transpose();
    }
  }
  const auto motion =
      driven.predict(boundary, applied_forces(study, part, offset, estimation.measurements.start, samples), start,
                     start_rate, study.sample_rate());
  const auto* truth = results.simulation ? &results.simulation->reference.simulation.trajectory : nullptr;
  for (Index i = 0; i < part.model.size(); ++i)
    for (const auto& [quantity, predicted, reference] :
         {std::tuple{displacement, &motion.displacement, truth ? &truth->displacement : nullptr},
          std::tuple{acceleration, &motion.acceleration, truth ? &truth->acceleration : nullptr}}) {
      PointQuantity point{part.name + "." + part.model.dofs[static_cast<std::size_t>(i)],
                          quantity,
                          predicted->row(i).transpose(),
                          {},
                          {},
                          {}};
      if (reference) set_truth(point, reference->row(offset + i).transpose(), estimation.settled);
      stage.points.push_back(std::move(point));
    }
  stage.seconds = watch.seconds();
  return stage;
}

}  // namespace

StudyResults run_study(const Study& study, Stage last, const Progress& progress) {
  const Stopwatch watch;
  StudyResults results;
  if (study.given.simulate) results.simulation = simulate_stage(study, progress, results.failure);
  if (results.usable() && last >= Stage::estimate && study.observer)
    results.estimation = estimate_stage(study, results, progress, results.failure);
  if (results.usable() && last >= Stage::predict && study.given.predict)
    results.prediction = predict_stage(study, results);
  results.total_seconds = watch.seconds();
  return results;
}

}  // namespace kalfem
