// SPDX-License-Identifier: Apache-2.0
// A car that drives for hours while its stream has gaps, late blocks, missing values, jumps of the clock, and sensors
// that die, stick, lie and come back. KALFEM_STEPS: so many samples; 300,000 without it.
#include <array>
#include <cstdlib>
#include <deque>
#include <numbers>
#include <random>

#include "kalfem/study/study.hpp"
#include "kalfem/watch/watcher.hpp"
#include "live_case.hpp"

namespace kalfem::live_case {
namespace {

using Json = nlohmann::json;

constexpr double rate = 500.0, dt = 1.0 / rate;
constexpr int block = 25;          ///< samples in a line
constexpr double walk = 20.0;      ///< of the stiffness [N/m/sqrt(s)]
constexpr double settling = 60.0;  ///< after a fault, until events count as false [s]

long steps() {
  const char* given = std::getenv("KALFEM_STEPS");
  return given ? std::atol(given) : 300'000;
}

/// The car of live_case.hpp on a road without end, by Runge-Kutta's fourth order with a fifth of the sampling interval.
/// Its linear stiffness k1 walks at random, towards its mean.
class Car {
public:
  explicit Car(unsigned seed) : random_(seed) {
    double sum = 0.0;
    for (int i = 0; i < 50'000; ++i) {
      move();
      sum += state_[4] * state_[4];
    }
    scale_ = 6e-3 / std::sqrt(sum / 50'000.0);
    state_ = {};
  }

  struct Sample {
    double wheel, body, road;
  };

  /// The next sample.
  Sample next() {
    move();
    k1_ += walk * std::sqrt(dt) * normal_(random_) - 1e-4 * dt * (k1_ - 2e4);
    const auto rates = rates_of(state_, noise_);
    return {rates[1] + 0.05 * normal_(random_), rates[3] + 0.02 * normal_(random_), scale_ * state_[4]};
  }
  [[nodiscard]] double k1() const { return k1_; }

private:
  using State = std::array<double, 8>;  ///< wheel, its velocity, body, its velocity, and four of the road

  [[nodiscard]] State rates_of(const State& s, double noise) const {
    constexpr double omega = 2.0 * std::numbers::pi * 5.0;
    const double stroke = s[2] - s[0], speed = s[3] - s[1];
    const double strut = k1_ * stroke + 3e6 * stroke * stroke * stroke + 1200.0 * speed;
    const double tyre = 1.8e5 * (scale_ * s[4] - s[0]) + 200.0 * (scale_ * s[5] - s[1]);
    return {s[1], (strut + tyre) / 40.0,
            s[3], -strut / 300.0,
            s[5], omega * omega * (s[6] - s[4]) - 1.4 * omega * s[5],
            s[7], omega * omega * (noise - s[6]) - 1.4 * omega * s[7]};
  }
  void move() {
    constexpr int parts = 5;
    const auto at = [](const State& s, const State& r, double h) {
      State next = s;
      for (std::size_t i = 0; i < s.size(); ++i) next[i] += h * r[i];
      return next;
    };
    const double h = dt / parts;
    for (int part = 0; part < parts; ++part) {
      noise_ = normal_(random_);
      const State a = rates_of(state_, noise_), b = rates_of(at(state_, a, h / 2), noise_),
                  c = rates_of(at(state_, b, h / 2), noise_), d = rates_of(at(state_, c, h), noise_);
      for (std::size_t i = 0; i < state_.size(); ++i) state_[i] += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
    }
  }

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  double k1_ = 2e4, scale_ = 0.0, noise_ = 0.0;
  State state_{};
};

enum class Fault { none, dead, offset, spikes, saturated, missing, gap, late, too_late, ahead, behind };
constexpr std::array faults{Fault::dead, Fault::offset, Fault::spikes,   Fault::saturated, Fault::missing,
                            Fault::gap,  Fault::late,   Fault::too_late, Fault::ahead,     Fault::behind};
constexpr std::array<const char*, 11> words{
    "none",        "dead",        "offset", "spikes", "saturated", "missing", "gap", "late", "late beyond the horizon",
    "clock ahead", "clock behind"};

struct Episode {
  Fault fault = Fault::none;
  std::string channel;
  double begin = 0.0, end = 0.0;  ///< of the stream's clock [s]
  bool named = false;
};

/// The road, its watcher, and what it said.
class Soak {
public:
  explicit Soak(unsigned seed, bool with_faults) : car_(seed), random_(seed + 1), with_faults_(with_faults) {
    const std::string case_text = live("window: 5000", R"(
  wheel: {acceleration: wheel.w, noise: 0.05 m/s^2}
  body: {acceleration: body.b, noise: 0.02 m/s^2})");
    std::string text = case_text.substr(0, case_text.find("\nestimate:"));
    text += "\nestimate:\n  unknown: {strut.k1: {initial: 20.5 kN/m, std: 1 kN/m, random_walk: 20 N/m}}\n";
    text.replace(text.find("horizon: 0.5 s, every: 0.5 s"), 28, "horizon: 2 s, every: 60 s");
    const ScratchFolder folder("watch_soak");
    watcher_ = std::make_unique<Watcher>(
        make_live_plan(load_study(written(folder / "live.yaml", text))),
        [this](MessageKind, const std::string& line) { hear(Json::parse(line)); },
        [this](const std::string& text) {
          ++complaints;
          if (complaints < 20) std::printf("  %s\n", text.c_str());
        });
  }

