// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/runs_beside.hpp"

#include <algorithm>
#include <utility>

#include "kalfem/base/parallel.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double step = 1e-4;             ///< of a number beside its value, in its scale
constexpr double most_at_once = 64.0;     ///< numbers of a group
constexpr double cost_of_mean = 0.2;      ///< filter steps that a step of the mean alone costs, about
constexpr double cost_of_tangent = 0.05;  ///< that the tangent of a number adds to it
constexpr double most_memory = 2e8;       ///< of their derivatives, and of what their models differ in [byte]

/// The central differences of a series over its samples, [1/sample]; at its ends one-sided.
MatrixXd rate_of(const MatrixXd& series) {
  const Index last = series.cols() - 1;
  MatrixXd rate = MatrixXd::Zero(series.rows(), series.cols());
  for (Index k = 0; k <= last && last > 0; ++k) {
    const Index before = std::max<Index>(k - 1, 0), after = std::min(k + 1, last);
    rate.col(k) = (series.col(after) - series.col(before)) / static_cast<double>(after - before);
  }
  return rate;
}

AugmentedModelSetup setup_of(const EstimationProblemPtr& problem, const StructureParts& parts,
                             const HeldElements& held) {
  IssueList issues;
  auto setup = make_augmented_model_setup(*problem, parts, {}, issues, {}, held);
  issues.raise();
  return setup;
}

bool is_of_finite_elements(const FixedNumber& number) {
  return number.parameter && std::holds_alternative<FiniteElementParameter>(number.parameter->where);
}

bool is_stated(const FixedNumber& number) { return number.deviation > 0.0; }

}  // namespace

RunsBeside::RunsBeside(EstimationProblemPtr problem, const AugmentedModelSetup& setup, const Record& record,
                       const RecordEstimate& estimate, const RecordEstimateOptions& options,
                       const ChangedNumbers& changed)
    : problem_(std::move(problem)), record_(record), monitored_(options.monitored), given_(setup) {
  numbers_ = changed.empty() ? fixed_numbers(*problem_, *setup.parts, setup, options.updated) : changed.numbers;
  stand_at_ = changed.empty() ? VectorXd::Zero(std::ssize(numbers_)) : changed.changes;
  reduce_once();
  base_setup_ = setup_of(problem_, parts_, held_);
  held_.structure = base_setup_.linear_unknowns.structure;
  base_setup_.starts_at_rest = !estimate.start.moving;
  filter_ = make_filter_run(problem_, base_setup_, record_);
}

double RunsBeside::steps() const {
  const double of_number = carries_tangents() ? cost_of_tangent : cost_of_mean;
  return steps_of_run(*problem_, record_, *problem_->settings.substeps) *
         (1.0 + cost_of_mean + of_number * static_cast<double>(numbers_.size()));
}

double RunsBeside::memory() const {
  const auto values = static_cast<double>(filter_.input.measured.values.size());
  const auto states = static_cast<double>(filter_.choice.augmented_model->layout().size());
  return values * (states * sizeof(double) + static_cast<double>(numbers_.size()) * sizeof(float));
}

bool RunsBeside::run_base(Gains gains) {
  gains_ = std::move(gains);
  const Change none{problem_, base_setup_};
  base_run_ = run_of(none, StateCoordinates::physical);
  const bool monitors = std::ranges::any_of(numbers_, is_stated);
  if (carries_tangents()) {
    base_open_ = open(none, false);
    if (monitors) base_open_monitored_ = open(none, true);
  }
  auto base = run(base_run_, monitored_by(none, monitors));
  if (base) base_ = std::move(*base);
  return base.has_value();
}

/// Runs beside numbers share nothing; tangents share the run of the mean and the Jacobians.
std::vector<std::vector<std::size_t>> RunsBeside::groups() const {
  const auto samples = static_cast<double>(record_.samples());
  std::vector<std::vector<std::size_t>> all;
  for (const bool stated : {true, false}) {
    const double rows = static_cast<double>(base_run_.input.measured.values.rows() + base_.unknowns.rows() +
                                            (stated ? base_.monitored.rows() : 0)),
                 of_one = sizeof(double) * (rows * samples + 2.0 * static_cast<double>(base_open_.process.all.size()));
    const auto at_once =
        carries_tangents() ? static_cast<std::size_t>(std::clamp(most_memory / of_one, 1.0, most_at_once)) : 1;
    std::vector<std::size_t> group;
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      if (is_stated(numbers_[i]) != stated) continue;
      if (group.size() == at_once) all.push_back(std::exchange(group, {}));
      group.push_back(i);
    }
    if (!group.empty()) all.push_back(std::move(group));
  }
  return all;
}

