// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/api/estimate.hpp"
#include "kalfem/estimation/consistency.hpp"
#include "kalfem/live/live_state.hpp"
#include "kalfem/live/online_options.hpp"

namespace kalfem {

class OnlineSteps;

/// A filter that is moved from sample to sample by its caller, as a live system needs it:
///
///     OnlineFilter filter(structure, 1000.0, {.sensors = {...}, .unknowns = {...}});
///     filter.update(first_sample);
///     while (filter.running() && next(inputs, y)) {
///       filter.predict(inputs);
///       filter.update(y);
///       if (!filter.usable()) warn(filter.verdict());
///     }
///
/// With OnlineOptions::gates it can be left alone: a sensor that dies, sticks or jumps is left out before it does harm,
/// and taken again once it gives what the filter expects; events() tells it. write_state() and read_state() carry it
/// over a restart.
///
/// The covariance moves in the modal coordinates of the linear part, where a step costs least. Where rounding makes it
/// indefinite there (close poles), the filter goes on in physical coordinates from the estimate before the step, with
/// the negative directions of its covariance taken off. A step costs more from then on.
///
/// Moved by predict() without arguments it gives the estimates of estimate() over the same record, and so it does moved
/// by predict_values() with a delay. One thread uses it at a time.
class OnlineFilter {
public:
  /// `sample_rate` [Hz]: of predict(). Inputs are those of the structure's signals at first; start() says others.
  /// Throws InvalidInput as estimate() does.
  OnlineFilter(const Structure& structure, double sample_rate, const EstimateOptions& options,
               const OnlineOptions& online = {});
  OnlineFilter(OnlineFilter&&) noexcept;
  OnlineFilter& operator=(OnlineFilter&&) noexcept;
  ~OnlineFilter();

  /// The inputs at the first sample, before its update(); zero for those without a signal if it is not called.
  void start(const std::vector<InputSample>& inputs);
  /// The same from values alone.
  void start(const Eigen::VectorXd& values);

  /// Predicts to the next sample, from the inputs there. Between the samples a moved ground is the polynomial of the
  /// fifth degree through value, rate and acceleration at both, other inputs are straight. Returns false if the
  /// filter has stopped, see failure(). Throws InvalidInput if the number of inputs is not that of the structure, if
  /// one is not finite, and after predict_values() without finish().
  bool predict(const std::vector<InputSample>& inputs);
  /// The same with the signals of the structure. Throws InvalidInput if one of its inputs has none.
  bool predict();
  /// The next sample's inputs from values alone, one an input. Rates and accelerations are those of a spline that needs
  /// OnlineOptions::input_delay later samples: the filter stands so many samples behind, and each update() waits until
  /// the filter is there. What the filter says of itself (time(), parameters(), nis(), ...) belongs to where it stands.
  bool predict_values(const Eigen::VectorXd& values);
  /// Conditions the estimate on the sample of the last prediction, with one value per sensor; NaN is a missing value.
  /// Returns false if the filter has stopped. Throws InvalidInput if there is not one value for each sensor.
  bool update(const Eigen::VectorXd& measured);
  /// Takes the samples that wait for later ones, with the spline of those that are there. Returns false if the filter
  /// has stopped.
  bool finish();

  /// Whether the covariance had to leave the modal coordinates.
  [[nodiscard]] bool in_physical_coordinates() const;
  [[nodiscard]] double time() const;  ///< of the sample at which the filter stands, the first one at 0 [s]
  /// Whether the filter goes on: it has not stopped.
  [[nodiscard]] bool running() const { return !failure(); }
  /// Whether the numbers can be relied on: the filter goes on, and its verdict is not unusable. Costs nothing.
  [[nodiscard]] bool usable() const { return running() && verdict().state() != VerdictState::unusable; }
  [[nodiscard]] const std::optional<FilterStop>& failure() const;
  /// Whether the innovations of the window are as large as the filter expects and white, by the rules of
  /// EstimateResult::verdict. Formed anew after each twentieth part of the window; consistent before the first one.
  /// With gates a sensor that is left out is a reason, too.
  [[nodiscard]] const Verdict& verdict() const;
  [[nodiscard]] FilterCondition condition() const;
  /// Condition, NIS and reasons over the latest minute, hour or day of the stream, as shares of the time.
  [[nodiscard]] SpanHealth health(HealthSpan span) const;
  /// What the gates have noticed, the latest GateOptions::most_events, the oldest first.
  [[nodiscard]] std::vector<FilterEvent> events() const;
  /// With OnlineOptions::changes: a value of a covariate at a time from the first sample on [s], before the filter has
  /// passed the window in which it lies. Throws InvalidInput where there is no covariate of that name.
  void covariate(const std::string& name, double time, double value);
  /// The alarms on changes of unknowns, the latest 1000, the oldest first; those that stand, with what is known of them
  /// now; and the unknowns by day. Empty without OnlineOptions::changes.
  [[nodiscard]] std::vector<Alarm> alarms() const;
  [[nodiscard]] std::vector<ParameterChange> changes() const;
  [[nodiscard]] std::vector<ParameterDay> trend() const;

  /// Of the window: mean NIS, the expected one and how many samples lie in the 95 % band.
  [[nodiscard]] ConsistencySummary consistency() const;

  /// The unknowns now, without histories.
  [[nodiscard]] std::vector<ParameterEstimate> parameters() const;
  /// Look-up by the name of an unknown; throws InvalidInput if there is none.
  [[nodiscard]] PresentEstimate parameter(const std::string& name) const;
  /// "body.2.displacement", "body.2.velocity", or an output that was asked for. Throws InvalidInput where there is
  /// none.
  [[nodiscard]] PresentEstimate state(const std::string& name);
  /// With OnlineOptions::lag = N: parameters, motions and outputs of sample k - N given all samples up to k, where the
  /// filter stands, with their standard deviations. It is what the fixed-interval smoother gives of that sample over
  /// the record that ends with sample k (docs/theory/smoother.md). Until N samples have come, and until N have passed
  /// after the filter has widened its deviations or begun anew, it is that of the first one. Costs N backward steps.
  /// Nothing without a lag, and before the first sample.
  [[nodiscard]] std::optional<SmoothedEstimate> smoothed();
  /// Of the last update: measured minus predicted, and its normalised square. Not a number before the first one.
  [[nodiscard]] const Eigen::VectorXd& innovation() const;
  [[nodiscard]] double nis() const;

  /// Writes all that later steps depend on to a file, which is replaced at once (docs/live.md has its format), and
  /// reads it into a filter of the same structure and options: that one goes on with the same bits. read_state() throws
  /// InvalidInput where the file is damaged, or is that of another structure, other options or another version.
  void write_state(const std::filesystem::path& file) const;
  void read_state(const std::filesystem::path& file);

private:
  friend class LiveFilter;
  explicit OnlineFilter(std::shared_ptr<OnlineSteps> steps) : steps_(std::move(steps)) {}

  std::shared_ptr<OnlineSteps> steps_;
};

}  // namespace kalfem
