// SPDX-License-Identifier: Apache-2.0
#include "watched_case.hpp"

#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/interruption.hpp"
#include "kalfem/base/output_folder.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/casefile/description.hpp"
#include "kalfem/live/state_file.hpp"
#include "kalfem/watch/change_lines.hpp"

namespace kalfem::command {
namespace {

namespace fs = std::filesystem;

constexpr auto state_interval = std::chrono::milliseconds(900);  ///< between two states on disk, at most a second
constexpr auto patience = std::chrono::seconds(10);              ///< without a line, until it is told
constexpr int poll_interval = 100;                               ///< [ms]
constexpr std::size_t most_told = 100;                           ///< topics with a message that cannot be used

std::vector<CaseChange> changes_of(const WatchedCaseOptions& options) {
  std::vector<CaseChange> changes;
  for (const auto& [key, value] : options.changes) changes.push_back({key, value});
  return changes;
}

/// The plan of a case among others: one thread for its filter, unless the case states more.
LivePlan on_one_core(LivePlan plan) {
  if (plan.problem.problem->settings.threads != 0) return plan;
  auto problem = std::make_shared<EstimationProblem>(*plan.problem.problem);
  problem->settings.threads = 1;
  plan.problem.problem = std::move(problem);
  return plan;
}

}  // namespace

StreamSource::State MqttSource::read(int milliseconds, std::string& bytes) {
  broker_.work(milliseconds);
  for (const auto& [topic, payload] : broker_.take()) try {
      if (const auto line = lines_.line_of(topic, payload)) bytes += *line + "\n";
    } catch (const InvalidInput& error) {
      if (told_.size() < most_told && told_.insert(topic).second)
        tell_(std::string(error.what()) + "; such messages are left out");
    }
  if (lines_.lost() > 0 && !std::exchange(told_lost_, true))
    tell_("the counters of the blocks miss some: they were lost on the way");
  return bytes.empty() ? State::waits : State::gave;
}

WatchedCase::WatchedCase(WatchedCaseOptions options, Say say, Tell tell)
    : options_(std::move(options)),
      say_(std::move(say)),
      tell_(std::move(tell)),
      name_(fs::path(options_.case_file).stem().string()),
      study_(load_study(options_.case_file, changes_of(options_))),
      plan_(options_.alone ? make_live_plan(study_) : on_one_core(make_live_plan(study_))),
      watcher_(
          plan_, [this](MessageKind kind, const std::string& line) { this->say(kind, line); },
          [this](const std::string& text) { tell_(text); }) {
  health_.name = name_;
  for (const auto& warning : study_.warnings) tell_("warning: " + warning);
}

void WatchedCase::replay(const std::string& log) {
  std::ifstream lines(log, std::ios::binary);
  if (!lines) throw InvalidInput("the log " + log + " cannot be read", "", "");
  feed(lines);
  watcher_.tell();
}

void WatchedCase::run(const std::function<bool()>& stops) {
  fs::path folder = options_.state.empty() ? plan_.state : options_.state;
  if (folder.empty()) folder = fs::path(options_.case_file).replace_extension(".kalfem-live");
  const FolderLock lock(folder);
  if (plan_.mqtt) {
    const std::string base = plan_.mqtt->publish;
    broker_ = make_mqtt_link(*plan_.mqtt, "kalfem-" + name_, base.empty() ? "" : base + "/status", tell_);
  }
  state_file_ = folder / "state";
  if (fs::exists(state_file_)) {
    read_state_file(state_file_, watcher_.fingerprint(), watcher_);
    tell_("goes on from " + shortest(watcher_.time()) + " s, after " + std::to_string(watcher_.lines()) +
          " lines, with the state in " + state_file_.string());
    if (options_.recall) watcher_.recall(options_.recall);
  }
  if (!options_.log.empty()) catch_up();
  const auto source = open_source();
  follow(*source, stops);
  keep_state();  // first: to look at a filter moves its last bits
  watcher_.tell();
  if (watcher_.monitor()) keep_changes();
  if (broker_ && !broker_->finish(2000)) tell_("not everything has reached the broker");
}

WatchedHealth WatchedCase::health() const {
  const std::scoped_lock lock(health_lock_);
  WatchedHealth health = health_;
  health.silent_for = std::chrono::duration<double>(Clock::now() - heard_).count();
  return health;
}

void WatchedCase::say(MessageKind kind, const std::string& line) {
  {
    const std::scoped_lock lock(health_lock_);
    if (kind == MessageKind::estimates) health_.estimates = line;
    if (kind == MessageKind::alarm) ++health_.alarms;
  }
  say_(kind, line);
  if (broker_ && !plan_.mqtt->publish.empty()) publish(kind, line);
  if (kind != MessageKind::estimates && !state_file_.empty()) keep_changes();
}

/// Under the case's topic: the latest estimates, verdict and trend, which the broker retains, and every alarm.
void WatchedCase::publish(MessageKind kind, const std::string& line) {
  const std::string& base = plan_.mqtt->publish;
  if (kind == MessageKind::trend) broker_->publish(base + "/trend", line, Delivery::latest);
  if (kind == MessageKind::alarm) {
    broker_->publish(base + "/alarms", line, Delivery::every);
    broker_->publish(base + "/alarm", line, Delivery::latest);
  }
  if (kind != MessageKind::estimates) return;
  broker_->publish(base + "/estimates", line, Delivery::latest);
  const auto told = nlohmann::ordered_json::parse(line);
  const nlohmann::ordered_json verdict{
      {"condition", told["condition"]}, {"verdict", told["verdict"]}, {"reasons", told["reasons"]}};
  if (const std::string text = verdict.dump(); text != last_verdict_) {
    last_verdict_ = text;
    broker_->publish(base + "/verdict", text, Delivery::latest);
  }
}

void WatchedCase::feed(std::istream& lines) {
  for (std::string line; std::getline(lines, line);) {
    stop_if_asked();
    watcher_.take(line);
  }
}

/// What the log has beyond the state: lines that came after it had been written.
void WatchedCase::catch_up() {
  log_.emplace(options_.log);
  if (log_->size() < watcher_.logged())
    throw InvalidInput("the log " + options_.log + " is shorter than what the state has seen",
                       "it belongs to another state", "give its own log, or remove " + state_file_.string());
  if (log_->size() == watcher_.logged()) return;
  std::ifstream behind(options_.log, std::ios::binary);
  behind.seekg(watcher_.logged());
  const auto before = watcher_.lines();
  feed(behind);
  watcher_.logged(log_->size());
  tell_("takes " + std::to_string(watcher_.lines() - before) + " lines from the log that the state has not seen");
}

std::unique_ptr<StreamSource> WatchedCase::open_source() {
  const auto port = options_.port ? options_.port : plan_.port;
  if (port) {
    auto source = std::make_unique<PortSource>(*port);
    tell_("reads lines at 127.0.0.1:" + std::to_string(*port));
    return source;
  }
  if (broker_ && !plan_.mqtt->topics.empty()) return std::make_unique<MqttSource>(*broker_, tell_);
  if (!options_.alone)
    throw InvalidInput(Issue{study_.description->live->location,
                             "the case has neither `live.port` nor `live.mqtt.topics`",
                             "several cases cannot share standard input", "give one of them"});
  return std::make_unique<DescriptorSource>(STDIN_FILENO);
}

void WatchedCase::take(std::string_view line) {
  if (log_) {  // a disk that is full does not end the watch
    guard_disk([&] { log_->add(line); });
    watcher_.logged(log_->size());
  }
  watcher_.take(line);
}

void WatchedCase::follow(StreamSource& source, const std::function<bool()>& stops) {
  const bool works_for_broker = broker_ && !dynamic_cast<MqttSource*>(&source);
  bool told_silence = false;
  while (!stops()) {
    std::string bytes;
    const auto state = source.read(poll_interval, bytes);
    cutter_.add(bytes, StreamLines::longest_line, [&](std::string_view line) { take(line); });
    if (works_for_broker) broker_->work(0);
    if (Clock::now() - kept_ > state_interval) keep_state();
    if (state == StreamSource::State::ended) {
      if (const auto rest = cutter_.take_rest(); !rest.empty()) take(rest);
      return;
    }
    if (state == StreamSource::State::gave) {
      const std::scoped_lock lock(health_lock_);
      heard_ = Clock::now();
      told_silence = false;
    } else if (!told_silence && Clock::now() - heard_ > patience) {
      tell_("no line has come for " + std::to_string(patience.count()) + " s; it goes on waiting");
      told_silence = true;
    }
  }
}

void WatchedCase::keep_state() {
  kept_ = Clock::now();
  guard_disk([&] { write_state_file(state_file_, watcher_.fingerprint(), watcher_); });
}

/// The alarms and the trend by day, beside the state.
void WatchedCase::keep_changes() {
  guard_disk([&] {
    const auto folder = state_file_.parent_path();
    write_file_atomically(folder / "alarms.jsonl", alarm_file(*watcher_.monitor(), watcher_.origin()));
    write_file_atomically(folder / "trend.csv", trend_table(*watcher_.monitor()));
  });
}

/// A disk that is full is told once, until it takes bytes again.
template <class Write>
void WatchedCase::guard_disk(const Write& write) {
  try {
    write();
    disk_fails_ = false;
  } catch (const WriteFailure& error) {
    if (!disk_fails_) tell_(std::string(error.what()) + "; it goes on without");
    disk_fails_ = true;
  }
}

}  // namespace kalfem::command
