// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "kalfem/live/sample_queue.hpp"
#include "kalfem/study/live_plan.hpp"
#include "kalfem/watch/stream_line.hpp"

namespace kalfem {

/// A live case: lines of a stream in, lines of estimates out. What comes out depends on what came in alone, neither on
/// the clock nor on the length of blocks, so that the same lines give the same bits.
class Watcher final : public Resumable {
public:
  /// `say`: takes a line of estimates, without a line break; `complain`: takes a message.
  Watcher(LivePlan plan, std::function<void(const std::string&)> say, std::function<void(const std::string&)> complain);

  /// Takes a line. One that cannot be used is told and counted, and that is all.
  void take(std::string_view line);
  /// A line of estimates where the filter stands.
  void tell();

  [[nodiscard]] std::int64_t lines() const { return lines_; }  ///< taken
  /// Bytes of the log that the state has seen.
  [[nodiscard]] std::int64_t logged() const { return logged_; }
  void logged(std::int64_t bytes) { logged_ = bytes; }
  /// Of the stream, where the filter stands [s].
  [[nodiscard]] double time() const { return origin_.value_or(0.0) + queue_.steps().loop().time(); }
  [[nodiscard]] OnlineLoop& loop() { return queue_.steps().loop(); }  ///< the filter
  [[nodiscard]] std::string fingerprint() const { return queue_.fingerprint(); }

  void keep(ArchiveWriter& archive) const override;
  void take_up(ArchiveReader& archive) override;

private:
  void take_block(const StreamBlock& block);
  [[nodiscard]] const LiveChannel* channel_of(const StreamBlock& block);
  void complain(const std::string& what);
  void after_sample();
  static void transfer(auto& self, auto& archive);

  LivePlan plan_;
  std::function<void(const std::string&)> say_, complain_;
  StreamLines reader_;
  SampleQueue queue_;
  std::optional<double> origin_;  ///< time of the first sample [s]
  long every_;                    ///< samples between two lines of estimates
  std::int64_t lines_ = 0, logged_ = 0, bad_lines_ = 0;
  std::int64_t told_events_ = 0;
  std::set<std::string> unknown_columns_;  ///< told once each
};

}  // namespace kalfem
