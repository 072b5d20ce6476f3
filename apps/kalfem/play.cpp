// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <tuple>

#include "console.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/watch/playback.hpp"
#include "mqtt_link.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

Playback published(const Study& study) {
  if (study.record) return playback_of(study, study.record->record);
  if (study.simulation) return playback_of(study, run_study(study, "simulate").get<SimulationOutcome>().measurements);
  throw InvalidInput(Issue{{study.file, 1},
                           "the case has neither `record` nor `simulate`",
                           "`kalfem play` publishes a record",
                           "name a case that has one"});
}

/// The broker and the topic of "localhost:1883/tower/samples".
std::pair<MqttOptions, std::string> place_of(const std::string& text) {
  const auto slash = text.find('/');
  const std::string host = text.substr(0, slash);
  const auto colon = host.find(':');
  MqttOptions options{.broker = host.substr(0, colon)};
  const std::string port = colon == std::string::npos ? "" : host.substr(colon + 1);
  const bool good_port = port.size() < 6 && port.find_first_not_of("0123456789") == std::string::npos;
  if (slash == std::string::npos || slash + 1 == text.size() || options.broker.empty() || !good_port)
    throw InvalidInput("--mqtt " + text + ": no topic of a broker is written like that", "",
                       "write BROKER/TOPIC or BROKER:PORT/TOPIC");
  if (!port.empty()) options.port = std::stoi(port);
  options.publish = text.substr(slash + 1);
  return {options, options.publish};
}

/// Lines to a topic of a broker, or to standard output.
class PlayOutput {
public:
  explicit PlayOutput(const std::string& mqtt) {
    if (mqtt.empty()) return;
    MqttOptions options;
    std::tie(options, topic_) = place_of(mqtt);
    broker_ = make_mqtt_link(options, "kalfem-play-" + std::to_string(getpid()), "",
                             [](const std::string& text) { print_error("{}\n", text); });
  }
  void say(const std::string& line) {
    if (broker_)
      broker_->publish(topic_, line, Delivery::every);
    else
      print("{}\n", line);
  }
  /// Waits until the broker has taken what was said: no more than it takes at a time are under way.
  void flush() {
    if (broker_)
      while (!broker_->finish(100)) stop_if_asked();
    require_output();
  }

private:
  std::unique_ptr<MqttLink> broker_;
  std::string topic_;
};

}  // namespace

ExitCode play(const PlayArguments& arguments) {
  using Clock = std::chrono::steady_clock;
  std::vector<ScheduledFault> faults;
  for (const auto& text : arguments.faults) faults.push_back(scheduled_fault(text));
  PlayOutput output(arguments.mqtt);
  const Study study = load_study(arguments.case_file, changes_of(arguments.changes));
  Playback playback = published(study);
  if (arguments.start) playback.start = *arguments.start;
  apply_faults(faults, playback);
  const auto begin = Clock::now();
  for (Eigen::Index first = 0; first < playback.samples(); first += arguments.block) {
    const auto count = std::min<Eigen::Index>(arguments.block, playback.samples() - first);
    if (arguments.speed > 0.0) {  // a block is there once its last sample has been taken
      const double due = static_cast<double>(first + count - 1) / playback.sample_rate / arguments.speed;
      const auto left = [&] { return due - std::chrono::duration<double>(Clock::now() - begin).count(); };
      for (double rest = left(); rest > 0.0; rest = left()) {
        stop_if_asked();
        std::this_thread::sleep_for(std::chrono::duration<double>(std::min(rest, 0.1)));
      }
    }
    stop_if_asked();
    for (const auto& line : playback.lines(first, count)) output.say(line);
    output.flush();
    if (reader_has_gone()) return done;
  }
  return done;
}

}  // namespace kalfem::command
