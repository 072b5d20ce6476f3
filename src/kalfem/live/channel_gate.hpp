// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>

#include "kalfem/live/gate_options.hpp"
#include "kalfem/live/live_state.hpp"

namespace kalfem {

/// A value of a channel beside what the filter expects of it.
struct ExpectedValue {
  double measured = 0.0, predicted = 0.0;
  double variance = 0.0;    ///< of their difference
  double normalised = 0.0;  ///< the difference, given the other channels that were taken, in its deviations
};

/// What is known of one channel: its latest values, and whether it is out.
class ChannelGate {
public:
  /// `noise`: standard deviation of the channel's white noise.
  ChannelGate(const GateOptions& options, double noise);

  /// Why the channel is out; nothing where its values are taken.
  [[nodiscard]] const std::optional<FilterEventKind>& fault() const { return fault_; }
  /// Whether that shows in its values alone, whatever the filter expects: not `off`.
  [[nodiscard]] bool is_broken() const { return fault_ && *fault_ != FilterEventKind::off; }
  [[nodiscard]] bool is_missing() const { return missing_ >= options_.silence; }
  /// Whether its latest values are those of a channel that works, so that it may come back.
  [[nodiscard]] bool is_good() const;
  /// Mean square of the normalised innovations of the latest values.
  [[nodiscard]] double mean_square() const;

  [[nodiscard]] double last() const { return last_; }  ///< its latest value

  void miss();
  /// Takes the next value to its memory, with whether it was left out by its size. Returns the fault that it shows.
  std::optional<FilterEventKind> see(const ExpectedValue& value, bool left_out);
  void suspend(FilterEventKind fault) { fault_ = fault; }
  /// Takes it again, with an empty memory of what was left out.
  void readmit();

  /// All that changes, to an archive or from it.
  static void transfer(auto& self, auto& archive) {
    archive(self.memory_);
    archive(self.count_);
    archive(self.same_);
    archive(self.last_);
    archive(self.lowest_);
    archive(self.highest_);
    archive(self.lowest_prediction_);
    archive(self.highest_prediction_);
    archive(self.missing_);
    archive(self.fault_);
  }

private:
  [[nodiscard]] std::optional<FilterEventKind> same_value_fault(const ExpectedValue& value);
  [[nodiscard]] bool is_dead() const;

  GateOptions options_;
  double noise_;
  /// measured, predicted, variance, normalised, left out (1 or 0): rows of a ring of the latest values.
  Eigen::MatrixXd memory_;
  Eigen::Index count_ = 0;
  int same_ = 0;  ///< values in succession equal to the last one
  double last_, lowest_, highest_;
  double lowest_prediction_ = 0.0, highest_prediction_ = 0.0;  ///< while it has been that value
  int missing_ = 0;                                            ///< samples without a value since the last one
  std::optional<FilterEventKind> fault_;
};

}  // namespace kalfem
