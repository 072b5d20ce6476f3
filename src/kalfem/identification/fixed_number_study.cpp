// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/fixed_number_study.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/base/parallel.hpp"
#include "kalfem/estimation/fixed_gain.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/identification/white_innovations.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double step = 1e-4;        ///< of a number beside its value, in its scale
constexpr double most_memory = 1e9;  ///< of gains and derivatives [byte]
constexpr std::size_t runs_at_once = 8;
const std::vector<OutputDescription> no_outputs;
constexpr double narrow = 20.0;  ///< prior about the estimates, in their deviations
constexpr double level = 0.001;  ///< of the test of all numbers together
constexpr std::size_t most_confirmed = 3;
constexpr double most_change = 0.5;   ///< in a number's scale, of a run with it
constexpr double cost_of_mean = 0.1;  ///< filter steps that a step of the mean alone costs, about

/// The problem with the unknowns beginning at the estimates, within 20 of their deviations: sigma points of a wide
/// prior see another model than the one that the filter ends with.
EstimationProblemPtr about_estimates(const EstimationProblem& problem, const RecordEstimate& estimate) {
  auto about = std::make_shared<EstimationProblem>(problem);
  const Index last = estimate.result.unknowns.mean.cols() - 1;
  for (std::size_t i = 0; i < about->settings.unknowns.size(); ++i) {
    auto& unknown = about->settings.unknowns[i];
    const double value = estimate.result.unknowns.mean(static_cast<Index>(i), last);
    const double before = unknown.transform.slope(unknown.transform.to_state(unknown.initial));
    const double slope = unknown.transform.slope(unknown.transform.to_state(value));
    if (unknown.random_walk > 0.0 || !(slope > 1e-6 * before)) continue;
    unknown.initial = value;
    const double own = estimate.result.unknowns.deviation(static_cast<Index>(i), last);
    unknown.deviation = std::min(unknown.deviation * slope / before, narrow * own);
  }
  about->settings.substeps = estimate.augmented_model->options().substeps;
  about->settings.passes = 1;
  return about;
}

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

/// Runs of the mean with the gains of one filter, beside the numbers that are held fixed.
class RunsBeside {
public:
  RunsBeside(EstimationProblemPtr problem, const AugmentedModelSetup& setup, const Record& record,
             const RecordEstimate& estimate, const RecordEstimateOptions& options)
      : problem_(std::move(problem)), record_(record), monitored_(options.monitored), given_(setup) {
    numbers_ = fixed_numbers(*problem_, *setup.parts, setup, options.updated);
    leave_out_repeated_reductions();
    reduce_once();
    base_setup_ = setup_of(problem_, parts_);
    base_setup_.starts_at_rest = !estimate.start.moving;
    filter_ = make_filter_run(problem_, base_setup_, record_);
  }

  [[nodiscard]] const FilterRun& filter() const { return filter_; }
  [[nodiscard]] const std::vector<FixedNumber>& numbers() const { return numbers_; }
  [[nodiscard]] const std::vector<std::string>& left_out() const { return left_out_; }

  /// Of the gains, and of the derivatives of the innovations by every number [byte].
  [[nodiscard]] double memory() const {
    const auto values = static_cast<double>(filter_.input.measured.values.size());
    const auto states = static_cast<double>(filter_.choice.augmented_model->layout().size());
    return values * (states * sizeof(double) + static_cast<double>(numbers_.size()) * sizeof(float));
  }

  /// The run with the numbers as they are. False where it fails.
  bool run_base(Gains gains) {
    gains_ = std::move(gains);
    auto base = run({problem_, base_setup_}, any_stated());
    if (base) base_ = std::move(*base);
    return base.has_value();
  }

  /// d(.)/d c_i of everything that a run of the mean gives, by a run beside number i.
  [[nodiscard]] std::optional<FixedGainMeans> derivative(std::size_t i) const try {
    const bool monitors = numbers_[i].deviation > 0.0;
    auto moved = run(change_of(i, step), monitors);
    if (!moved) return std::nullopt;
    if (monitors) moved->monitored = (moved->monitored - base_.monitored) / step;
    moved->innovation = (moved->innovation - base_.innovation) / step;
    moved->unknowns = (moved->unknowns - base_.unknowns) / step;
    return moved;
  } catch (const InvalidInput&) {
    return std::nullopt;  // beside its value there is no structure
  }

