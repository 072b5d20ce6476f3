// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/fixed_number_study.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/runs_beside.hpp"
#include "kalfem/identification/white_innovations.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double most_memory = 1e9;  ///< of gains and derivatives [byte]
constexpr double level = 0.005;      ///< of the test of all numbers together
constexpr std::size_t most_confirmed = 3;
constexpr double most_change = 0.5;       ///< in a number's scale, of a run with it
constexpr double prior_breadth = 20.0;    ///< in deviations of an unknown: a number that is wrong moves it by some ten
constexpr double cost_of_mean = 0.2;      ///< filter steps that a step of the mean alone costs, about
constexpr double cost_of_tangent = 0.05;  ///< that the tangent of a number adds to it

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
    unknown.deviation = std::min(unknown.deviation * slope / before, prior_breadth * own);
  }
  about->settings.substeps = estimate.augmented_model->options().substeps;
  about->settings.passes = 1;
  return about;
}

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
      : judged_(result.innovation.cols() - estimate.settled),
        whiten_(result),
        innovation_(judged(result.innovation)),
        slope_(slopes(estimate)) {
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

  void take(std::size_t n, const NumberDerivative& found) {
    auto& study = found_.study;
    const auto& derivative = found.means;
    const auto i = static_cast<Index>(n);
    if (!derivative || !derivative->innovation.allFinite() || !derivative->unknowns.allFinite()) {
      study.failed.push_back(study.numbers[n].name);
      return;
    }
    if (found.by_run) study.by_runs.push_back(study.numbers[n].name);
    const VectorXd moved = judged(derivative->innovation);
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
  /// White, of the samples that are judged, channels and then samples.
  [[nodiscard]] VectorXd judged(const MatrixXd& innovation) const {
    return whiten_(innovation).rightCols(judged_).reshaped();
  }

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

  Index judged_;  ///< samples
  WhiteInnovations whiten_;
  VectorXd innovation_;
  VectorXd slope_;
  Eigen::MatrixXf white_;                           ///< d nu / d c, white, one column a number
  std::vector<std::pair<Index, MatrixXd>> stated_;  ///< d nu / d c of the stated numbers
  FixedNumberResult found_;
};

/// Runs the filter with the likeliest changes themselves, as their linear prediction may reach too far: along a
/// direction that the record hardly tells, a change is large. Where numbers are stated the prediction counts.
void confirm(const RunsBeside& runs, EstimationOptions options, Index first, double log_likelihood,
             FixedNumberStudy& study) {
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
    study.confirmed[i] = runs.log_likelihood(static_cast<std::size_t>(i), change, options, first) - log_likelihood;
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
  const double cost_of_number = runs.carries_tangents() ? cost_of_tangent : cost_of_mean;
  if (!budget.take(pass * (1.0 + cost_of_mean + cost_of_number * static_cast<double>(count)))) return std::nullopt;

  const FilterRun& filter = runs.filter();
  EstimationOptions options_of_filter = filter_options(filter, problem->settings, estimate);
  EstimationResult result = kalfem::estimate(*filter.choice.augmented_model, filter.input, options_of_filter);
  if (result.failure || !runs.run_base(std::move(result.gains))) return std::nullopt;
  Collection collection(runs.numbers(), result, estimate);
  const auto groups = runs.groups();
  const auto at_once = static_cast<std::size_t>(filter_threads(problem->settings));
  for (std::size_t first = 0; first < groups.size(); first += at_once) {
    std::vector<std::vector<NumberDerivative>> derivatives(std::min(at_once, groups.size() - first));
    for_each_index(derivatives.size(), static_cast<int>(at_once),
                   [&](std::size_t g) { derivatives[g] = runs.derivatives(groups[first + g]); });
    for (std::size_t g = 0; g < derivatives.size(); ++g)
      for (std::size_t n = 0; n < derivatives[g].size(); ++n) collection.take(groups[first + g][n], derivatives[g][n]);
  }
  FixedNumberResult found = std::move(collection).finish();
  confirm(runs, options_of_filter, estimate.settled, log_likelihood_from(result, estimate.settled), found.study);
  return found;
} catch (const InvalidInput&) {
  return std::nullopt;  // at the estimates there is no structure
}

}  // namespace kalfem
