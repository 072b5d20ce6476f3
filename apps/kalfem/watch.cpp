// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/watch/influx_lines.hpp"
#include "kalfem/watch/message_history.hpp"
#include "local_server.hpp"
#include "verbs.hpp"
#include "watched_case.hpp"

namespace kalfem::command {
namespace {

namespace fs = std::filesystem;

/// Lines of all cases to standard output, or at the end of a file, and to the page.
class WatchOutput {
public:
  WatchOutput(const WatchArguments& arguments, bool names_cases)
      : as_influx_(arguments.format == "influx"), names_cases_(names_cases) {
    if (arguments.output.empty()) return;
    file_name_ = arguments.output;
    file_.open(arguments.output, std::ios::app | std::ios::binary);
    if (!file_) fail_to_write(arguments.output, errno);
  }

  void say(MessageKind kind, const std::string& line, const std::string& name) {
    show(kind, line, name);
    const std::string text = as_influx_ ? influx_lines(kind, line, name) : named(line, name) + "\n";
    const std::scoped_lock lock(lock_);
    if (file_.is_open()) {
      file_ << text << std::flush;
      if (!file_) fail_to_write(file_name_, errno);
    } else {
      print("{}", text);
      require_output();
    }
  }
  /// On the page alone.
  void show(MessageKind kind, const std::string& line, const std::string& name) {
    if (shown_) shown_->add(kind, name, line);
  }
  /// From now on there is one; what it shows.
  const MessageHistory& open_page() { return shown_.emplace(); }
  void tell(const std::string& text, const std::string& name) {
    const std::scoped_lock lock(lock_);
    if (names_cases_)
      print_error("{}: {}\n", name, text);
    else
      print_error("{}\n", text);
  }

private:
  [[nodiscard]] std::string named(const std::string& line, const std::string& name) const {
    return names_cases_ ? "{\"case\":" + nlohmann::json(name).dump() + "," + line.substr(1) : line;
  }

  bool as_influx_, names_cases_;
  fs::path file_name_;
  std::ofstream file_;
  std::mutex lock_;
  std::optional<MessageHistory> shown_;
};

/// The ports that were asked for, one where both are the same.
class LocalPorts {
public:
  LocalPorts(std::optional<int> metrics, std::optional<int> page,
             const std::function<std::vector<WatchedHealth>()>& cases, WatchOutput& output) {
    if (metrics && metrics != page) metrics_.emplace(*metrics, cases, nullptr);
    if (!page) return;
    page_.emplace(*page, cases, &output.open_page());
    print_error("shows what it does at http://127.0.0.1:{}/\n", *page);
  }

private:
  std::optional<LocalServer> metrics_, page_;
};

std::optional<int> port_of(int argument) { return argument > 0 ? std::optional(argument) : std::nullopt; }

/// The cases of a folder that are live, each in a thread of its own, so that one that fails does not touch the others.
class WatchedFolder {
public:
  explicit WatchedFolder(const WatchArguments& arguments) : output_(arguments, true) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(arguments.case_file))
      if (entry.is_regular_file() && entry.path().extension() == ".yaml") files.push_back(entry.path());
    std::ranges::sort(files);
    if (files.empty())
      throw InvalidInput("the folder " + arguments.case_file + " holds no case", "a case is a file *.yaml", "");
    for (const auto& file : files) add(file, arguments);
  }

  ExitCode run(const WatchArguments& arguments) {
    const LocalPorts ports(
        port_of(arguments.metrics), port_of(arguments.page), [this] { return health(); }, output_);
    {
      std::vector<std::jthread> threads;
      for (auto& each : cases_)
        if (each->watched) threads.emplace_back([this, &each] { watch(*each); });
    }
    const bool any_failed = std::ranges::any_of(cases_, [](const auto& each) { return each->failed; });
    const bool all_usable = std::ranges::all_of(cases_, [](const auto& each) { return each->usable; });
    return any_failed ? mend_the_input : all_usable ? done : not_usable;
  }

private:
  struct Entry {
    std::string name;
    std::unique_ptr<WatchedCase> watched;
    bool failed = false, usable = true;
    std::mutex lock = {};
    std::string why = {};  ///< it does not run
  };

