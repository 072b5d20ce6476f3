// SPDX-License-Identifier: Apache-2.0
// Messages that nobody should send: none ends a watcher, moves its estimate to no number or lets its memory grow, and
// the good ones between them are used. KALFEM_COUNT: so many; 10,000 without it.
#include <cstdlib>
#include <random>

#include "api/quarter_car.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/watch/message_lines.hpp"
#include "kalfem/watch/watcher.hpp"
#include "live_case.hpp"

namespace kalfem::live_case {
namespace {

int count_of_messages() {
  const char* count = std::getenv("KALFEM_COUNT");
  return count ? std::atoi(count) : 10'000;
}

class Hostile {
public:
  explicit Hostile(unsigned seed) : random_(seed) {}

  std::string topic() {
    const std::vector<std::string> known{"car/wheel", "car/body", "car/road", "car/all"};
    std::string topic = known[below(known.size())];
    if (below(3) == 0) damage(topic);
    if (below(50) == 0) topic = "car/" + std::to_string(random_());
    if (below(200) == 0) topic.assign(below(60'000), 'a');
    return topic;
  }

  std::string payload() {
    std::string text = message();
    const std::size_t changes = below(4);
    for (std::size_t i = 0; i < changes; ++i) damage(text);
    return text;
  }

private:
  std::size_t below(std::size_t bound) { return std::uniform_int_distribution<std::size_t>(0, bound - 1)(random_); }

  std::string number() {
    const std::vector<std::string> odd{"1e308",  "-1e308", "1e999", "NaN", "null",     "\"1\"",
                                       "1e-320", "-0",     "true",  "{}",  "[1, [2]]", "18446744073709551616"};
    if (below(4) == 0) return odd[below(odd.size())];
    return std::to_string(std::normal_distribution<double>(0.0, 10.0)(random_));
  }

  std::string list() {
    std::string text = "[";
    for (std::size_t i = below(30); i > 0; --i) text += number() + (i > 1 ? ", " : "");
    return text + "]";
  }

  std::string message() {
    switch (below(12)) {
      case 0:
        return R"({"t": )" + number() + R"(, "wheel": )" + number() + R"(, "body": )" + list() + "}";
      case 1:
        return R"({"t0": )" + number() + R"(, "dt": )" + number() + R"(, "counter": )" + number() +
               R"(, "unit": "g", "values": )" + list() + "}";
      case 2: {
        std::vector<double> values(below(40));
        for (auto& value : values) value = std::normal_distribution<double>(0.0, 1e3)(random_);
        return binary_block(static_cast<std::uint32_t>(random_()), double(below(100)), 0.002, values);
      }
      case 3:
        return R"({"a": )" + std::string(1 + below(200'000), '[');
      case 4: {
        const std::size_t depth = 1 + below(200'000);
        return R"({"t": 1, "wheel": )" + std::string(depth, '[') + std::string(depth, ']') + "}";
      }
      case 5: {
        std::string text = "{";
        for (std::size_t i = 1 + below(2000); i > 0; --i) text += "\"" + std::to_string(random_()) + "\": 1, ";
        return text + R"("t": 1})";
      }
      case 6:
        return R"({"t": 1, "unit": ")" + std::string(below(5000), 'm') + R"(", "wheel": 1})";
      case 7:
        return std::string(below(100'000), '\0');
      case 8:
        return "t,wheel [g],road\n1,2,3";
      case 9:
        return std::string(StreamLines::longest_line + below(1000), ' ');
      default: {
        std::string noise(below(300), ' ');
        for (auto& byte : noise) byte = static_cast<char>(below(256));
        return noise;
      }
    }
  }

  void damage(std::string& text) {
    if (text.empty()) return;
    const auto place = below(text.size());
    switch (below(4)) {
      case 0:
        text[place] = static_cast<char>(below(256));
        break;
      case 1:
        text.resize(place);
        break;
      case 2:
        text.insert(place, text.substr(0, std::min<std::size_t>(place, 100)));
        break;
      default:
        text.erase(place, 1 + below(5));
    }
  }

  std::mt19937_64 random_;
};

/// What `kalfem watch` does with a message.
struct Listener {
  MessageLines lines;
  long complaints = 0;
  std::string latest;
  Watcher watcher;

  explicit Listener(LivePlan plan)
      : watcher(
            std::move(plan), [this](MessageKind, const std::string& line) { latest = line; },
            [this](const std::string&) { ++complaints; }) {}

  void hear(const std::string& topic, const std::string& payload) {
    try {
      if (const auto line = lines.line_of(topic, payload)) watcher.take(*line);
    } catch (const InvalidInput&) {
      ++complaints;
    }
  }
};

TEST(HostileMessages, EndNothingAndAreForgotten) {
  const ScratchFolder folder("hostile_messages");
  Listener listener(make_live_plan(load_study(written(folder / "live.yaml", live()))));
  Hostile hostile(11);
  const int count = count_of_messages();
  double settled = 0.0;
  for (int i = 0; i < count; ++i) {
    listener.hear(hostile.topic(), hostile.payload());
    if (i == count / 4) settled = resident_megabytes();
  }
  listener.watcher.tell();
  RecordProperty("megabytes_before", std::to_string(settled));
  RecordProperty("megabytes_after", std::to_string(resident_megabytes()));
  EXPECT_LT(resident_megabytes(), settled + 4.0);
  EXPECT_GT(listener.complaints, count / 4);
  const auto told = nlohmann::json::parse(listener.latest);
  for (const auto& [name, parameter] : told["parameters"].items())
    EXPECT_TRUE(parameter["estimate"].is_number()) << name;
}

TEST(HostileMessages, DoNotMoveWhatGoodOnesSay) {
  const ScratchFolder folder("hostile_among_good");
  const auto road = quarter_car::road_of(12.0);
  const Record record = quarter_car::drive(12.0, road);
  const Eigen::VectorXd displacement = road->sample(0.0, 1.0 / quarter_car::rate, record.samples()).col(0).matrix();
  Listener listener(make_live_plan(load_study(written(folder / "live.yaml", live("start: 0 s")))));
  // On topics of channels that the case has not: whoever may write to those of its sensors decides what it sees.
  const std::vector<std::string> others{"car/wheels", "yard/gate", "car/", "$SYS/load", "car/\xff"};
  Hostile hostile(12);
  const Eigen::Index block = 20;
  for (Eigen::Index first = 0; first + block <= record.samples(); first += block) {
    const double time = static_cast<double>(first) / quarter_car::rate;
    const auto values = [&](auto part) { return std::vector<double>(part.begin(), part.end()); };
    const auto counter = static_cast<std::uint32_t>(first / block);
    const auto hear = [&](const std::string& topic, const Eigen::VectorXd& part) {
      listener.hear(topic, binary_block(counter, time, 1.0 / quarter_car::rate, values(part)));
      listener.hear(others[static_cast<std::size_t>(first) % others.size()],
                    binary_block(counter, -time, 1e-9, {1e300, -1e300}));
      listener.hear(others[static_cast<std::size_t>(first) % others.size()], R"({"t": 1e300, "gate": [1e308, "x"]})");
    };
    hear("car/wheel", record.values.row(0).segment(first, block).transpose());
    hear("car/body", record.values.row(1).segment(first, block).transpose());
    hear("car/road", displacement.segment(first, block));
  }
  listener.watcher.tell();
  const auto found = nlohmann::json::parse(listener.latest)["parameters"]["strut.k3"];
  EXPECT_LT(std::abs(found["estimate"].get<double>() - 3e6), 4.0 * found["std"].get<double>());
  EXPECT_LT(found["std"].get<double>(), 1e5);
}

TEST(HostileMessages, OfTooManyTopicsAreRefused) {
  MessageLines lines;
  int refused = 0;
  for (std::uint32_t i = 0; i < 20'000; ++i) try {
      lines.line_of("a/" + std::to_string(i), binary_block(1, 0.0, 0.01, {1.0}));
    } catch (const InvalidInput&) {
      ++refused;
    }
  EXPECT_EQ(refused, 10'000);
}

}  // namespace
}  // namespace kalfem::live_case
