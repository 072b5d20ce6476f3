// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/estimation/filter.hpp"
#include "kalfem/live/channel_gate.hpp"
#include "kalfem/live/event_log.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// A sensor as the gate knows it.
struct GatedSensor {
  std::string name, unit;
  double noise = 0.0;
};

/// e_i = (nu_i - S_iA S_AA^-1 nu_A) / sqrt(S_ii - S_iA S_AA^-1 S_Ai) of every channel of an innovation, given those A
/// that were taken before it. Channels are taken in the order of |nu_i| / sqrt(S_ii), so that one that is wrong is
/// judged by those that are right; of `trusted` ones those whose |e_i| is within the limit. The others are judged given
/// all that were taken.
struct GatedInnovation {
  Eigen::VectorXd normalised;  ///< e, one a channel of the innovation
  std::vector<bool> taken;
};
GatedInnovation gate(const Innovation& innovation, const std::vector<bool>& trusted, double limit);

/// Decides, sample by sample and before the update, which sensors a filter learns from. A single value that is too far
/// off is left out. A channel that is stuck, saturated, dead or often too far off is out until its values are again
/// those that the filter expects. Where most of the working channels are off for long, the filter itself is at fault:
/// blames_filter().
class SensorGate {
public:
  SensorGate(const GateOptions& options, std::vector<GatedSensor> sensors);

  /// The channels to leave out at a sample. `values`: all of it, not a number where missing; `innovation`: of those
  /// that are there, before anything is learned from them.
  std::vector<Eigen::Index> refused(double time, const Eigen::VectorXd& values, const Innovation& innovation);
  /// A sample at which nothing was measured.
  void miss(double time);

  [[nodiscard]] bool blames_filter() const { return contradicted_ >= options_.patience; }
  /// The filter has been widened, or has begun anew: channels that were off are taken again, and it warms up.
  void filter_was_changed(double time, FilterEventKind how, const std::string& text);

  [[nodiscard]] bool warms_up() const { return warm_ < options_.warm_up; }
  [[nodiscard]] bool is_silent() const;
  [[nodiscard]] bool trusts(Eigen::Index channel) const {
    return !channels_[static_cast<std::size_t>(channel)].fault();
  }
  [[nodiscard]] bool trusts_any() const;
  [[nodiscard]] bool trusts_all() const;
  /// Mean square of the normalised innovations of the channels that are off.
  [[nodiscard]] double contradiction() const;
  /// One for each channel that is out.
  [[nodiscard]] std::vector<Reason> reasons() const;
  /// Counts up whenever a channel goes out or comes back.
  [[nodiscard]] long changes() const { return changes_; }
  [[nodiscard]] const EventLog& log() const { return log_; }

  /// All that changes, to an archive or from it.
  static void transfer(auto& self, auto& archive) {
    for (auto& channel : self.channels_) ChannelGate::transfer(channel, archive);
    archive(self.since_);
    EventLog::transfer(self.log_, archive);
    archive(self.warm_);
    archive(self.contradicted_);
    archive(self.changes_);
  }

private:
  void leave_out_once(double time, Eigen::Index channel, const ExpectedValue& value);
  void suspend(double time, Eigen::Index channel, FilterEventKind fault);
  void bring_back(double time, Eigen::Index channel);
  void count_contradictions(const Innovation& innovation);
  [[nodiscard]] const GatedSensor& sensor(Eigen::Index channel) const {
    return sensors_[static_cast<std::size_t>(channel)];
  }

  GateOptions options_;
  std::vector<GatedSensor> sensors_;
  std::vector<ChannelGate> channels_;
  Eigen::VectorXd since_;  ///< time of the first sample that is out, one a channel [s]
  EventLog log_;
  int warm_ = 0;          ///< samples since the start, or since the filter was changed
  int contradicted_ = 0;  ///< samples for which most working channels have been off
  long changes_ = 0;
};

}  // namespace kalfem
