// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/record_residual.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <numeric>
#include <sstream>

#include "kalfem/identification/finer_motion.hpp"
#include "kalfem/identification/refined_filter.hpp"
#include "kalfem/identification/settling.hpp"
#include "kalfem/linalg/sparse_operations.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index motion_parts = 8;  ///< of a sample interval, between which the boundary's motion is taken as straight

/// Displacement, velocity and acceleration of each point, in the coordinates of the system: relative to an accelerated
/// base.
std::vector<OutputDescription> motion_outputs(const std::vector<std::string>& points) {
  std::vector<OutputDescription> outputs;
  for (const auto quantity :
       {ObservedQuantity::displacement, ObservedQuantity::velocity, ObservedQuantity::acceleration})
    for (const auto& point : points) outputs.push_back({point, quantity, {{point, 1.0}}, true});
  return outputs;
}

BoundaryMotion motion_from(const MatrixXd& monitored, Index first) {
  const Index n_b = monitored.rows() / 3, samples = monitored.cols() - first;
  return {monitored.block(0, first, n_b, samples), monitored.block(n_b, first, n_b, samples),
          monitored.block(2 * n_b, first, n_b, samples)};
}

/// Rows of the sensors' quantities over the substructure's degrees of freedom.
SparseRows rows_of(const OutputMap& outputs, const DrivenSubstructure::Place& place) {
  const SparseRows sum = outputs.displacement + outputs.velocity + outputs.acceleration;  // one of them each
  std::vector<Index> all(static_cast<std::size_t>(sum.rows()));
  std::iota(all.begin(), all.end(), Index{0});
  return select(sum, all, place.dofs);
}

/// T_d r + T_v r' + T_a r'': what the sensors see of the base's own motion, samples x sensors.
MatrixXd direct_part(const EstimationProblem& problem, const OutputMap& outputs, double start, Index samples) {
  MatrixXd direct = MatrixXd::Zero(samples, outputs.size());
  for (std::size_t i = 0; i < problem.structure->signals.size(); ++i) {
    const auto input = static_cast<Index>(i);
    if (outputs.input_value.col(input).isZero(0.0) && outputs.input_rate.col(input).isZero(0.0) &&
        outputs.input_acceleration.col(input).isZero(0.0))
      continue;
    const auto signal = problem.structure->signals[i]->sample(start, 1.0 / problem.sample_rate, samples);
    direct += signal.col(0).matrix() * outputs.input_value.col(input).transpose() +
              signal.col(1).matrix() * outputs.input_rate.col(input).transpose() +
              signal.col(2).matrix() * outputs.input_acceleration.col(input).transpose();
  }
  return direct;
}

const MatrixXd& quantity_of(const PredictedMotion& motion, ObservedQuantity quantity) {
  if (quantity == ObservedQuantity::displacement) return motion.displacement;
  return quantity == ObservedQuantity::velocity ? motion.velocity : motion.acceleration;
}

/// max over v of |(other - exact) v| / |exact v|: the largest singular value of (other - exact) R^-1 with exact = Q R.
/// Infinite where some direction does not change `exact`.
double largest_relative_error(const MatrixXd& exact, const MatrixXd& other) {
  // Columns of length one: what is singular does not depend on the parameters' units.
  const VectorXd lengths = exact.colwise().norm();
  if (!(lengths.minCoeff() > 0.0)) return std::numeric_limits<double>::infinity();
  const VectorXd scale = lengths.cwiseInverse();
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(exact * scale.asDiagonal());
  if (qr.rank() < exact.cols()) return std::numeric_limits<double>::infinity();
  MatrixXd error = (other - exact) * scale.asDiagonal() * qr.colsPermutation();
  const MatrixXd R = qr.matrixR().topRows(exact.cols());
  R.triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(error);
  const double largest = Eigen::SelfAdjointEigenSolver<MatrixXd>(error.transpose() * error).eigenvalues().maxCoeff();
  return std::isfinite(largest) ? std::sqrt(largest) : std::numeric_limits<double>::infinity();
}

/// With two significant digits.
std::string rounded(double value) {
  std::ostringstream text;
  text << std::setprecision(2) << value;
  return text.str();
}

std::string per_cent(double fraction) {
  return fraction < 10.0 ? rounded(100.0 * fraction) + " %" : "more than 1000 %";
}

}  // namespace

