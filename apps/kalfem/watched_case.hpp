// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "kalfem/study/study.hpp"
#include "kalfem/watch/message_lines.hpp"
#include "kalfem/watch/metrics_text.hpp"
#include "kalfem/watch/stream_source.hpp"
#include "kalfem/watch/watcher.hpp"
#include "mqtt_link.hpp"

namespace kalfem::command {

/// Where the samples of a case come from and what is kept of them, in place of what the case says.
struct WatchedCaseOptions {
  std::string case_file;
  std::vector<std::pair<std::string, std::optional<std::string>>> changes = {};  ///< keys with other values
  std::filesystem::path state;   ///< folder of what is kept; empty: as the case says, or beside it
  std::string log;               ///< file that keeps what comes in; empty: none
  std::optional<int> port = {};  ///< of TCP that lines are read from
  bool alone = true;             ///< it may read standard input, and use every core; otherwise one
  Watcher::Say recall = {};      ///< takes the alarms and the days of the trend of a state that it goes on from
};

/// One live case from its source to its outputs: reads until the source ends or the command is asked to stop, keeps the
/// state, the alarms and the trend in its folder, and publishes to the broker of the case.
class WatchedCase {
public:
  using Say = Watcher::Say;
  using Tell = std::function<void(const std::string&)>;

  /// `tell` takes messages. Throws InvalidInput for a case that cannot be watched.
  WatchedCase(WatchedCaseOptions options, Say say, Tell tell);

  /// Reads the stream. `stops`: asked at least ten times a second.
  void run(const std::function<bool()>& stops);
  /// Reads a log from its beginning; nothing is kept.
  void replay(const std::string& log);
  /// Whether the filter goes on.
  [[nodiscard]] bool usable() { return !watcher_.loop().failure(); }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const LivePlan& plan() const { return plan_; }
  /// From any thread.
  [[nodiscard]] WatchedHealth health() const;

private:
  using Clock = std::chrono::steady_clock;

  void say(MessageKind kind, const std::string& line);
  void publish(MessageKind kind, const std::string& line);
  void feed(std::istream& lines);
  void catch_up();
  [[nodiscard]] std::unique_ptr<StreamSource> open_source();
  void follow(StreamSource& source, const std::function<bool()>& stops);
  void take(std::string_view line);
  void keep_state();
  void keep_changes();
  template <class Write>
  void guard_disk(const Write& write);

  WatchedCaseOptions options_;
  Say say_;
  Tell tell_;
  std::string name_;
  Study study_;
  LivePlan plan_;
  std::unique_ptr<MqttLink> broker_;
  std::string last_verdict_;
  Watcher watcher_;
  std::filesystem::path state_file_;  ///< empty: nothing is kept
  std::optional<StreamLog> log_;
  LineCutter cutter_;
  Clock::time_point kept_ = Clock::now();
  bool disk_fails_ = false;

  mutable std::mutex health_lock_;
  WatchedHealth health_;
  Clock::time_point heard_ = Clock::now();
};

/// Lines of the messages that a broker sends. One that holds no samples is told once a topic.
class MqttSource final : public StreamSource {
public:
  MqttSource(MqttLink& broker, WatchedCase::Tell tell) : broker_(broker), tell_(std::move(tell)) {}
  State read(int milliseconds, std::string& bytes) override;

private:
  MqttLink& broker_;
  WatchedCase::Tell tell_;
  MessageLines lines_;
  std::set<std::string> told_;
  bool told_lost_ = false;
};

}  // namespace kalfem::command