  /// ln L of the filter with number i changed; minus infinity where it stops.
  [[nodiscard]] double log_likelihood(std::size_t i, double change, const EstimationOptions& options) const try {
    const FilterRun changed = run_of(change_of(i, change));
    const EstimationResult result = kalfem::estimate(*changed.choice.augmented_model, changed.input, options);
    return result.failure ? -std::numeric_limits<double>::infinity() : result.log_likelihood;
  } catch (const InvalidInput&) {
    return -std::numeric_limits<double>::infinity();
  }

private:
  /// Finite elements that unknowns of the filter follow are reduced with each model: their other numbers are left out.
  void leave_out_repeated_reductions() {
    if (given_.linear_unknowns.bindings.empty()) return;
    std::erase_if(numbers_, [&](const FixedNumber& number) {
      const bool of_elements =
          number.parameter && std::holds_alternative<FiniteElementParameter>(number.parameter->where);
      if (of_elements) left_out_.push_back(number.name);
      return of_elements;
    });
  }

  /// Finite elements keep one basis beside all numbers.
  void reduce_once() {
    parts_ = *given_.parts;
    std::vector<double> values;
    for (const auto& number : numbers_)
      if (number.parameter && std::holds_alternative<FiniteElementParameter>(number.parameter->where)) {
        bindings_.push_back({static_cast<Index>(values.size()), *number.parameter});
        values.push_back(number.value);
      }
    if (bindings_.empty()) return;
    of_elements_ = VectorXd::Map(values.data(), static_cast<Index>(values.size()));
    elements_.emplace(problem_->structure, bindings_, of_elements_.size());
    reduced_ = elements_->at(of_elements_);
    parts_.finite_elements = reduced_.parts.finite_elements;
  }

  [[nodiscard]] static AugmentedModelSetup setup_of(const EstimationProblemPtr& problem, const StructureParts& parts) {
    IssueList issues;
    auto setup = make_augmented_model_setup(*problem, parts, {}, issues);
    issues.raise();
    return setup;
  }

  /// The model of a run, and what is added to what it is given.
  struct Change {
    EstimationProblemPtr problem;
    AugmentedModelSetup setup;
    MatrixXd to_measured = {}, to_inputs = {};
  };

  [[nodiscard]] Change change_of(std::size_t i, double change) const {
    return numbers_[i].parameter ? change_of_parameter(i, change) : change_of_signal(numbers_[i], change);
  }

  [[nodiscard]] Change change_of_parameter(std::size_t i, double change) const {
    const FixedNumber& number = numbers_[i];
    const double value = number.value + change * number.scale;
    StructureParts parts = parts_;
    auto changed = std::make_shared<EstimationProblem>(*problem_);
    if (set_parameter(parts, *number.parameter, value)) {
      auto structure = std::make_shared<StructureModel>(*problem_->structure);
      set_parameter(structure->parts, *number.parameter, value);
      changed->structure = std::move(structure);
    } else {
      VectorXd values = of_elements_;
      const auto own =
          std::ranges::find(bindings_, number.name, [](const StructureBinding& each) { return each.target.name; });
      values[own->index] = value;
      parts.finite_elements = elements_->near(reduced_, values).finite_elements;
    }
    return {changed, setup_of(changed, parts)};
  }

  /// A sensor's recorded samples, or an excitation, as a gain or delay changes them. The sensor's are those that the
  /// model predicts: recorded ones hold the noise too.
  [[nodiscard]] Change change_of_signal(const FixedNumber& number, double change) const {
    const std::string of = number.name.substr(0, number.name.rfind('.'));
    if (const Index row = filter_.input.measured.find(of); row >= 0)
      return {problem_, base_setup_, change * added_to_sensor(row, number.is_delay()), {}};
    const auto source = std::ranges::find_if(base_setup_.input_sources,
                                             [&](const std::string& each) { return each == of || each == "@" + of; });
    return {problem_,
            base_setup_,
            {},
            change * added_to_input(source - base_setup_.input_sources.begin(), number.is_delay())};
  }

