// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/likelihood_unknowns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "kalfem/records/clock_lag.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Kind = LikelihoodUnknownKind;

constexpr double reach_of_clocks = 4.0;   ///< prior standard deviations
constexpr int tried_clocks = 41;          ///< over that reach
constexpr double step_of_clocks = 0.05;   ///< of the differences [samples]
constexpr double step_of_factors = 0.01;  ///< relative
constexpr double by_chance = 5.0;         ///< standard deviations
constexpr double told = 0.9;              ///< a deviation below this part of the prior's is told by the record

/// What is late of one channel, and samples at its ends that clocks within the bounds may need.
struct ChannelClock {
  ClockLag lag;
  Index head = 0, tail = 0;
};

double since_of(const LikelihoodUnknown& unknown, const Record& record) { return unknown.since.value_or(record.start); }

/// Seconds by which a channel is late at a time for each unit of a delay or drift.
double late_by_unit(const LikelihoodUnknown& unknown, const Record& record, double time) {
  return unknown.kind == Kind::sensor_delay ? 1.0 : std::abs(time - since_of(unknown, record));
}

/// Samples near a time that a delay or drift within its bounds may need.
Index reach_of(const LikelihoodUnknown& unknown, const Record& record, double time) {
  const double furthest = std::abs(unknown.initial) + reach_of_clocks * unknown.deviation;
  return static_cast<Index>(std::ceil(furthest * late_by_unit(unknown, record, time) * record.sample_rate)) + 1;
}

/// The channels whose clocks are unknown.
std::map<Index, ChannelClock> clocks_of(const std::vector<LikelihoodUnknown>& unknowns, const VectorXd& values,
                                        const Record& record) {
  std::map<Index, ChannelClock> clocks;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const auto& sensor : unknowns[i].sensors) {
      const Index row = record.find(sensor);
      if (row < 0 || !unknowns[i].is_of_clock()) continue;
      auto& [lag, head, tail] = clocks[row];
      lag.since = since_of(unknowns[i], record);
      (unknowns[i].kind == Kind::sensor_delay ? lag.delay : lag.drift) += values[static_cast<Index>(i)];
      head += reach_of(unknowns[i], record, record.start);
      tail += reach_of(unknowns[i], record, record.end());
    }
  return clocks;
}

VectorXd with_true_clock(const Record& record, Index row, const ChannelClock& clock) {
  VectorXd moved = without_lag(record, row, clock.lag);
  moved.head(std::min(clock.head, moved.size())).setConstant(std::numeric_limits<double>::quiet_NaN());
  moved.tail(std::min(clock.tail, moved.size())).setConstant(std::numeric_limits<double>::quiet_NaN());
  return moved;
}

/// The coordinate in which an unknown is searched: samples by which a clock is late, at the record's end where it
/// drifts; the logarithm of everything else.
struct Coordinate {
  const LikelihoodUnknown& unknown;
  Index place;     ///< among all
  double samples;  ///< late by, for each unit of a delay or drift
  double sign;     ///< of a gain

  [[nodiscard]] bool is_of_clock() const { return unknown.is_of_clock(); }
  [[nodiscard]] double of(double value) const { return is_of_clock() ? value * samples : std::log(std::abs(value)); }
  [[nodiscard]] double value(double x) const { return is_of_clock() ? x / samples : sign * std::exp(x); }
  /// |d value / d x|
  [[nodiscard]] double slope(double x) const { return is_of_clock() ? 1.0 / samples : std::exp(x); }
  [[nodiscard]] double prior_deviation() const { return unknown.deviation / slope(of(unknown.initial)); }
  [[nodiscard]] LikelihoodParameter parameter(double start) const {
    const double mean = of(unknown.initial), deviation = prior_deviation();
    LikelihoodParameter own{.start = of(start), .prior_mean = mean, .prior_deviation = deviation};
    own.step = is_of_clock() ? step_of_clocks : step_of_factors;
    if (!is_of_clock()) return own;
    own.lower = mean - reach_of_clocks * deviation;
    own.upper = mean + reach_of_clocks * deviation;
    return own;
  }
};