  void drive(long samples) {
    const long hour = std::lround(3600.0 * rate);
    for (long k = 0; k < samples; k += block) {
      send_block();
      if (k < hour && k + block >= std::min(hour, samples / 3)) settled_ = std::max(settled_, resident_megabytes());
    }
    watcher_->tell();
  }

  long complaints = 0, minutes = 0, held = 0, consistent = 0, false_events = 0;
  std::vector<std::string> false_texts;
  std::deque<Episode> episodes;
  [[nodiscard]] double growth() const { return resident_megabytes() - settled_; }
  [[nodiscard]] Json last() const { return last_; }

private:
  void send_block() {
    begin_and_end_faults();
    const auto fault =
        with_faults_ && !episodes.empty() && clock_ < episodes.back().end ? episodes.back().fault : Fault::none;
    std::array<std::array<double, block>, 3> values{};
    for (int i = 0; i < block; ++i) {
      const auto sample = car_.next();
      for (std::size_t c = 0; c < 3; ++c)
        values[c][static_cast<std::size_t>(i)] = std::array{sample.wheel, sample.body, sample.road}[c];
    }
    const double time = clock_;
    clock_ += block * dt;
    truth_.emplace_back(clock_, car_.k1());
    if (truth_.size() > 20'000) truth_.pop_front();
    if (fault == Fault::gap) return;
    Json line{{"t", time}, {"dt", dt}, {"road", values[2]}};
    for (std::size_t c = 0; c < 2; ++c) {
      const std::string channel = c == 0 ? "wheel" : "body";
      line[channel] =
          fault != Fault::none && episodes.back().channel == channel ? spoilt(values[c], fault) : Json(values[c]);
    }
    if (fault == Fault::late || fault == Fault::too_late) {
      waiting_.push_back(line.dump());
      return;
    }
    watcher_->take(line.dump());
  }

  Json spoilt(std::array<double, block> values, Fault fault) {
    Json told = Json::array();
    for (auto& value : values) {
      if (fault == Fault::dead) value = 0.0;
      if (fault == Fault::offset) value += 25.0;
      if (fault == Fault::saturated) value = std::clamp(value, -0.3, 0.3);
      if (fault == Fault::spikes && std::uniform_real_distribution<double>()(random_) < 0.02) value += 30.0;
      told.push_back(fault == Fault::missing ? Json(nullptr) : Json(value));
    }
    return told;
  }

  void begin_and_end_faults() {
    if (!waiting_.empty() && clock_ >= episodes.back().end) {  // what was late comes, its blocks in no order
      std::ranges::shuffle(waiting_, random_);
      for (const auto& line : waiting_) watcher_->take(line);
      waiting_.clear();
    }
    if (!with_faults_ || clock_ < next_fault_) return;
    const auto uniform = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random_);
    };
    Episode episode{.fault = faults[std::uniform_int_distribution<std::size_t>(0, faults.size() - 1)(random_)],
                    .channel = uniform(0.0, 1.0) < 0.5 ? "wheel" : "body",
                    .begin = clock_};
    double length = std::exp(uniform(std::log(1.0), std::log(40.0)));
    if (episode.fault == Fault::late) length = uniform(0.2, 1.5);
    if (episode.fault == Fault::too_late) length = uniform(4.0, 8.0);
    if (episode.fault == Fault::ahead) clock_ += length;
    if (episode.fault == Fault::behind) clock_ -= uniform(1.0, 5.0);
    episode.end = std::max(episode.begin, clock_) + length;
    next_fault_ = episode.end + uniform(70.0, 200.0);
    episodes.push_back(episode);
  }