  [[nodiscard]] MatrixXd added_to_sensor(Index row, bool delay) const {
    const auto& measured = filter_.input.measured;
    MatrixXd added = MatrixXd::Zero(measured.values.rows(), measured.samples());
    const MatrixXd predicted = measured.values.row(row).leftCols(added.cols()) - base_.innovation.row(row);
    added.row(row) = delay ? MatrixXd(problem_->sample_rate * rate_of(predicted)) : MatrixXd(-predicted);
    return added;
  }

  [[nodiscard]] MatrixXd added_to_input(Index i, bool delay) const {
    const MatrixXd& inputs = filter_.input.inputs;
    const Index n_u = inputs.rows() / 3, stride = filter_.input.input_stride(*problem_->settings.substeps);
    MatrixXd added = MatrixXd::Zero(inputs.rows(), inputs.cols());
    for (Index d = 0; d < 3; ++d) {
      const Index row = d * n_u + i;
      if (!delay)
        added.row(row) = inputs.row(row);
      else if (d < 2)
        added.row(row) = -inputs.row(row + n_u);
      else
        added.row(row) = -problem_->sample_rate * static_cast<double>(stride) * rate_of(inputs.row(row));
    }
    return added;
  }

  [[nodiscard]] FilterRun run_of(const Change& change, std::optional<StateCoordinates> coordinates = {}) const {
    FilterRun beside = make_filter_run_like(filter_, change.problem, change.setup, record_, coordinates);
    if (change.to_measured.size() > 0)
      beside.input.measured.values.leftCols(change.to_measured.cols()) += change.to_measured;
    if (change.to_inputs.size() > 0) beside.input.inputs += change.to_inputs;
    return beside;
  }

  /// The mean with the gains; monitored quantities cost as much as the run, and are left out where they are not wanted.
  [[nodiscard]] std::optional<FixedGainMeans> run(const Change& change, bool monitors) const {
    const FilterRun beside = run_of(change, StateCoordinates::physical);
    OutputMap monitored = make_outputs(*change.setup.model, monitors ? monitored_ : no_outputs);
    if (monitors)
      monitored = with_inputs(std::move(monitored), held_by(problem_->settings.unknown_inputs, change.setup),
                              *change.setup.model);
    return run_with_gains(*beside.choice.augmented_model, beside.input, gains_, monitored, 0);
  }

  [[nodiscard]] bool any_stated() const {
    return std::ranges::any_of(numbers_, [](const FixedNumber& number) { return number.deviation > 0.0; });
  }

  EstimationProblemPtr problem_;
  const Record& record_;
  const std::vector<OutputDescription>& monitored_;
  const AugmentedModelSetup& given_;
  std::vector<FixedNumber> numbers_;
  std::vector<std::string> left_out_;
  StructureParts parts_;
  std::vector<StructureBinding> bindings_;  ///< of the numbers of finite elements
  VectorXd of_elements_;                    ///< their values
  std::optional<ParameterisedStructure> elements_;
  StructureAtParameters reduced_;
  AugmentedModelSetup base_setup_;
  FilterRun filter_;
  Gains gains_;
  FixedGainMeans base_;
};

/// (I + S^-1)^-1 g over the stated numbers but `without`.
VectorXd allowed_changes(const FixedNumberStudy& study, Index without) {
  std::vector<Index> stated;
  for (Index i = 0; i < study.size(); ++i)
    if (i != without && study.numbers[static_cast<std::size_t>(i)].deviation > 0.0) stated.push_back(i);
  VectorXd allowed = VectorXd::Zero(study.size());
  if (stated.empty()) return allowed;
  MatrixXd precision = study.information(stated, stated);
  for (std::size_t s = 0; s < stated.size(); ++s) {
    const double deviation = study.numbers[static_cast<std::size_t>(stated[s])].deviation;
    precision(static_cast<Index>(s), static_cast<Index>(s)) += 1.0 / (deviation * deviation);
  }
  const VectorXd score = study.score(stated), changes = precision.ldlt().solve(score);
  allowed(stated) = changes;
  return allowed;
}