/// Searches the likelihood unknowns of a problem.
class LikelihoodUnknownSearch {
public:
  LikelihoodUnknownSearch(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                          const EstimationOptions& options,
                          std::function<EstimationResult(const CorrectedProblem&)> run)
      : problem_(problem),
        setup_(setup),
        record_(record),
        options_{.unscented = options.unscented, .state_deviations = false, .adaptive_noise = options.adaptive_noise},
        run_(std::move(run)),
        threads_(filter_threads(problem->settings)),
        unknowns_(problem->settings.likelihood_unknowns),
        values_(static_cast<Index>(unknowns_.size())) {
    for (Index i = 0; i < values_.size(); ++i) values_[i] = unknown(i).initial;
  }

  std::optional<LikelihoodEstimate> run() {
    const auto at_first = corrected(problem_, setup_, record_, values_);
    setup_.starts_at_rest = !make_filter_run(at_first.problem, at_first.setup, at_first.record).start.moving;
    for (Index i = 0; i < values_.size(); ++i)
      if (try_starts(i)) searched_.push_back(coordinate(i));
    std::vector<LikelihoodParameter> parameters;
    for (const auto& each : searched_) parameters.push_back(each.parameter(values_[each.place]));
    const auto found = maximise_likelihood([&](const VectorXd& x) { return log_densities(values_at(x)); }, parameters,
                                           {.threads = threads_});
    if (!found) return std::nullopt;
    values_ = values_at(found->estimate);
    return estimate_from(*found, parameters);
  }

private:
  [[nodiscard]] const LikelihoodUnknown& unknown(Index i) const { return unknowns_[static_cast<std::size_t>(i)]; }

  [[nodiscard]] Coordinate coordinate(Index i) const {
    const double samples = late_by_unit(unknown(i), record_, record_.end()) * record_.sample_rate;
    return {unknown(i), i, samples, values_[i] < 0.0 ? -1.0 : 1.0};
  }

  /// All values, those that are searched at x.
  [[nodiscard]] VectorXd values_at(const VectorXd& x) const {
    VectorXd values = values_;
    for (Index i = 0; i < x.size(); ++i) {
      const auto& own = searched_[static_cast<std::size_t>(i)];
      values[own.place] = own.value(x[i]);
    }
    return values;
  }

  [[nodiscard]] LikelihoodEstimate estimate_from(const MaximumLikelihood& found,
                                                 const std::vector<LikelihoodParameter>& parameters) const {
    LikelihoodEstimate estimate{.unknowns = counted_from_here(),
                                .values = values_,
                                .visible = std::vector<bool>(unknowns_.size(), false),
                                .converged = found.converged,
                                .runs = found.evaluations,
                                .corrected = corrected(problem_, setup_, record_, values_)};
    estimate.deviation.resize(values_.size());
    for (Index i = 0; i < values_.size(); ++i) estimate.deviation[i] = unknown(i).deviation;
    estimate.robust_deviation = estimate.deviation;
    for (Index i = 0; i < found.estimate.size(); ++i) {
      const auto& own = searched_[static_cast<std::size_t>(i)];
      const double slope = own.slope(found.estimate[i]), deviation = std::sqrt(found.covariance(i, i));
      estimate.deviation[own.place] = slope * deviation;
      estimate.robust_deviation[own.place] = slope * std::sqrt(found.robust.covariance(i, i));
      estimate.visible[static_cast<std::size_t>(own.place)] = deviation < told * own.prior_deviation();
    }
    estimate.tried = tried_;
    const MatrixXd slopes = slopes_of_unknowns(found.estimate, parameters);
    estimate.added_covariance = slopes * found.covariance * slopes.transpose();
    return estimate;
  }

  /// Drifts hold for other records too, so they say from where they count.
  [[nodiscard]] std::vector<LikelihoodUnknown> counted_from_here() const {
    auto unknowns = unknowns_;
    for (auto& unknown : unknowns)
      if (unknown.is_of_clock()) unknown.since = since_of(unknown, record_);
    return unknowns;
  }