RecordResidual::RecordResidual(EstimationProblemPtr problem, Record record,
                               std::shared_ptr<const ParameterisedStructure> structure, UpdatingSetup updating,
                               Options options)
    : problem_(std::move(problem)),
      record_(std::move(record)),
      structure_(std::move(structure)),
      options_(std::move(options)),
      updating_(std::move(updating)) {
  for (const auto& sensor : problem_->sensors)
    if (std::ranges::find(options_.sensors, sensor.name) != options_.sensors.end()) sensors_.push_back(sensor);
  const auto samples = record_.samples();
  const VectorXd start = initial_values(updating_.parameters);
  const StructureAtParameters here = structure_->at(start);
  choose_substeps_and_start(here, start);
  settled_ = first_settled_sample(problem_->settings, augmented_model_at(here.parts, start),
                                  RecordStart{.moving = !*starts_at_rest_}, record_);
  if (settled_ >= samples - 1)
    throw InvalidInput("estimate.settle covers the whole record", "no sample is left to compare", "shorten it");
  measured_.resize(samples, static_cast<Index>(sensors_.size()));
  for (std::size_t j = 0; j < sensors_.size(); ++j)
    measured_.col(static_cast<Index>(j)) = record_.values.row(record_.find(sensors_[j].name)).transpose();
  const double none = std::numeric_limits<double>::infinity();
  const auto counted = samples - settled_;
  deviation_ = MatrixXd::Constant(counted, measured_.cols(), none);
  choose_derivatives(here, start);
}

void RecordResidual::choose_substeps_and_start(const StructureAtParameters& here, const VectorXd& start) {
  if (const auto given = problem_->settings.substeps) {
    starts_at_rest_ = !make_filter_run(problem_, augmented_model_at(here.parts, start), record_).start.moving;
    substeps_ = {.substeps = *given, .words = "given"};
    return;
  }
  const auto refined = run_refined_filter(problem_, augmented_model_at(here.parts, start), record_,
                                          {.unscented = problem_->settings.unscented,
                                           .threads = filter_threads(problem_->settings),
                                           .passes = problem_->settings.passes,
                                           .state_deviations = false});
  substeps_ = refined.substeps;
  starts_at_rest_ = !refined.filtered.run.start.moving;
}

/// The first filter pass: the deviations, and what the gains that it leaves are worth.
void RecordResidual::choose_derivatives(const StructureAtParameters& here, const VectorXd& start) {
  using enum Derivatives;
  explanation_ = "filter passes";
  hold_gains_ = options_.derivatives != filter_passes;
  if (const double memory = hold_gains_ ? gain_memory(here.parts, start) : 0.0; memory > options_.most_gain_memory) {
    hold_gains_ = false;
    explanation_ += ": held gains would take " + rounded(1e-9 * memory) + " GB (at most " +
                    rounded(1e-9 * options_.most_gain_memory) + " GB)";
  }
  if (hold_gains_) explanation_ = "held gains, not compared with filter passes";
  const auto first = estimate_at(here.parts, start, hold_gains_);
  if (!first) return;
  const Index counted = deviation_.rows();
  deviation_ = measured_.bottomRows(counted).array().isNaN().select(deviation_, first->deviation.bottomRows(counted));
  if (hold_gains_ && options_.derivatives == held_gains_where_accurate) check_held_gains(here, start, *first);
}

void RecordResidual::check_held_gains(const StructureAtParameters& here, const VectorXd& start,
                                      const Estimate& first) try {
  hold_gains_ = false;
  explanation_ = "filter passes: at the first parameters a run for the derivatives failed";
  const VectorXd values = weighted(predict_from(first));
  const auto exact = jacobian_at(here, start, values, {});
  const auto held = exact ? jacobian_at(here, start, values, first.gains) : std::nullopt;
  if (!held) return;
  const double error = largest_relative_error(*exact, *held);
  hold_gains_ = error <= options_.largest_error;
  explanation_ = (hold_gains_ ? "held gains: derivatives differ from those by filter passes by at most "
                              : "filter passes: derivatives with held gains would differ by up to ") +
                 per_cent(error) + " (limit " + per_cent(options_.largest_error) + ")";
} catch (const InvalidInput&) {
  return;  // beside the first parameters there is no structure: evaluate() says the same
}