/// Information on number i that is left when the other stated numbers are free within what is stated.
double remaining_information(const FixedNumberStudy& study, Index i) {
  FixedNumberStudy by_column = study;
  by_column.score = study.information.col(i);
  const VectorXd taken = allowed_changes(by_column, i);
  return study.information(i, i) - study.information.col(i).dot(taken);
}

void set_asked(FixedNumberStudy& study) {
  const Index count = study.size();
  study.allowed = allowed_changes(study, -1);
  study.asked = study.gain = VectorXd::Zero(count);
  study.asked_deviation = VectorXd::Constant(count, std::numeric_limits<double>::infinity());
  for (Index i = 0; i < count; ++i) {
    const double information = remaining_information(study, i);
    if (!(information > 1e-12 * study.information(i, i))) continue;
    const double score = study.score[i] - study.information.row(i).dot(allowed_changes(study, i));
    study.asked[i] = score / information;
    study.asked_deviation[i] = 1.0 / std::sqrt(information);
    study.gain[i] = 0.5 * score * score / information;
  }
}

/// The filter with the gains that the runs of the mean keep.
EstimationOptions filter_options(const FilterRun& run, const EstimationSettings& settings,
                                 const RecordEstimate& estimate) {
  EstimationOptions options{.filter = run.choice.filter,
                            .unscented = settings.unscented,
                            .threads = filter_threads(settings),
                            .state_means = false,
                            .state_deviations = false,
                            .keep_gains = true,
                            .adaptive_noise = settings.adaptive_noise,
                            .held_out = estimate.held_out};
  options.outliers.treatment = estimate.outliers;
  return options;
}

/// Collects what the runs beside the numbers tell, number by number.
class Collection {
public:
  Collection(const std::vector<FixedNumber>& numbers, const EstimationResult& result, const RecordEstimate& estimate)
      : whiten_(result), innovation_(whiten_(result.innovation).reshaped()), slope_(slopes(estimate)) {
    auto& study = found_.study;
    const auto count = static_cast<Index>(numbers.size()), samples = result.innovation.cols();
    study.numbers = numbers;
    study.shift = study.considered = MatrixXd::Zero(slope_.size(), count);
    study.score = VectorXd::Zero(count);
    study.confirmed = VectorXd::Constant(count, std::numeric_limits<double>::quiet_NaN());
    white_.setZero(innovation_.size(), count);
    if (!study.any_stated()) return;
    const Index quantities = estimate.result.monitored.mean.rows() + std::ssize(estimate.inputs);
    found_.considered = {MatrixXd::Zero(slope_.size(), samples), MatrixXd::Zero(quantities, samples),
                         MatrixXd::Zero(result.innovation.rows(), samples)};
  }

  void take(std::size_t n, const std::optional<FixedGainMeans>& derivative) {
    auto& study = found_.study;
    const auto i = static_cast<Index>(n);
    if (!derivative || !derivative->innovation.allFinite() || !derivative->unknowns.allFinite()) {
      study.failed.push_back(study.numbers[n].name);
      return;
    }
    const VectorXd moved = whiten_(derivative->innovation).reshaped();
    white_.col(i) = moved.cast<float>();
    study.score[i] = -moved.dot(innovation_);
    study.shift.col(i) = slope_.cwiseProduct(derivative->unknowns.rightCols(1));
    const double deviation = study.numbers[n].deviation;
    if (!(deviation > 0.0)) return;
    study.considered.col(i) = deviation * study.shift.col(i).cwiseAbs();
    found_.considered.unknowns += (deviation * derivative->unknowns).cwiseAbs2();
    found_.considered.monitored += (deviation * derivative->monitored).cwiseAbs2();
    stated_.emplace_back(i, derivative->innovation);
  }

  FixedNumberResult finish() && {
    found_.study.information = (white_.transpose() * white_).cast<double>();
    set_asked(found_.study);
    auto& considered = found_.considered;
    considered.unknowns = considered.unknowns.cwiseSqrt();
    considered.monitored = considered.monitored.cwiseSqrt();
    for (const auto& [i, derivative] : stated_) considered.innovation += found_.study.allowed[i] * derivative;
    return std::move(found_);
  }

private:
  /// d theta / d x of every unknown at its last estimate.
  static VectorXd slopes(const RecordEstimate& estimate) {
    const auto& state = estimate.result.state.mean;
    const auto& unknowns = estimate.augmented_model->options().unknowns;
    VectorXd slope(std::ssize(unknowns));
    for (Index j = 0; j < slope.size(); ++j)
      slope[j] = unknowns[static_cast<std::size_t>(j)].transform.slope(
          state(estimate.augmented_model->layout().unknown() + j, state.cols() - 1));
    return slope;
  }