  [[nodiscard]] std::optional<EstimationResult> run_at(const VectorXd& values, VectorXd* log_jacobian) const {
    const auto here = corrected(problem_, setup_, record_, values);
    EstimationResult result = run_ ? run_(here) : run_filter(here.problem, here.setup, here.record, options_).result;
    if (result.failure) return std::nullopt;
    if (log_jacobian) *log_jacobian = here.log_jacobian;
    return result;
  }

  [[nodiscard]] std::optional<VectorXd> log_densities(const VectorXd& values) const {
    VectorXd log_jacobian;
    const auto result = run_at(values, &log_jacobian);
    if (!result) return std::nullopt;
    return VectorXd(result->log_density + log_jacobian);
  }

  /// Moves value i to the most likely of its possible starts: either sign of a gain, clocks over their reach. Whether
  /// it is worth a search: not a clock over whose reach the likelihood changes by no more than what the samples that
  /// move over the ends of the record make of it by chance, with the standard deviation sqrt(samples).
  bool try_starts(Index i) {
    const bool is_of_clock = unknown(i).is_of_clock();
    std::vector<double> starts{values_[i]};
    if (unknown(i).kind == Kind::sensor_gain) starts.push_back(-values_[i]);
    for (int k = 0; k < tried_clocks && is_of_clock; ++k)
      starts.push_back(unknown(i).initial +
                       reach_of_clocks * unknown(i).deviation * (2.0 * k / (tried_clocks - 1.0) - 1.0));
    if (starts.size() < 2) return true;
    const double infinity = std::numeric_limits<double>::infinity(), first = values_[i];
    double best = -infinity, worst = infinity;
    std::map<double, double> tried;
    for (const double start : starts) {
      VectorXd values = values_;
      values[i] = start;
      const auto densities = log_densities(values);
      if (!densities) continue;
      tried.emplace(start, densities->sum());
      worst = std::min(worst, densities->sum());
      if (!(densities->sum() > best)) continue;
      best = densities->sum();
      values_[i] = start;
    }
    auto& kept = tried_.emplace_back(TriedValues{i});
    for (const auto& [value, log_likelihood] : tried) {
      kept.values.push_back(value);
      kept.log_likelihood.push_back(log_likelihood);
    }
    const auto moved = static_cast<double>(reach_of(unknown(i), record_, record_.start) +
                                           reach_of(unknown(i), record_, record_.end()));
    if (!is_of_clock || best - worst > by_chance * std::sqrt(moved)) return true;
    values_[i] = first;
    return false;
  }

  /// d theta / d x of the filter's unknowns, in its state, by central differences.
  [[nodiscard]] MatrixXd slopes_of_unknowns(const VectorXd& x,
                                            const std::vector<LikelihoodParameter>& parameters) const {
    const auto count = static_cast<Index>(setup_.options.unknowns.size());
    MatrixXd slopes = MatrixXd::Zero(count, x.size());
    for (Index i = 0; i < x.size() && count > 0; ++i) {
      const double step = parameters[static_cast<std::size_t>(i)].step;
      std::optional<VectorXd> ends[2];
      for (const int side : {0, 1}) {
        VectorXd moved = x;
        moved[i] += side == 0 ? step : -step;
        if (const auto result = run_at(values_at(moved), nullptr))
          ends[side] = result->state.mean.col(result->state.mean.cols() - 1)
                           .segment(result->state.mean.rows() - count_behind(*result), count);
      }
      if (ends[0] && ends[1]) slopes.col(i) = (*ends[0] - *ends[1]) / (2.0 * step);
    }
    return slopes;
  }

  /// Rows of the augmented state from the first unknown on.
  [[nodiscard]] Index count_behind(const EstimationResult& result) const {
    const auto count = static_cast<Index>(setup_.options.unknowns.size());
    if (!setup_.options.keep_initial_state) return count;
    return (result.state.mean.rows() - count) / 2 + count;
  }