double RecordResidual::gain_memory(const StructureParts& parts, const VectorXd& parameters) const {
  const FilterRun run = make_filter_run(problem_, augmented_model_at(parts, parameters), record_);
  const auto gain = run.choice.augmented_model->layout().size() * run.input.measured.values.rows();
  return static_cast<double>(gain) * static_cast<double>(run.input.measured.samples() * sizeof(double));
}

AugmentedModelSetup RecordResidual::augmented_model_at(const StructureParts& parts, const VectorXd& parameters) const {
  IssueList issues;
  AugmentedModelSetup setup =
      make_augmented_model_setup(*problem_, parts, present_values(updating_, parameters), issues);
  issues.raise();
  setup.starts_at_rest = starts_at_rest_;
  if (substeps_) setup.options.substeps = substeps_->substeps;
  return setup;
}

RecordResidual::Estimate RecordResidual::structure_of(const StructureParts& parts) const {
  Estimate estimate;
  estimate.model = std::make_shared<const CoupledModel>(couple(parts));
  estimate.drive =
      std::make_shared<const DrivenSubstructure>(*problem_->structure, *estimate.model, options_.substructure);
  estimate.start.time = record_.start + static_cast<double>(first_predicted()) / problem_->sample_rate;
  return estimate;
}

/// The substructure's own part of the augmented state at the first predicted sample.
void RecordResidual::set_start(const VectorXd& state, Index velocity, Estimate& estimate) const {
  if (problem_->settings.local) return;
  const auto& dofs = estimate.drive->place().dofs;
  estimate.start.displacement = state(dofs);
  estimate.start.velocity = state.tail(state.size() - velocity)(dofs);
}

std::optional<RecordResidual::Estimate> RecordResidual::estimate_at(const StructureParts& parts,
                                                                    const VectorXd& parameters, bool keep_gains) const {
  const AugmentedModelSetup setup = augmented_model_at(parts, parameters);
  Estimate estimate = structure_of(parts);
  const FilterRun run = make_filter_run(problem_, setup, record_);
  const auto samples = record_.samples();
  EstimationResult result =
      kalfem::estimate(*run.choice.augmented_model, run.input,
                       {.filter = run.choice.filter,
                        .unscented = problem_->settings.unscented,
                        .threads = 1,
                        .passes = problem_->settings.passes,
                        .state_deviations = false,
                        .deviation_stride = static_cast<int>(samples),
                        .keep_gains = keep_gains,
                        .monitored = make_outputs(*setup.model, motion_outputs(estimate.drive->points()))});
  if (result.failure) return std::nullopt;
  estimate.motion = motion_from(result.monitored.mean, first_predicted());
  set_start(result.state.mean.col(first_predicted()), run.choice.augmented_model->layout().velocity(), estimate);
  estimate.gains = std::move(result.gains);
  estimate.deviation.resize(samples, measured_.cols());
  for (std::size_t j = 0; j < sensors_.size(); ++j) {
    auto column = estimate.deviation.col(static_cast<Index>(j));
    const auto channel = std::ranges::find(setup.sensors, sensors_[j].name, &Sensor::name);
    if (channel == setup.sensors.end())  // it drives the augmented model
      column.setConstant(record_.channels[static_cast<std::size_t>(record_.find(sensors_[j].name))].noise);
    else
      column = result.innovation_deviation.row(channel - setup.sensors.begin()).transpose();
  }
  return estimate;
}

std::optional<RecordResidual::Estimate> RecordResidual::fixed_gain_run_at(const StructureParts& parts,
                                                                          const VectorXd& parameters,
                                                                          const Gains& gains) const {
  const AugmentedModelSetup setup = augmented_model_at(parts, parameters);
  Estimate estimate = structure_of(parts);
  const FilterRun run = make_filter_run(problem_, setup, record_, StateCoordinates::physical);
  const auto means =
      run_with_gains(*run.choice.augmented_model, run.input, gains,
                     make_outputs(*setup.model, motion_outputs(estimate.drive->points())), first_predicted());
  if (!means) return std::nullopt;
  estimate.motion = motion_from(means->monitored, first_predicted());
  set_start(means->state, run.choice.augmented_model->layout().velocity(), estimate);
  return estimate;
}