  WhiteInnovations whiten_;
  VectorXd innovation_;  ///< white, channels and then samples
  VectorXd slope_;
  Eigen::MatrixXf white_;                           ///< d nu / d c, white, one column a number
  std::vector<std::pair<Index, MatrixXd>> stated_;  ///< d nu / d c of the stated numbers
  FixedNumberResult found_;
};

/// Runs the filter with the likeliest changes themselves, as their linear prediction may reach too far: along a
/// direction that the record hardly tells, a change is large. Where numbers are stated the prediction counts.
void confirm(const RunsBeside& runs, EstimationOptions options, double log_likelihood, FixedNumberStudy& study) {
  if (study.any_stated()) return;
  options.keep_gains = false;
  std::vector<Index> likely;
  for (Index i = 0; i < study.size(); ++i)
    if (study.is_significant(i)) likely.push_back(i);
  std::ranges::stable_sort(likely, std::ranges::greater{}, [&](Index i) { return study.gain[i]; });
  if (likely.size() > most_confirmed) likely.resize(most_confirmed);
  for_each_index(likely.size(), processors(), [&](std::size_t n) {
    const Index i = likely[n];
    const double change = std::clamp(study.asked[i], -most_change, most_change);
    study.confirmed[i] = runs.log_likelihood(static_cast<std::size_t>(i), change, options) - log_likelihood;
  });
}

}  // namespace

bool FixedNumberStudy::is_significant(Index i) const {
  const double expected = std::hypot(numbers[static_cast<std::size_t>(i)].deviation, asked_deviation[i]);
  const double limit = normal_quantile(1.0 - 0.5 * level / static_cast<double>(size()));
  return std::isfinite(expected) && std::abs(asked[i]) > limit * expected;
}

bool FixedNumberStudy::any_stated() const {
  return std::ranges::any_of(numbers, [](const FixedNumber& number) { return number.deviation > 0.0; });
}

std::optional<FixedNumberResult> study_fixed_numbers(const EstimationProblemPtr& problem,
                                                     const AugmentedModelSetup& setup, const Record& record,
                                                     const RecordEstimate& estimate,
                                                     const RecordEstimateOptions& options, StepBudget& budget) try {
  const EstimationProblemPtr about = about_estimates(*problem, estimate);
  RunsBeside runs(about, setup, record, estimate, options);
  const std::size_t count = runs.numbers().size();
  if (count == 0 || runs.memory() > most_memory) return std::nullopt;
  const double pass = steps_of_run(*about, record, *about->settings.substeps);
  if (!budget.take(pass * (1.0 + cost_of_mean * static_cast<double>(count + 1)))) return std::nullopt;

  const FilterRun& filter = runs.filter();
  EstimationOptions options_of_filter = filter_options(filter, problem->settings, estimate);
  EstimationResult result = kalfem::estimate(*filter.choice.augmented_model, filter.input, options_of_filter);
  if (result.failure || !runs.run_base(std::move(result.gains))) return std::nullopt;
  Collection collection(runs.numbers(), result, estimate);
  for (std::size_t first = 0; first < count; first += runs_at_once) {
    std::vector<std::optional<FixedGainMeans>> derivatives(std::min(runs_at_once, count - first));
    for_each_index(derivatives.size(), filter_threads(problem->settings),
                   [&](std::size_t n) { derivatives[n] = runs.derivative(first + n); });
    for (std::size_t n = 0; n < derivatives.size(); ++n) collection.take(first + n, derivatives[n]);
  }
  FixedNumberResult found = std::move(collection).finish();
  confirm(runs, options_of_filter, result.log_likelihood, found.study);
  found.study.failed.insert(found.study.failed.end(), runs.left_out().begin(), runs.left_out().end());
  return found;
} catch (const InvalidInput&) {
  return std::nullopt;  // at the estimates there is no structure
}

}  // namespace kalfem