  const EstimationProblemPtr& problem_;
  AugmentedModelSetup setup_;
  const Record& record_;
  EstimationOptions options_;
  std::function<EstimationResult(const CorrectedProblem&)> run_;
  int threads_;
  const std::vector<LikelihoodUnknown>& unknowns_;
  VectorXd values_;
  std::vector<Coordinate> searched_;
  std::vector<TriedValues> tried_;
};

}  // namespace

LikelihoodInterval LikelihoodEstimate::interval(Index i) const {
  constexpr double two_sided_95 = 1.959963984540054;
  const auto& unknown = unknowns[static_cast<std::size_t>(i)];
  const double half = two_sided_95 * std::fmax(deviation[i], robust_deviation[i]);
  const bool robust = robust_deviation[i] > deviation[i];
  if (unknown.is_of_clock()) return {values[i] - half, values[i] + half, robust};
  const double factor = std::exp(half / std::abs(values[i]));
  const auto [lower, upper] = std::minmax({values[i] / factor, values[i] * factor});
  return {lower, upper, robust};
}

Record corrected_record(const std::vector<LikelihoodUnknown>& unknowns, const VectorXd& values, Record record) {
  const auto for_each = [&](Kind kind, const auto& correct) {
    for (std::size_t i = 0; i < unknowns.size(); ++i)
      for (const auto& sensor : unknowns[i].sensors)
        if (const Index row = record.find(sensor); row >= 0 && unknowns[i].kind == kind)
          correct(values[static_cast<Index>(i)], row, record.channels[static_cast<std::size_t>(row)]);
  };
  // The noise is that of the channel as recorded, so it comes before the gain.
  for_each(Kind::sensor_noise, [&](double value, Index /*row*/, Channel& channel) { channel.noise = value; });
  for_each(Kind::sensor_gain, [&](double value, Index row, Channel& channel) {
    record.values.row(row) /= value;
    channel.noise /= std::abs(value);
  });
  for (const auto& [row, clock] : clocks_of(unknowns, values, record))
    record.values.row(row) = with_true_clock(record, row, clock).transpose();
  return record;
}

Record with_clocks(const std::vector<LikelihoodUnknown>& unknowns, const VectorXd& values, Record record) {
  for (const auto& [row, clock] : clocks_of(unknowns, values, record))
    record.values.row(row) = with_lag(record, row, clock.lag).transpose();
  return record;
}

CorrectedProblem corrected(const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
                           const VectorXd& values) {
  const auto& unknowns = problem->settings.likelihood_unknowns;
  auto own = std::make_shared<EstimationProblem>(*problem);
  own->settings.likelihood_unknowns.clear();
  CorrectedProblem result{.setup = setup, .record = corrected_record(unknowns, values, record)};
  result.log_jacobian = VectorXd::Zero(record.samples());
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const double value = values[static_cast<Index>(i)];
    if (unknowns[i].kind == Kind::process_noise) {
      own->settings.process_noise.acceleration = value;
      result.setup.options.process_noise.acceleration = value * setup.model->coordinate_scale();
    }
    if (unknowns[i].kind != Kind::sensor_gain) continue;
    for (const auto& sensor : unknowns[i].sensors) {
      const Index row = record.find(sensor);
      const bool is_measured = std::ranges::find(setup.sensors, sensor, &Sensor::name) != setup.sensors.end();
      if (row < 0 || !is_measured) continue;
      const auto present = result.record.values.row(row).head(record.samples_used()).transpose().array().isFinite();
      result.log_jacobian.head(record.samples_used()).array() -= present.cast<double>() * std::log(std::abs(value));
    }
  }
  result.problem = std::move(own);
  return result;
}

std::optional<LikelihoodEstimate> estimate_likelihood_unknowns(
    const EstimationProblemPtr& problem, const AugmentedModelSetup& setup, const Record& record,
    const EstimationOptions& options, std::function<EstimationResult(const CorrectedProblem&)> run) {
  return LikelihoodUnknownSearch(problem, setup, record, options, std::move(run)).run();
}

}  // namespace kalfem