std::vector<NumberDerivative> RunsBeside::derivatives(const std::vector<std::size_t>& group) const {
  std::vector<NumberDerivative> found(group.size());
  std::vector<std::optional<RunDerivative>> made(group.size());
  for_each_index(group.size(), std::min(processors(), filter_threads(problem_->settings)),
                 [&](std::size_t n) { made[n] = tangent_of(group[n]); });
  std::vector<RunDerivative> tangents;
  std::vector<std::size_t> carried;
  for (std::size_t n = 0; n < group.size(); ++n)
    if (made[n]) {
      tangents.push_back(std::move(*made[n]));
      carried.push_back(n);
    }
  const bool monitors = !group.empty() && is_stated(numbers_[group.front()]);
  auto means = run_tangents(*base_run_.choice.augmented_model, base_run_.input, gains_,
                            monitored_by({problem_, base_setup_}, monitors), 0, base_.largest, tangents);
  for (std::size_t n = 0; means && n < carried.size(); ++n) found[carried[n]].means = std::move((*means)[n]);
  for (std::size_t n = 0; n < group.size(); ++n)
    if (!found[n].means) found[n] = {quotient(group[n], beside(group[n], step), base_, step), true};
  return found;
}

/// Nothing where the number changes what the filter's model is made of, or has no model on either side.
std::optional<RunDerivative> RunsBeside::tangent_of(std::size_t i) const try {
  if (!carries_tangents()) return std::nullopt;
  if (!numbers_[i].parameter) {
    Change one = change_of(i, 1.0);
    return RunDerivative{.measured = std::move(one.to_measured), .inputs = std::move(one.to_inputs)};
  }
  const bool monitors = is_stated(numbers_[i]);
  return central_difference(monitors ? base_open_monitored_ : base_open_, open(change_of(i, -step), monitors),
                            open(change_of(i, step), monitors), 2.0 * step);
} catch (const InvalidInput&) {
  return std::nullopt;
}

OpenModel RunsBeside::open(const Change& change, bool monitors) const {
  const auto model = augmented_model_like(filter_, change.problem, change.setup, record_, StateCoordinates::physical);
  return open_model(*model, base_run_.input, monitored_by(change, monitors));
}

std::optional<FixedGainMeans> RunsBeside::difference(std::size_t i, double by) const {
  const auto below = beside(i, -by);
  return below ? quotient(i, beside(i, by), *below, 2.0 * by) : std::nullopt;
}

std::optional<FixedGainMeans> RunsBeside::quotient(std::size_t i, std::optional<FixedGainMeans> above,
                                                   const FixedGainMeans& below, double distance) const {
  if (!above) return std::nullopt;
  above->innovation = (above->innovation - below.innovation) / distance;
  above->unknowns = (above->unknowns - below.unknowns) / distance;
  if (is_stated(numbers_[i])) above->monitored = (above->monitored - below.monitored) / distance;
  return above;
}

/// Nothing where the changed number makes no structure.
std::optional<FixedGainMeans> RunsBeside::beside(std::size_t i, double change) const try {
  const Change changed = change_of(i, change);
  return run(run_of(changed, StateCoordinates::physical), monitored_by(changed, is_stated(numbers_[i])));
} catch (const InvalidInput&) {
  return std::nullopt;
}

double log_likelihood_from(const EstimationResult& result, Index first) {
  return result.log_density.tail(result.log_density.size() - first).sum();
}

/// Finite elements keep one basis beside all numbers. Those that unknowns of the filter follow have it with these.
void RunsBeside::reduce_once() {
  parts_ = *given_.parts;
  std::vector<double> values;
  for (std::size_t i = 0; i < numbers_.size(); ++i)
    if (is_of_finite_elements(numbers_[i])) {
      held_.parameters.push_back(*numbers_[i].parameter);
      values.push_back(value_with(i, 0.0));
    }
  held_.values = VectorXd::Map(values.data(), static_cast<Index>(values.size()));
  if (values.empty() || follows_unknowns()) return;
  std::vector<StructureBinding> bindings;
  for (const auto& parameter : held_.parameters) bindings.push_back({std::ssize(bindings), parameter});
  elements_.emplace(problem_->structure, bindings, std::ssize(bindings));
  reduced_ = elements_->at(held_.values);
  parts_.finite_elements = reduced_.parts.finite_elements;
}

bool RunsBeside::follows_unknowns() const { return !given_.linear_unknowns.bindings.empty(); }

