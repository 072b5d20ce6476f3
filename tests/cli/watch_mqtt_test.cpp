// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "background.hpp"
#include "base/absent.hpp"
#include "command.hpp"
#include "watch/live_case.hpp"

namespace kalfem::test {
namespace {

using namespace live_case;
using Json = nlohmann::json;

/// A broker of its own on a free port, with a session store, and a case that reads from it.
struct WatchMqtt : testing::Test {
  void SetUp() override {
    if (std::system("command -v mosquitto mosquitto_sub mosquitto_pub >/dev/null") != 0)
      KALFEM_ABSENT("mosquitto and mosquitto-clients are not installed");
    if (run_command("play nothing.yaml --mqtt localhost/x", folder).errors.find("speaks no MQTT") != std::string::npos)
      KALFEM_ABSENT("this kalfem was built without libmosquitto");
    written(folder / "broker.conf", "listener " + std::to_string(port) + " 127.0.0.1\nallow_anonymous true\n" +
                                        "persistence true\npersistence_location " + folder.path().string() +
                                        "/\nmax_queued_messages 0\nuser root\n");
    drive = written(folder / "drive.yaml", simulated(12.0));
    watch = written(folder / "watch.yaml", live("mqtt: {broker: 127.0.0.1, port: " + std::to_string(port) +
                                                ", topics: [car/samples], publish: kalfem/car}"));
  }
  void start_broker() {
    broker.emplace("mosquitto -c " + (folder / "broker.conf").string() + " >>" + (folder / "broker.txt").string() +
                   " 2>&1");
  }
  void start_watch(const std::string& more = "") {
    watching.emplace(command_file() + " watch " + watch + " " + more + " >>" + out().string() + " 2>>" +
                     err().string());
  }
  [[nodiscard]] std::filesystem::path out() const { return folder / "out.jsonl"; }
  [[nodiscard]] std::filesystem::path err() const { return folder / "err.txt"; }
  [[nodiscard]] std::string place() const { return "127.0.0.1:" + std::to_string(port) + "/car/samples"; }
  [[nodiscard]] bool told(const std::string& text) const { return read(err()).find(text) != std::string::npos; }
  [[nodiscard]] Json last() const {
    const std::string text = read(out());
    const auto end = text.find_last_of('\n');
    if (end == std::string::npos || end == 0) return {};
    const auto begin = text.find_last_of('\n', end - 1);
    return Json::parse(text.substr(begin == std::string::npos ? 0 : begin + 1, end));
  }
  [[nodiscard]] std::string retained(const std::string& topic) const {
    const auto file = folder / "retained.txt";
    static_cast<void>(std::system(("mosquitto_sub -h 127.0.0.1 -p " + std::to_string(port) + " -t " + topic +
                                   " -C 1 -W 5 >" + file.string() + " 2>&1")
                                      .c_str()));
    return read(file);
  }
  [[nodiscard]] bool has_taken(int samples) const {
    const Json line = last();
    return line.is_object() && line["samples"].get<int>() >= samples;
  }

  ScratchFolder folder{"watch_mqtt"};
  int port = free_port();
  std::string drive, watch;
  std::optional<Background> broker, watching;
};

TEST_F(WatchMqtt, ReadsFromABrokerAndPublishesRetainedEstimates) {
  start_broker();
  start_watch();
  ASSERT_TRUE(comes_true([&] { return retained("kalfem/car/status") == "online\n"; })) << read(err());
  const auto played = run_command("play " + drive + " --speed 0 --mqtt " + place(), folder);
  ASSERT_EQ(played.code, 0) << played.errors;
  ASSERT_TRUE(comes_true([&] { return has_taken(5500); })) << read(err());
  EXPECT_EQ(watching->end(SIGTERM), 0);
  const auto found = last()["parameters"]["strut.k3"];
  EXPECT_LT(std::abs(found["estimate"].get<double>() - 3e6), 4.0 * found["std"].get<double>());
  EXPECT_EQ(Json::parse(retained("kalfem/car/estimates")), last());
  EXPECT_EQ(Json::parse(retained("kalfem/car/verdict"))["condition"], last()["condition"]);
  EXPECT_EQ(retained("kalfem/car/status"), "offline\n");
}

TEST_F(WatchMqtt, WaitsForABrokerAndComesBackToIt) {
  start_watch();
  ASSERT_TRUE(comes_true([&] { return told("cannot be reached"); })) << read(err());
  start_broker();
  ASSERT_TRUE(comes_true([&] { return told("connected to the broker"); })) << read(err());
  ASSERT_EQ(run_command("play " + drive + " --speed 0 --set simulate.duration=4s --mqtt " + place(), folder).code, 0);
  ASSERT_TRUE(comes_true([&] { return has_taken(1500); })) << read(err());
  broker->end(SIGKILL);
  std::this_thread::sleep_for(std::chrono::seconds(3));
  start_broker();
  const auto count = [&](const std::string& text) {
    int times = 0;
    const std::string all = read(err());
    for (std::size_t at = all.find(text); at != std::string::npos; at = all.find(text, at + 1)) ++times;
    return times;
  };
  ASSERT_TRUE(comes_true([&] { return count("connected to the broker") == 2; })) << read(err());
  EXPECT_EQ(count("cannot be reached"), 2);
  ASSERT_EQ(run_command("play " + drive + " --speed 0 --mqtt " + place(), folder).code, 0);
  EXPECT_TRUE(comes_true([&] { return has_taken(5500); })) << read(err());
}

/// What comes while nobody watches is kept by the broker for the session.
TEST_F(WatchMqtt, GetsWhatCameWhileItWasAway) {
  start_broker();
  start_watch();
  ASSERT_TRUE(comes_true([&] { return retained("kalfem/car/status") == "online\n"; }));
  EXPECT_EQ(watching->end(SIGTERM), 0);
  ASSERT_EQ(run_command("play " + drive + " --speed 0 --mqtt " + place(), folder).code, 0);
  start_watch();
  EXPECT_TRUE(comes_true([&] { return has_taken(5500); })) << read(err());
}

TEST_F(WatchMqtt, TellsASilentTopicAndAWrongUnitOnceAndGoesOn) {
  start_broker();
  start_watch();
  ASSERT_TRUE(comes_true([&] { return told("no message has come on the topic 'car/samples'"); })) << read(err());
  const auto publish = [&](const std::string& payload) {
    return std::system(
        ("mosquitto_pub -q 1 -h 127.0.0.1 -p " + std::to_string(port) + " -t car/samples -m '" + payload + "'")
            .c_str());
  };
  for (int k = 0; k < 3; ++k) ASSERT_EQ(publish(R"({"t": 0, "unit": "kg", "wheel": [1, 2]})"), 0);
  ASSERT_TRUE(comes_true([&] { return told("'wheel' comes in 'kg'"); })) << read(err());
  ASSERT_EQ(publish("nonsense"), 0);
  ASSERT_TRUE(comes_true([&] { return told("neither a JSON object nor a binary block"); })) << read(err());
  const std::string all = read(err());
  EXPECT_EQ(all.find("comes in 'kg'"), all.rfind("comes in 'kg'"));
  EXPECT_EQ(watching->end(SIGTERM), 0);
}

}  // namespace
}  // namespace kalfem::test
