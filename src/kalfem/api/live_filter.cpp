// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/live_filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/api/structure_description.hpp"
#include "kalfem/base/units.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double off_the_grid = 0.1;  ///< of a sampling interval: further from a sample's time belongs to none

std::vector<std::string> online_inputs(const StructureDescription& description) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < description.signals.size(); ++i)
    if (!description.signals[i]) names.push_back(description.parts.inputs[i].name);
  return names;
}

void require_all_or_none(const StructureDescription& description, std::size_t online) {
  if (online != 0 && online != description.signals.size())
    throw InvalidInput("some inputs of the structure have a signal and some have none",
                       "a LiveFilter is told all of them, or none", "give no input a signal");
}

}  // namespace

/// The samples that wait, one column each in a ring, and the filter that takes them.
class LiveFilter::Queue {
public:
  Queue(const Structure& structure, double sample_rate, const EstimateOptions& options, const LiveOptions& live)
      : filter_(structure, sample_rate, options, live.filter), live_(live), rate_(sample_rate) {
    if (!(live.horizon > 0.0) || !std::isfinite(live.horizon * sample_rate) || live.horizon * sample_rate > 1e8)
      throw InvalidInput("horizon: " + shortest(live.horizon) + " s", "it must be > 0 and at most 1e8 samples", "");
    for (const auto& sensor : options.sensors) channels_.push_back(sensor.name);
    sensors_ = std::ssize(channels_);
    const auto inputs = online_inputs(structure.description());
    require_all_or_none(structure.description(), inputs.size());
    channels_.insert(channels_.end(), inputs.begin(), inputs.end());
    horizon_ = std::max<Index>(1, std::llround(live.horizon * sample_rate));
    measured_.resize(sensors_);
    held_ = VectorXd::Zero(std::ssize(inputs));
    here_.setZero(std::ssize(channels_), horizon_ + 1);
    values_.setConstant(std::ssize(channels_), horizon_ + 1, not_a_number);
    arrived_.setZero(horizon_ + 1);
  }

  /// Where a channel stands.
  [[nodiscard]] Index find(const std::string& channel) const {
    const auto found = std::ranges::find(channels_, channel);
    if (found == channels_.end())
      throw InvalidInput("push: there is no channel '" + channel + "'" + did_you_mean(channel, channels_),
                         "channels are the sensors and the inputs without a signal", "");
    return found - channels_.begin();
  }

  /// The sample that belongs to a time.
  [[nodiscard]] Index sample_at(double time) const {
    const double place = (time - live_.start) * rate_;
    const double nearest = std::round(place);
    if (!(std::abs(place - nearest) <= off_the_grid) || std::abs(nearest) > 1e15)
      throw InvalidInput("push: the time " + shortest(time) + " s lies between two samples",
                         "sample k is taken at start + k / " + shortest(rate_) + " Hz", "resample the channel");
    return static_cast<Index>(nearest);
  }

  void require(Index channel, Index first, const Eigen::Ref<const VectorXd>& values) const {
    if (first - std::max<Index>(newest_, 0) > 10 * horizon_)
      throw InvalidInput("push: the samples of '" + channels_[static_cast<std::size_t>(channel)] + "' begin " +
                             shortest(static_cast<double>(first - std::max<Index>(newest_, 0)) / rate_) +
                             " s after the latest ones",
                         "the filter would go on without any sensor for so long",
                         "count the time from `start`, the time of the first sample");
    if (values.size() > horizon_)
      throw InvalidInput(
          "push: " + std::to_string(values.size()) + " samples of '" + channels_[static_cast<std::size_t>(channel)] +
              "' are longer than the horizon of " + shortest(live_.horizon) + " s",
          "the filter would go on without the other channels", "give shorter blocks or a longer horizon");
    if (channel >= sensors_ && !values.allFinite())
      throw InvalidInput("push: '" + channels_[static_cast<std::size_t>(channel)] + "' has a value that is not finite",
                         "the filter's model is driven by it", "leave a missing sample out: the last value is held");
  }

  void add(Index channel, Index sample, double value) {
    if (sample < next_) {
      ++dropped_;
      return;
    }
    while (sample - next_ > horizon_) take();
    const Index at = sample % (horizon_ + 1);
    if (here_(channel, at) != 0) {
      ++dropped_;
      return;
    }
    newest_ = std::max(newest_, sample);
    here_(channel, at) = 1;
    values_(channel, at) = value;
    ++arrived_[at];
  }