// Predicts each sensor in four steps: rows of the sensors over the substructure, response of the substructure to the
// estimated motion of its boundary, direct part of the base motion, measurement chain of the sensor. Samples before
// the start of the estimate stay zero; weighted() does not count them.
MatrixXd RecordResidual::predict_from(const Estimate& estimate) const {
  std::vector<OutputDescription> outputs;
  for (const auto& sensor : sensors_) outputs.push_back(sensor.output);
  const OutputMap map = make_outputs(*estimate.model, outputs);
  const auto& drive = *estimate.drive;
  const auto motion =
      drive.predict(rows_of(map, drive.place()), finer_motion(estimate.motion, motion_parts), estimate.start,
                    {.sample_rate = problem_->sample_rate * static_cast<double>(motion_parts), .newmark_substeps = 1});
  const Index samples = estimate.motion.acceleration.cols();
  const auto at_samples = Eigen::seqN(Index{0}, samples, motion_parts);
  const MatrixXd direct = direct_part(*problem_, map, estimate.start.time, samples);
  MatrixXd sensors = MatrixXd::Zero(measured_.rows(), measured_.cols());
  for (std::size_t j = 0; j < sensors_.size(); ++j) {
    const auto column = static_cast<Index>(j);
    const VectorXd predicted =
        quantity_of(motion, sensors_[j].output.quantity)(column, at_samples).transpose() + direct.col(column);
    sensors.col(column).tail(samples) = sensors_[j].chain.filter(predicted, problem_->sample_rate);
  }
  return sensors;
}

// r = (predicted - measured) / sigma over the counted samples. A missing sample has an infinite sigma and a NaN
// difference; both give a residual of zero, so the size of r does not depend on the parameters.
VectorXd RecordResidual::weighted(const MatrixXd& sensors) const {
  const Index counted = deviation_.rows();
  const MatrixXd difference = sensors.bottomRows(counted) - measured_.bottomRows(counted);
  const MatrixXd values = difference.array().isNaN().select(0.0, difference.cwiseQuotient(deviation_));
  return values.reshaped();
}

std::optional<VectorXd> RecordResidual::values_at(const StructureParts& parts, const VectorXd& parameters,
                                                  const Gains& gains) const {
  const auto estimate =
      gains.empty() ? estimate_at(parts, parameters, false) : fixed_gain_run_at(parts, parameters, gains);
  if (!estimate) return std::nullopt;
  return weighted(predict_from(*estimate));
}

std::optional<MatrixXd> RecordResidual::jacobian_at(const StructureAtParameters& here, const VectorXd& parameters,
                                                    const VectorXd& values, const Gains& gains) const {
  // Runs beside theta, and with held gains in a last column at theta itself.
  const Index count = parameters.size(), columns = gains.empty() ? count : count + 1;
  VectorXd steps(count);
  for (Index i = 0; i < count; ++i)
    steps[i] = options_.relative_step * updating_.parameters[static_cast<std::size_t>(i)].scale();
  const auto runs = parallel_columns(size(), columns, filter_threads(problem_->settings), [&](Index i) {
    if (i == count) return values_at(here.parts, parameters, gains);
    const VectorXd moved = parameters + steps[i] * VectorXd::Unit(count, i);
    return values_at(structure_->near(here, moved), moved, gains);
  });
  if (!runs) return std::nullopt;
  const VectorXd base = gains.empty() ? values : VectorXd(runs->col(count));
  return (runs->leftCols(count).colwise() - base) * steps.cwiseInverse().asDiagonal();
}

std::optional<ResidualValue> RecordResidual::evaluate(const VectorXd& parameters, bool with_jacobian) const try {
  const StructureAtParameters here = structure_->at(parameters);
  const auto estimate = estimate_at(here.parts, parameters, with_jacobian && hold_gains_);
  if (!estimate) return std::nullopt;
  ResidualValue value{weighted(predict_from(*estimate)), {}};
  if (!with_jacobian) return value;
  auto jacobian = jacobian_at(here, parameters, value.values, estimate->gains);
  if (!jacobian) return std::nullopt;
  value.jacobian = std::move(*jacobian);
  return value;
} catch (const InvalidInput&) {
  return std::nullopt;
}

}  // namespace kalfem