  void add(const fs::path& file, const WatchArguments& arguments) {
    auto entry = std::make_unique<Entry>();
    entry->name = file.stem().string();
    const std::string name = entry->name;
    WatchedCaseOptions options{
        .case_file = file.string(), .alone = false, .recall = [this, name](MessageKind kind, const std::string& line) {
          output_.show(kind, line, name);
        }};
    if (!arguments.state.empty()) options.state = fs::path(arguments.state) / name;
    for (const auto& change : changes_of(arguments.changes)) options.changes.emplace_back(change.key, change.value);
    if (!arguments.log.empty()) {
      fs::create_directories(arguments.log);
      options.log = (fs::path(arguments.log) / (name + ".log")).string();
    }
    try {
      entry->watched = std::make_unique<WatchedCase>(
          options, [this, name](MessageKind kind, const std::string& line) { output_.say(kind, line, name); },
          [this, name](const std::string& text) { output_.tell(text, name); });
      if (entry->watched->plan().metrics || entry->watched->plan().page)
        output_.tell(
            "live.metrics and live.page are of a case that is watched alone; of a folder, give --metrics or "
            "--page",
            name);
    } catch (const InvalidInput& error) {
      fail(*entry, error.what());
    }
    cases_.push_back(std::move(entry));
  }

  void watch(Entry& entry) {
    const StopScope scope(&stop_question());
    try {
      entry.watched->run([] { return stop_question()(); });
      entry.usable = entry.watched->usable();
      const std::scoped_lock lock(entry.lock);
      entry.why = "its stream has ended";
    } catch (const Interrupted&) {
      const std::scoped_lock lock(entry.lock);
      entry.why = "it was stopped";
    } catch (const std::exception& error) {
      fail(entry, error.what());
    }
  }

  void fail(Entry& entry, const std::string& why) {
    output_.tell(why, entry.name);
    entry.failed = true;
    const std::scoped_lock lock(entry.lock);
    entry.why = why;
  }

  [[nodiscard]] std::vector<WatchedHealth> health() const {
    std::vector<WatchedHealth> all;
    for (const auto& entry : cases_) {
      auto& health = all.emplace_back(entry->watched ? entry->watched->health() : WatchedHealth{.name = entry->name});
      const std::scoped_lock lock(entry->lock);
      health.running = entry->why.empty();
      health.why_not = entry->why;
    }
    return all;
  }

  WatchOutput output_;
  std::vector<std::unique_ptr<Entry>> cases_;
};

ExitCode watch_folder(const WatchArguments& arguments) {
  if (!arguments.replay.empty() || arguments.port > 0)
    throw InvalidInput("--replay and --port are of one case, and " + arguments.case_file + " is a folder", "",
                       "give live.port in each case, or replay them one by one");
  WatchedFolder folder(arguments);
  return folder.run(arguments);
}

ExitCode watch_case(const WatchArguments& arguments) {
  WatchOutput output(arguments, false);
  const std::string name = fs::path(arguments.case_file).stem().string();
  WatchedCaseOptions options{
      .case_file = arguments.case_file,
      .state = arguments.state,
      .log = arguments.log,
      .recall = [&](MessageKind kind, const std::string& line) { output.show(kind, line, name); }};
  for (const auto& change : changes_of(arguments.changes)) options.changes.emplace_back(change.key, change.value);
  if (arguments.port > 0) options.port = arguments.port;
  WatchedCase watched(
      options, [&](MessageKind kind, const std::string& line) { output.say(kind, line, name); },
      [&](const std::string& text) { output.tell(text, name); });
  if (!arguments.replay.empty()) {
    watched.replay(arguments.replay);
  } else {
    const auto metrics = port_of(arguments.metrics), page = port_of(arguments.page);
    const LocalPorts ports(
        metrics ? metrics : watched.plan().metrics, page ? page : watched.plan().page,
        [&] { return std::vector{watched.health()}; }, output);
    watched.run([] { return stop_question()(); });
  }
  return watched.usable() ? done : not_usable;
}

}  // namespace

ExitCode watch(const WatchArguments& arguments) {
  return fs::is_directory(arguments.case_file) ? watch_folder(arguments) : watch_case(arguments);
}

}  // namespace kalfem::command
