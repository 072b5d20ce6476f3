// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/live/sample_queue.hpp"
#include "kalfem/study/live_plan.hpp"
#include "kalfem/watch/stream_clock.hpp"
#include "kalfem/watch/stream_line.hpp"

namespace kalfem {

/// What a line of a Watcher is.
enum class MessageKind {
  estimates,  ///< where the filter stands
  alarm,      ///< a parameter has changed
  trend       ///< a day is over
};

/// A live case: lines of a stream in, lines of estimates out. What comes out depends on what came in alone, neither on
/// the clock nor on the length of blocks, so that the same lines give the same bits.
class Watcher final : public Resumable {
public:
  using Say = std::function<void(MessageKind kind, const std::string& line)>;

  /// `say`: takes a line, a JSON object without a line break; `complain`: takes a message.
  Watcher(LivePlan plan, Say say, std::function<void(const std::string&)> complain);

  /// Takes a line. One that cannot be used is told and counted, and that is all.
  void take(std::string_view line);
  /// A line of estimates where the filter stands.
  void tell();
  /// The lines of the alarms, the latest ones, and of the days of the trend that have been.
  void recall(const Say& say) const;

  [[nodiscard]] std::int64_t lines() const { return lines_; }  ///< taken
  /// Bytes of the log that the state has seen.
  [[nodiscard]] std::int64_t logged() const { return logged_; }
  void logged(std::int64_t bytes) { logged_ = bytes; }
  /// Of the stream, where the filter stands [s].
  [[nodiscard]] double time() const { return origin_.value_or(0.0) + queue_.steps().loop().time(); }
  /// Of the first sample [s]; 0 before it has come.
  [[nodiscard]] double origin() const { return origin_.value_or(0.0); }
  /// Of changes; null where the case asks for no alarms.
  [[nodiscard]] const ChangeMonitor* monitor() const { return queue_.steps().monitor(); }
  [[nodiscard]] OnlineLoop& loop() { return queue_.steps().loop(); }  ///< the filter
  [[nodiscard]] std::string fingerprint() const { return queue_.fingerprint(); }

  void keep(ArchiveWriter& archive) const override;
  void take_up(ArchiveReader& archive) override;

private:
  /// Of a covariate, that came before the first sample.
  struct EarlyValue {
    std::size_t covariate = 0;
    double time = 0.0, value = 0.0;
  };

  /// Something about the clock of a channel that the next line of estimates tells among the events.
  struct ClockEvent {
    double time = 0.0;  ///< of the filter [s]
    std::string channel, text;
  };

  void take_block(const StreamBlock& block, const LiveChannel& channel);
  [[nodiscard]] std::optional<double> placed(double time, std::ptrdiff_t count, const LiveChannel& channel);
  void take_covariate(const StreamBlock& block, const LiveChannel& channel);
  [[nodiscard]] std::optional<double> known_factor(const StreamBlock& block, const LiveChannel& channel);
  void begin_at(double time);
  [[nodiscard]] const LiveChannel* channel_of(const StreamBlock& block);
  void complain(const std::string& what);
  void after_sample();
  void tell_changes();
  static void transfer(auto& self, auto& archive);

  LivePlan plan_;
  Say say_;
  std::function<void(const std::string&)> complain_;
  StreamLines reader_;
  SampleQueue queue_;
  StreamClock clock_;
  std::vector<ClockEvent> clock_events_;  ///< that have not been told
  std::optional<double> origin_;  ///< time of the first sample; after the clock has jumped, what its time would be [s]
  long every_;                    ///< samples between two lines of estimates
  std::int64_t lines_ = 0, logged_ = 0, bad_lines_ = 0;
  std::int64_t told_events_ = 0, told_alarms_ = 0;
  double told_day_ = -1e300;  ///< start of the latest day whose trend has been told [s]
  std::vector<EarlyValue> early_;
  std::set<std::string> unknown_columns_;  ///< told once each
  std::set<std::string> wrong_units_;      ///< of a column, told once each
};

}  // namespace kalfem
