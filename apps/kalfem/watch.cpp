// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/output_folder.hpp"
#include "kalfem/live/state_file.hpp"
#include "kalfem/watch/change_lines.hpp"
#include "kalfem/watch/stream_source.hpp"
#include "kalfem/watch/watcher.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr auto state_interval = std::chrono::milliseconds(900);  ///< between two states on disk, at most a second
constexpr auto patience = std::chrono::seconds(10);              ///< without a line, until it is told
constexpr int poll_interval = 100;                               ///< [ms]

class Watch {
public:
  explicit Watch(const WatchArguments& arguments)
      : arguments_(arguments),
        study_(load_study(arguments.case_file, changes_of(arguments.changes))),
        plan_(make_live_plan(study_)),
        watcher_(
            plan_, [this](MessageKind kind, const std::string& line) { say(kind, line); },
            [](const std::string& text) { print_error("{}\n", text); }) {
    for (const auto& warning : study_.warnings) print_error("warning: {}\n", warning);
  }

  ExitCode replay() {
    std::ifstream log(arguments_.replay, std::ios::binary);
    if (!log) throw InvalidInput("the log " + arguments_.replay + " cannot be read", "", "");
    feed(log);
    watcher_.tell();
    return code();
  }

  ExitCode run() {
    fs::path folder =
        plan_.state.empty() ? fs::path(arguments_.case_file).replace_extension(".kalfem-live") : plan_.state;
    const FolderLock lock(folder);
    state_file_ = folder / "state";
    if (fs::exists(state_file_)) {
      read_state_file(state_file_, watcher_.fingerprint(), watcher_);
      print_error("goes on from {:.6g} s, after {} lines, with the state in {}\n", watcher_.time(), watcher_.lines(),
                  state_file_.string());
    }
    if (!arguments_.log.empty()) catch_up();
    const auto source = open_source();
    follow(*source);
    keep_state();  // first: to look at a filter moves its last bits
    watcher_.tell();
    if (watcher_.monitor()) keep_changes();
    return code();
  }

private:
  void say(MessageKind kind, const std::string& line) {
    print("{}\n", line);
    if (kind != MessageKind::estimates && !state_file_.empty()) keep_changes();
  }

  /// The alarms and the trend by day, beside the state.
  void keep_changes() {
    guard_disk([&] {
      const auto folder = state_file_.parent_path();
      write_file_atomically(folder / "alarms.jsonl", alarm_file(*watcher_.monitor(), watcher_.origin()));
      write_file_atomically(folder / "trend.csv", trend_table(*watcher_.monitor()));
    });
  }

  void feed(std::istream& lines) {
    for (std::string line; std::getline(lines, line);) {
      stop_if_asked();
      watcher_.take(line);
      require_output();
    }
  }

  /// What the log has beyond the state: lines that came after it had been written.
  void catch_up() {
    log_.emplace(arguments_.log);
    if (log_->size() < watcher_.logged())
      throw InvalidInput("the log " + arguments_.log + " is shorter than what the state has seen",
                         "it belongs to another state", "give its own log, or remove " + state_file_.string());
    if (log_->size() == watcher_.logged()) return;
    std::ifstream behind(arguments_.log, std::ios::binary);
    behind.seekg(watcher_.logged());
    const auto before = watcher_.lines();
    feed(behind);
    watcher_.logged(log_->size());
    print_error("takes {} lines from the log that the state has not seen\n", watcher_.lines() - before);
  }

  std::unique_ptr<StreamSource> open_source() {
    const auto port = arguments_.port > 0 ? std::optional(arguments_.port) : plan_.port;
    if (!port) return std::make_unique<DescriptorSource>(STDIN_FILENO);
    auto source = std::make_unique<PortSource>(*port);
    print_error("reads lines at 127.0.0.1:{}\n", *port);
    return source;
  }

  void follow(StreamSource& source) {
    const auto take = [&](std::string_view line) {
      if (log_) log(line);
      watcher_.take(line);
    };
    auto heard = Clock::now();
    bool told_silence = false;
    while (!stop_question()()) {
      std::string bytes;
      const auto state = source.read(poll_interval, bytes);
      cutter_.add(bytes, StreamLines::longest_line, take);
      require_output();
      if (Clock::now() - kept_ > state_interval) keep_state();
      if (state == StreamSource::State::ended) {
        if (const auto rest = cutter_.take_rest(); !rest.empty()) take(rest);
        return;
      }
      if (state == StreamSource::State::gave) {
        heard = Clock::now();
        told_silence = false;
      } else if (!told_silence && Clock::now() - heard > patience) {
        print_error("no line has come for {} s; it goes on waiting\n", patience.count());
        told_silence = true;
      }
    }
  }

  /// A disk that is full does not end the watch: it is told once, until it takes bytes again.
  void log(std::string_view line) {
    guard_disk([&] { log_->add(line); });
    watcher_.logged(log_->size());
  }
  void keep_state() {
    kept_ = Clock::now();
    guard_disk([&] { write_state_file(state_file_, watcher_.fingerprint(), watcher_); });
  }
  template <class Write>
  void guard_disk(const Write& write) {
    try {
      write();
      disk_fails_ = false;
    } catch (const WriteFailure& error) {
      if (!disk_fails_) print_error("{}; it goes on without\n", error.what());
      disk_fails_ = true;
    }
  }

  ExitCode code() { return watcher_.loop().failure() ? not_usable : done; }

  WatchArguments arguments_;
  Study study_;
  LivePlan plan_;
  Watcher watcher_;
  fs::path state_file_;
  std::optional<StreamLog> log_;
  LineCutter cutter_;
  Clock::time_point kept_ = Clock::now();
  bool disk_fails_ = false;
};

}  // namespace

ExitCode watch(const WatchArguments& arguments) {
  Watch watch(arguments);
  return arguments.replay.empty() ? watch.run() : watch.replay();
}

}  // namespace kalfem::command