double RunsBeside::value_with(std::size_t i, double change) const {
  return numbers_[i].value + (stand_at_[static_cast<Index>(i)] + change) * numbers_[i].scale;
}

RunsBeside::Change RunsBeside::change_of(std::size_t i, double change) const {
  const auto& number = numbers_[i];
  return number.parameter ? change_of_parameter(*number.parameter, value_with(i, change))
                          : change_of_signal(number, change);
}

RunsBeside::Change RunsBeside::change_of_parameter(const Parameter& parameter, double value) const {
  StructureParts parts = parts_;
  auto changed = std::make_shared<EstimationProblem>(*problem_);
  if (set_parameter(parts, parameter, value)) {
    auto structure = std::make_shared<StructureModel>(*problem_->structure);
    set_parameter(structure->parts, parameter, value);
    changed->structure = std::move(structure);
    return {changed, setup_of(changed, parts, held_)};
  }
  HeldElements held = held_;
  held.values[std::ranges::find(held.parameters, parameter.name, &Parameter::name) - held.parameters.begin()] = value;
  if (!follows_unknowns()) parts.finite_elements = elements_->near(reduced_, held.values).finite_elements;
  return {changed, setup_of(changed, parts, held)};
}

/// A sensor's recorded samples, or an excitation, as a gain or clock changes them. The sensor's are those that the
/// model predicts: recorded ones hold the noise too.
RunsBeside::Change RunsBeside::change_of_signal(const FixedNumber& number, double change) const {
  const std::string of = number.name.substr(0, number.name.rfind('.'));
  if (const Index row = filter_.input.measured.find(of); row >= 0)
    return {problem_, base_setup_, change * added_to_sensor(row, number), {}};
  const auto source = std::ranges::find_if(base_setup_.input_sources,
                                           [&](const std::string& each) { return each == of || each == "@" + of; });
  return {problem_,
          base_setup_,
          {},
          change * added_to_input(source - base_setup_.input_sources.begin(), number.is_delay())};
}

MatrixXd RunsBeside::added_to_sensor(Index row, const FixedNumber& number) const {
  const auto& measured = filter_.input.measured;
  MatrixXd added = MatrixXd::Zero(measured.values.rows(), measured.samples());
  const MatrixXd predicted = base_.predicted.row(row);
  added.row(row) = number.is_of_clock() ? MatrixXd(problem_->sample_rate * rate_of(predicted)) : MatrixXd(-predicted);
  const double since = problem_->settings.clocks_since.value_or(record_.start);
  for (Index k = 0; k < added.cols() && number.is_drift(); ++k) added(row, k) *= record_.time(k) - since;
  return added;
}

MatrixXd RunsBeside::added_to_input(Index input, bool delay) const {
  const MatrixXd& inputs = filter_.input.inputs;
  const Index n_u = inputs.rows() / 3,
              stride = filter_.input.input_stride(filter_.choice.augmented_model->options().instants());
  MatrixXd added = MatrixXd::Zero(inputs.rows(), inputs.cols());
  for (Index d = 0; d < 3; ++d) {
    const Index row = d * n_u + input;
    if (!delay)
      added.row(row) = inputs.row(row);
    else if (d < 2)
      added.row(row) = -inputs.row(row + n_u);
    else
      added.row(row) = -problem_->sample_rate * static_cast<double>(stride) * rate_of(inputs.row(row));
  }
  return added;
}

FilterRun RunsBeside::run_of(const Change& change, std::optional<StateCoordinates> coordinates) const {
  FilterRun beside = make_filter_run_like(filter_, change.problem, change.setup, record_, coordinates);
  if (change.to_measured.size() > 0)
    beside.input.measured.values.leftCols(change.to_measured.cols()) += change.to_measured;
  if (change.to_inputs.size() > 0) beside.input.inputs += change.to_inputs;
  return beside;
}

/// They cost as much as the run, and are left out where they are not wanted.
OutputMap RunsBeside::monitored_by(const Change& change, bool monitors) const {
  OutputMap monitored = make_outputs(*change.setup.model, monitors ? monitored_ : std::vector<OutputDescription>{});
  if (!monitors) return monitored;
  return with_inputs(std::move(monitored), held_by(problem_->settings.unknown_inputs, change.setup),
                     *change.setup.model);
}

std::optional<FixedGainMeans> RunsBeside::run(const FilterRun& beside, const OutputMap& monitored) const {
  return run_with_gains(*beside.choice.augmented_model, beside.input, gains_, monitored, 0);
}

}  // namespace kalfem