  void take_complete() {
    const auto all = static_cast<int>(channels_.size());
    while (next_ <= newest_ && arrived_[next_ % (horizon_ + 1)] == all) take();
  }

  void take_all() {
    while (next_ <= newest_) take();
    filter_.finish();
  }

  [[nodiscard]] OnlineFilter& filter() { return filter_; }
  [[nodiscard]] Index samples() const { return next_; }
  [[nodiscard]] Index dropped() const { return dropped_; }

private:
  /// Moves the filter to the next sample, with what has come of it.
  void take() {
    const Index at = next_ % (horizon_ + 1);
    measured_ = values_.col(at).head(sensors_);
    for (Index i = 0; i < held_.size(); ++i)
      if (here_(sensors_ + i, at) != 0) held_[i] = values_(sensors_ + i, at);
    if (next_ == 0) {
      if (held_.size() > 0) filter_.start(held_);
    } else if (held_.size() > 0) {
      filter_.predict_values(held_);
    } else {
      filter_.predict();
    }
    filter_.update(measured_);
    here_.col(at).setZero();
    values_.col(at).setConstant(not_a_number);
    arrived_[at] = 0;
    ++next_;
  }

  OnlineFilter filter_;
  LiveOptions live_;
  double rate_;  ///< [Hz]
  std::vector<std::string> channels_;
  Index sensors_ = 0;                                         ///< first so many channels
  Index horizon_ = 0;                                         ///< in samples; the ring holds one more
  Eigen::MatrixXd values_;                                    ///< channels x samples
  Eigen::Matrix<char, Eigen::Dynamic, Eigen::Dynamic> here_;  ///< whether a value has come
  Eigen::VectorXi arrived_;                                   ///< channels that have come, per sample
  VectorXd measured_, held_;
  Index next_ = 0, newest_ = -1;  ///< sample to be taken next, and the latest one that has come
  Index dropped_ = 0;
};

LiveFilter::LiveFilter(const Structure& structure, double sample_rate, const EstimateOptions& options,
                       const LiveOptions& live)
    : queue_(std::make_unique<Queue>(structure, sample_rate, options, live)) {}
LiveFilter::LiveFilter(LiveFilter&&) noexcept = default;
LiveFilter& LiveFilter::operator=(LiveFilter&&) noexcept = default;
LiveFilter::~LiveFilter() = default;

Index LiveFilter::push(const std::string& channel, double time, const Eigen::Ref<const VectorXd>& values) {
  const Index row = queue_->find(channel), first = queue_->sample_at(time), before = queue_->samples();
  queue_->require(row, first, values);
  for (Index i = 0; i < values.size(); ++i) queue_->add(row, first + i, values[i]);
  queue_->take_complete();
  return queue_->samples() - before;
}

Index LiveFilter::push(const std::string& channel, const Eigen::Ref<const VectorXd>& times,
                       const Eigen::Ref<const VectorXd>& values) {
  if (times.size() != values.size())
    throw InvalidInput("push: " + std::to_string(times.size()) + " times and " + std::to_string(values.size()) +
                           " values of '" + channel + "'",
                       "each value has its time", "");
  const Index row = queue_->find(channel), before = queue_->samples();
  std::vector<Index> samples;
  for (const double time : times) samples.push_back(queue_->sample_at(time));
  if (!samples.empty()) queue_->require(row, samples.back(), values);
  if (!std::ranges::is_sorted(samples))
    throw InvalidInput("push: the times of '" + channel + "' are not ascending", "", "sort the block by its times");
  for (std::size_t i = 0; i < samples.size(); ++i) queue_->add(row, samples[i], values[static_cast<Index>(i)]);
  queue_->take_complete();
  return queue_->samples() - before;
}

Index LiveFilter::flush() {
  const Index before = queue_->samples();
  queue_->take_all();
  return queue_->samples() - before;
}

OnlineFilter& LiveFilter::filter() { return queue_->filter(); }
Index LiveFilter::samples() const { return queue_->samples(); }
Index LiveFilter::dropped() const { return queue_->dropped(); }

}  // namespace kalfem