  [[nodiscard]] double truth_at(double time) const {
    for (auto known = truth_.rbegin(); known != truth_.rend(); ++known)
      if (known->first <= time) return known->second;
    return truth_.front().second;
  }

  void hear(const Json& line) {
    last_ = line;
    const double now = line["t"];
    ++minutes;
    if (line["condition"] == "consistent") {
      ++consistent;
      const auto& k1 = line["parameters"]["strut.k1"];
      if (std::abs(k1["estimate"].get<double>() - truth_at(now)) < 3.0 * k1["std"].get<double>()) ++held;
    }
    for (const auto& event : line["events"]) name(event);
  }

  void name(const Json& event) {
    const double time = event["t"];
    bool explained = false;
    for (auto& episode : episodes) {
      const bool its_channel =
          event["channel"] == episode.channel || event["channel"] == "" || episode.fault > Fault::missing;
      if (time < episode.begin - 0.1 || time > episode.end + settling || !its_channel) continue;
      explained = true;
      if (time <= episode.end + 1.0) episode.named = true;
    }
    if (explained) return;
    ++false_events;
    false_texts.push_back(std::to_string(time) + " s: " + event["text"].get<std::string>());
  }

  Car car_;
  std::mt19937_64 random_;
  bool with_faults_;
  std::unique_ptr<Watcher> watcher_;
  double clock_ = 0.0, next_fault_ = 100.0, settled_ = 0.0;
  std::deque<std::pair<double, double>> truth_;
  std::vector<std::string> waiting_;
  Json last_;
};

TEST(WatchSoak, CountsOnNothingThatTheStreamGives) {
  Soak soak(3, true);
  soak.drive(steps());
  std::map<std::string, std::pair<int, int>> named;  // of how many
  for (const auto& episode : soak.episodes) {
    auto& [yes, all] = named[words[static_cast<std::size_t>(episode.fault)]];
    yes += episode.named ? 1 : 0;
    ++all;
  }
  for (const auto& [fault, counts] : named)
    std::printf("%-24s named %d of %d\n", fault.c_str(), counts.first, counts.second);
  std::printf("%ld minutes, %ld consistent, of these %ld within 3 deviations; %ld events without a cause; %+.2f MB\n",
              soak.minutes, soak.consistent, soak.held, soak.false_events, soak.growth());
  for (const auto& text : soak.false_texts) std::printf("  %s\n", text.c_str());
  std::printf("%s\n", soak.last().dump().c_str());
  EXPECT_GE(static_cast<double>(soak.held), 0.99 * static_cast<double>(soak.consistent) - 1.0);
  EXPECT_GT(soak.consistent, soak.minutes / 2);
  EXPECT_LE(soak.growth(), 1.0);
}

TEST(WatchSoak, NamesNothingInACleanStream) {
  Soak soak(5, false);
  soak.drive(steps());
  EXPECT_EQ(soak.false_events, 0) << (soak.false_texts.empty() ? "" : soak.false_texts.front());
  EXPECT_GE(static_cast<double>(soak.held), 0.99 * static_cast<double>(soak.consistent) - 1.0);
  EXPECT_GE(soak.consistent, soak.minutes - 2);
}

}  // namespace
}  // namespace kalfem::live_case
