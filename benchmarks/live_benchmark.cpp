// SPDX-License-Identifier: Apache-2.0
// `kalfem watch` from outside: how long after a block the estimate is there, by MQTT, beside the broker's own echo; and
// how many structures one process serves. Usage: live_benchmark KALFEM [seconds] [structures]
// with 0 for what is not to be measured
#include <mosquitto.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <mutex>

#include "live_places.hpp"
#include "timing.hpp"

namespace {

using namespace kalfem::benchmarks;
using Clock = std::chrono::steady_clock;

double milliseconds_between(Clock::time_point a, Clock::time_point b) {
  return std::chrono::duration<double, std::milli>(b - a).count();
}

double quantile(std::vector<double> values, double part) {
  std::ranges::sort(values);
  return values[std::min(values.size() - 1, static_cast<std::size_t>(part * static_cast<double>(values.size())))];
}

/// A client of a broker on this computer that keeps when messages came.
class Listener {
public:
  Listener(int port, const std::vector<std::string>& topics) : client_(mosquitto_new("benchmark", true, this)) {
    mosquitto_message_callback_set(client_, [](mosquitto*, void* self, const mosquitto_message* message) {
      static_cast<Listener*>(self)->hear(*message);
    });
    mosquitto_int_option(client_, MOSQ_OPT_TCP_NODELAY, 1);
    wait_for([&] { return mosquitto_connect(client_, "127.0.0.1", port, 60) == MOSQ_ERR_SUCCESS; }, "the broker");
    mosquitto_loop_start(client_);
    for (const auto& topic : topics) mosquitto_subscribe(client_, nullptr, topic.c_str(), 1);
  }
  ~Listener() {
    mosquitto_disconnect(client_);
    mosquitto_loop_stop(client_, true);
    mosquitto_destroy(client_);
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  void publish(const std::string& topic, const std::string& text) {
    mosquitto_publish(client_, nullptr, topic.c_str(), static_cast<int>(text.size()), text.data(), 1, false);
  }
  /// Of each topic: text and arrival.
  using Heard = std::vector<std::pair<std::string, Clock::time_point>>;
  [[nodiscard]] Heard heard(const std::string& topic) {
    const std::scoped_lock lock(lock_);
    return heard_[topic];
  }

private:
  void hear(const mosquitto_message& message) {
    const auto now = Clock::now();
    const std::scoped_lock lock(lock_);
    heard_[message.topic].emplace_back(
        std::string(static_cast<const char*>(message.payload), static_cast<std::size_t>(message.payloadlen)), now);
  }

  mosquitto* client_;
  std::mutex lock_;
  std::map<std::string, Heard> heard_;
};

void print_quantiles(const char* what, const std::vector<double>& times) {
  std::printf("%-36s p50 %6.2f   p99 %6.2f   p99.9 %6.2f ms\n", what, quantile(times, 0.5), quantile(times, 0.99),
              quantile(times, 0.999));
}

/// Blocks of ten samples at 1 kHz; half a block after each, the same bytes go to the broker and back.
void measure_latency(const std::string& kalfem, int masses, double duration) {
  constexpr int block = 10;
  constexpr double rate = 1000.0;
  constexpr std::size_t warm_up = 200;  // blocks
  const Scratch folder;
  const int port = free_port();
  write(folder / "broker.conf",
        "listener " + std::to_string(port) + " 127.0.0.1\nallow_anonymous true\nset_tcp_nodelay true\nuser root\n");
  write(folder / "drive.yaml",
        chain(masses, rate, "tolerance: 1e-3, duration: " + std::to_string(duration) + " s", ""));
  write(folder / "watch.yaml", chain(masses, rate, "",
                                     "horizon: 0.1 s, every: 10 ms, mqtt: {broker: 127.0.0.1, port: " +
                                         std::to_string(port) + ", topics: [in], publish: out}"));
  const auto lines = lines_of(kalfem + " play " + (folder / "drive.yaml").string() + " --speed 0 --block 10", folder);
  const Started broker("mosquitto -c " + (folder / "broker.conf").string() + " >" + (folder / "broker.txt").string() +
                       " 2>&1");
  Listener listener(port, {"out/estimates", "out/status", "echo"});
  const Started watching(kalfem + " watch " + (folder / "watch.yaml").string() + " >/dev/null");
  wait_for([&] { return !listener.heard("out/status").empty(); }, "kalfem watch");
  std::this_thread::sleep_for(std::chrono::seconds(1));
  std::vector<Clock::time_point> sent, echoed;
  const auto begin = Clock::now();
  const auto at = [&](double blocks) {
    std::this_thread::sleep_until(
        begin + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(blocks * block / rate)));
  };
  for (std::size_t k = 0; k < lines.size(); ++k) {
    at(static_cast<double>(k));
    sent.push_back(Clock::now());
    listener.publish("in", lines[k]);
    at(static_cast<double>(k) + 0.5);
    echoed.push_back(Clock::now());
    listener.publish("echo", lines[k]);
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));
  // The filter stays eight samples behind: the block that ends with sample 10 k + 9 makes it tell sample 10 k.
  std::vector<double> through_filter, through_broker;
  for (const auto& [text, arrival] : listener.heard("out/estimates")) {
    const double t = std::atof(text.c_str() + text.find(':') + 1);
    const auto k = static_cast<std::size_t>(std::lround(t * rate / block));
    if (k >= warm_up && k < sent.size()) through_filter.push_back(milliseconds_between(sent[k], arrival));
  }
  const auto echoes = listener.heard("echo");
  for (std::size_t k = warm_up; k < std::min(echoes.size(), echoed.size()); ++k)
    through_broker.push_back(milliseconds_between(echoed[k], echoes[k].second));
  if (through_filter.empty() || through_broker.empty()) throw std::runtime_error("no estimate has come");
  std::printf("\n%d states, blocks of 10 samples at 1 kHz, %zu of %zu answered\n", 2 * masses + 4,
              through_filter.size(), sent.size() - warm_up);
  print_quantiles("sample in, estimate out, by MQTT", through_filter);
  print_quantiles("the same bytes, broker alone", through_broker);
  for (const double part : {0.5, 0.99, 0.999})
    std::printf("  added at %5.1f %%: %.2f ms\n", 100.0 * part,
                quantile(through_filter, part) - quantile(through_broker, part));
}

