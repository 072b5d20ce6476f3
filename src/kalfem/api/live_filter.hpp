// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <memory>
#include <string>

#include "kalfem/api/online_filter.hpp"

namespace kalfem {

class SampleQueue;

/// A filter whose samples come channel by channel, in blocks, late or out of order:
///
///     LiveFilter live(structure, 1000.0, {.sensors = {...}, .unknowns = {...}}, {.horizon = 2.0});
///     live.push("road", 0.0, first_block);
///     live.push("a3", 0.0, first_block_of_a3);
///
/// Channels are the sensors and the inputs without a signal. Samples of all channels that belong to one instant have
/// the same time. The queue takes sample k once every channel has it; the filter stands OnlineOptions::input_delay
/// samples behind, as its inputs are a spline through later samples too. The queue stops waiting once some channel has
/// a sample that is later by more than the horizon: what is missing then counts as not measured, and an input holds its
/// last value. So the order in which samples come does not matter as long as none is later than the horizon. What comes
/// later is dropped.
class LiveFilter {
public:
  /// Throws InvalidInput as OnlineFilter does, and where the horizon is not positive.
  LiveFilter(const Structure& structure, double sample_rate, const EstimateOptions& options,
             const LiveOptions& live = {});
  LiveFilter(LiveFilter&&) noexcept;
  LiveFilter& operator=(LiveFilter&&) noexcept;
  ~LiveFilter();

  /// Samples of a channel from a time on, at the sampling rate; NaN is a missing value of a sensor. Returns how many
  /// samples the filter took. Throws InvalidInput for an unknown channel, a time between two samples, a block that is
  /// longer than the horizon, and an input that is not finite.
  Eigen::Index push(const std::string& channel, double time, const Eigen::Ref<const Eigen::VectorXd>& values);
  /// The same with a time for each value, ascending.
  Eigen::Index push(const std::string& channel, const Eigen::Ref<const Eigen::VectorXd>& times,
                    const Eigen::Ref<const Eigen::VectorXd>& values);
  /// Takes all samples that any channel has, as if the horizon were over, and moves the filter to the last one. Returns
  /// how many there were.
  Eigen::Index flush();

  /// The filter, `input_delay` behind the last sample that was taken; OnlineFilter::time() counts from the first one.
  [[nodiscard]] OnlineFilter& filter();
  [[nodiscard]] Eigen::Index samples() const;  ///< taken so far
  [[nodiscard]] Eigen::Index dropped() const;  ///< values that came behind the horizon, or twice

  /// The filter's state with the samples that wait, to a file and from it: see OnlineFilter::write_state().
  void write_state(const std::filesystem::path& file) const;
  void read_state(const std::filesystem::path& file);

private:
  std::shared_ptr<SampleQueue> queue_;
  OnlineFilter filter_;  ///< of the queue
};

}  // namespace kalfem
