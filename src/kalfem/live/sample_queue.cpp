// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/sample_queue.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/base/units.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double off_the_grid = 0.1;  ///< of a sampling interval: further from a sample's time belongs to none

}  // namespace

SampleQueue::SampleQueue(FilterProblem problem, std::vector<OnlineInput> inputs, const LiveOptions& options)
    : steps_(std::move(problem), std::move(inputs), options.filter),
      options_(options),
      rate_(1.0 / steps_.loop().step()) {
  if (steps_.monitor()) steps_.monitor()->set_origin(options.start);
  if (!(options.horizon > 0.0) || !std::isfinite(options.horizon * rate_) || options.horizon * rate_ > 1e8)
    throw InvalidInput("horizon: " + shortest(options.horizon) + " s", "it must be > 0 and at most 1e8 samples", "");
  for (const auto& sensor : steps_.loop().sensors()) channels_.push_back(sensor.name);
  sensors_ = std::ssize(channels_);
  const auto& all = steps_.inputs();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!all[i].signal) {
      online_.push_back(static_cast<Index>(i));
      channels_.push_back(all[i].name);
    }
  horizon_ = std::max<Index>(1, std::llround(options.horizon * rate_));
  measured_.resize(sensors_);
  held_ = VectorXd::Zero(std::ssize(all));
  here_.setZero(std::ssize(channels_), horizon_ + 1);
  values_.setConstant(std::ssize(channels_), horizon_ + 1, not_a_number);
  arrived_.setZero(horizon_ + 1);
}

Index SampleQueue::find(const std::string& channel) const {
  const auto found = std::ranges::find(channels_, channel);
  if (found == channels_.end())
    throw InvalidInput("push: there is no channel '" + channel + "'" + did_you_mean(channel, channels_),
                       "channels are the sensors and the inputs without a signal", "");
  return found - channels_.begin();
}

/// The sample that belongs to a time.
Index SampleQueue::sample_at(double time) const {
  const double place = (time - options_.start) * rate_;
  const double nearest = std::round(place);
  if (!(std::abs(place - nearest) <= off_the_grid) || std::abs(nearest) > 1e15)
    throw InvalidInput("push: the time " + shortest(time) + " s lies between two samples",
                       "sample k is taken at start + k / " + shortest(rate_) + " Hz", "resample the channel");
  return static_cast<Index>(nearest);
}

void SampleQueue::require(Index channel, Index first, const Eigen::Ref<const VectorXd>& values) const {
  const auto& name = channels_[static_cast<std::size_t>(channel)];
  const double longest = options_.longest_gap.value_or(10.0 * options_.horizon);
  if (static_cast<double>(first - std::max<Index>(newest_, 0)) > longest * rate_)
    throw InvalidInput("push: the samples of '" + name + "' begin " +
                           shortest(static_cast<double>(first - std::max<Index>(newest_, 0)) / rate_) +
                           " s after the latest ones",
                       "the filter would go on without any sensor for so long",
                       "count the time from `start`, the time of the first sample");
  if (values.size() > horizon_)
    throw InvalidInput("push: " + std::to_string(values.size()) + " samples of '" + name +
                           "' are longer than the horizon of " + shortest(options_.horizon) + " s",
                       "the filter would go on without the other channels", "give shorter blocks or a longer horizon");
  if (channel >= sensors_ && !values.allFinite())
    throw InvalidInput("push: '" + name + "' has a value that is not finite", "the filter's model is driven by it",
                       "leave a missing sample out: the last value is held");
}

void SampleQueue::add(Index channel, Index sample, double value) {
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

void SampleQueue::take_complete() {
  const auto all = static_cast<int>(channels_.size());
  while (next_ <= newest_ && arrived_[next_ % (horizon_ + 1)] == all) take();
}

/// Moves the filter to the next sample, with what has come of it.
void SampleQueue::take() {
  const Index at = next_ % (horizon_ + 1);
  measured_ = values_.col(at).head(sensors_);
  for (std::size_t i = 0; i < online_.size(); ++i)
    if (const Index row = sensors_ + static_cast<Index>(i); here_(row, at) != 0) held_[online_[i]] = values_(row, at);
  if (!online_.empty())
    for (Index i = 0; i < held_.size(); ++i)
      if (const auto& signal = steps_.inputs()[static_cast<std::size_t>(i)].signal)
        held_[i] = signal->sample(static_cast<double>(next_) / rate_, 1.0 / rate_, 1)(0, 0);
  if (next_ == 0) {
    if (!online_.empty()) steps_.start(held_);
  } else if (!online_.empty()) {
    steps_.predict_values(held_);
  } else {
    steps_.predict();
  }
  steps_.update(measured_);
  here_.col(at).setZero();
  values_.col(at).setConstant(not_a_number);
  arrived_[at] = 0;
  ++next_;
}

std::optional<std::size_t> SampleQueue::find_covariate(const std::string& name) const {
  return steps_.monitor() ? steps_.monitor()->find(name) : std::nullopt;
}

void SampleQueue::push_covariate(std::size_t covariate, double time, double value) {
  steps_.monitor()->add(covariate, time - options_.start, value);
}

Index SampleQueue::push(const std::string& channel, double time, const Eigen::Ref<const VectorXd>& values) {
  if (const auto covariate = find_covariate(channel)) {
    for (Index i = 0; i < values.size(); ++i)
      push_covariate(*covariate, time + static_cast<double>(i) / rate_, values[i]);
    return 0;
  }
  const Index row = find(channel), first = sample_at(time), before = next_;
  require(row, first, values);
  for (Index i = 0; i < values.size(); ++i) add(row, first + i, values[i]);
  take_complete();
  return next_ - before;
}

Index SampleQueue::push(const std::string& channel, const Eigen::Ref<const VectorXd>& times,
                        const Eigen::Ref<const VectorXd>& values) {
  if (times.size() != values.size())
    throw InvalidInput("push: " + std::to_string(times.size()) + " times and " + std::to_string(values.size()) +
                           " values of '" + channel + "'",
                       "each value has its time", "");
  if (const auto covariate = find_covariate(channel)) {
    for (Index i = 0; i < values.size(); ++i) push_covariate(*covariate, times[i], values[i]);
    return 0;
  }
  const Index row = find(channel), before = next_;
  std::vector<Index> samples;
  for (const double time : times) samples.push_back(sample_at(time));
  if (!samples.empty()) require(row, samples.back(), values);
  if (!std::ranges::is_sorted(samples))
    throw InvalidInput("push: the times of '" + channel + "' are not ascending", "", "sort the block by its times");
  for (std::size_t i = 0; i < samples.size(); ++i) add(row, samples[i], values[static_cast<Index>(i)]);
  take_complete();
  return next_ - before;
}

Index SampleQueue::flush() {
  const Index before = next_;
  while (next_ <= newest_) take();
  steps_.finish();
  return next_ - before;
}

void SampleQueue::transfer(auto& self, auto& archive) {
  archive(self.values_);
  archive(self.here_);
  archive(self.arrived_);
  archive(self.held_);
  archive(self.next_);
  archive(self.newest_);
  archive(self.dropped_);
}

void SampleQueue::keep(ArchiveWriter& archive) const {
  steps_.keep(archive);
  transfer(*this, archive);
}

void SampleQueue::take_up(ArchiveReader& archive) {
  steps_.take_up(archive);
  const Index channels = values_.rows(), columns = values_.cols();
  transfer(*this, archive);
  if (values_.rows() != channels || values_.cols() != columns || here_.rows() != channels || here_.cols() != columns ||
      arrived_.size() != columns)
    throw DamagedArchive();
}

}  // namespace kalfem