/// Value of a metric of each case.
std::vector<double> metric(int port, const std::string& name) {
  const int client = connected_to(port);
  if (client < 0) return {};
  const std::string request = "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n";
  static_cast<void>(::write(client, request.data(), request.size()));
  std::string text;
  char buffer[65536];
  for (ssize_t count = 0; (count = read(client, buffer, sizeof buffer)) > 0;) text.append(buffer, std::size_t(count));
  close(client);
  std::vector<double> values;
  for (std::size_t place = text.find("\n" + name + "{"); place != std::string::npos;
       place = text.find("\n" + name + "{", place + 1))
    values.push_back(std::atof(text.c_str() + text.find("} ", place) + 2));
  return values;
}

/// So many chains at 200 Hz in one process, each by a port of its own, blocks of ten samples in real time.
void count_structures(const std::string& kalfem, int structures, double duration) {
  constexpr double rate = 200.0;
  constexpr int block = 10;
  const Scratch folder;
  std::filesystem::create_directories(folder / "cases");
  write(folder / "drive.yaml", chain(10, rate, "tolerance: 1e-3, duration: " + std::to_string(duration) + " s", ""));
  const auto lines = lines_of(kalfem + " play " + (folder / "drive.yaml").string() + " --speed 0 --block 10", folder);
  std::vector<int> ports;
  for (int i = 0; i < structures; ++i) {
    int port = free_port();
    while (std::ranges::find(ports, port) != ports.end()) port = free_port();
    ports.push_back(port);
    write(folder / ("cases/s" + std::to_string(i) + ".yaml"),
          chain(10, rate, "", "horizon: 2 s, every: 1 s, port: " + std::to_string(ports.back())));
  }
  const int metrics = free_port();
  const Started watching("sh -c 'ulimit -n 65536; exec " + kalfem + " watch " + (folder / "cases").string() +
                         " --metrics " + std::to_string(metrics) + " --state " + (folder / "kept").string() +
                         " --output " + (folder / "out.jsonl").string() + "' 2>" + (folder / "err.txt").string());
  std::vector<int> senders;
  for (const int port : ports)
    wait_for(
        [&] {
          const int sender = connected_to(port);
          if (sender >= 0) senders.push_back(sender);
          return sender >= 0;
        },
        "a structure");
  const double used_before = watching.processor_seconds();
  const auto begin = Clock::now();
  double latest = 0.0;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const std::string line = lines[k] + "\n";
    for (std::size_t i = 0; i < senders.size(); ++i) {  // spread over the time of a block
      const double due = (static_cast<double>(k) + static_cast<double>(i) / double(senders.size())) * block / rate;
      if (i % 10 == 0)
        std::this_thread::sleep_until(begin +
                                      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(due)));
      static_cast<void>(::write(senders[i], line.data(), line.size()));
    }
    latest = std::max(latest, std::chrono::duration<double>(Clock::now() - begin).count() -
                                  static_cast<double>(k + 1) * block / rate);
  }
  const double used = watching.processor_seconds() - used_before, last = std::floor(duration - 10.0 / rate);
  const auto end = Clock::now();
  wait_for(
      [&] {
        const auto times = metric(metrics, "kalfem_stream_seconds");
        return std::ssize(times) == structures && std::ranges::all_of(times, [&](double t) { return t >= last; });
      },
      "the end of all streams");
  const double behind = std::chrono::duration<double>(Clock::now() - end).count();
  for (const int sender : senders) close(sender);
  const auto late = metric(metrics, "kalfem_late_total");
  std::printf("\n%d chains of 24 states at 200 Hz in one process, %.0f s\n", structures, duration);
  std::printf("  processors that it used:                    %.2f\n", used / duration);
  std::printf("  all estimates were there after the end:     %.2f s\n", behind);
  std::printf("  the sender was late by at most:             %.2f s\n", latest);
  std::printf("  values that came too late:                  %.0f\n", *std::ranges::max_element(late));
  std::printf("  structures that two processors would serve: %.0f\n", 2.0 * duration / used * structures);
}

}  // namespace

int main(int count, char** arguments) try {
  if (count < 2) throw std::runtime_error("usage: live_benchmark KALFEM [seconds] [structures]");
  const double duration = count > 2 ? std::atof(arguments[2]) : 60.0;
  const int structures = count > 3 ? std::atoi(arguments[3]) : 500;
  mosquitto_lib_init();
  if (duration > 0.0)
    for (const int masses : {10, 69}) measure_latency(arguments[1], masses, duration);
  if (structures > 0) count_structures(arguments[1], structures, 20.0);
  mosquitto_lib_cleanup();
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
