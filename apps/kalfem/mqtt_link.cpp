// SPDX-License-Identifier: Apache-2.0
#include "mqtt_link.hpp"

#include <mosquitto.h>

#include <cerrno>
#include <chrono>
#include <deque>
#include <fstream>
#include <map>
#include <system_error>
#include <thread>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem::command {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr int once_at_least = 1;  ///< quality of service
constexpr int keep_alive = 60;    ///< [s]
constexpr auto retry_interval = std::chrono::seconds(1);
constexpr auto patience = std::chrono::seconds(10);  ///< for the first message of a topic
constexpr std::size_t most_waiting = 10'000;         ///< messages that wait for the broker
constexpr std::size_t most_at_once = 1000;           ///< messages that one work() takes

struct Library {
  Library() { mosquitto_lib_init(); }
  ~Library() { mosquitto_lib_cleanup(); }
};

struct Free {
  void operator()(mosquitto* client) const { mosquitto_destroy(client); }
};

std::string words_of(int code) {
  return code == MOSQ_ERR_ERRNO ? std::generic_category().message(errno) : mosquitto_strerror(code);
}

/// A topic that is read, and whether it has given anything.
struct ReadTopic {
  std::string filter;
  bool heard = false, told = false;
};

class MosquittoLink final : public MqttLink {
public:
  MosquittoLink(const MqttOptions& options, const std::string& client, std::string will, Tell tell)
      : options_(options),
        place_(options.broker + ":" + std::to_string(options.port.value_or(options.authority.empty() ? 1883 : 8883))),
        will_(std::move(will)),
        tell_(std::move(tell)) {
    static const Library library;
    const std::string name = options.client.empty() ? client : options.client;
    client_.reset(mosquitto_new(name.c_str(), false, this));
    if (!client_) throw InvalidInput("no client '" + name + "' of MQTT can be made", words_of(MOSQ_ERR_ERRNO), "");
    for (const auto& filter : options.topics) {
      if (mosquitto_sub_topic_check(filter.c_str()) != MOSQ_ERR_SUCCESS)
        throw InvalidInput("mqtt.topics: '" + filter + "' is no topic", "+ stands for a level, # for the last ones",
                           "");
      topics_.push_back({filter});
    }
    mosquitto_int_option(client_.get(), MOSQ_OPT_TCP_NODELAY, 1);  // otherwise small messages wait for acknowledgements
    identify();
    if (!will_.empty()) mosquitto_will_set(client_.get(), will_.c_str(), 7, "offline", once_at_least, true);
    mosquitto_connect_callback_set(
        client_.get(), [](mosquitto*, void* self, int code) { static_cast<MosquittoLink*>(self)->connected(code); });
    mosquitto_message_callback_set(client_.get(), [](mosquitto*, void* self, const mosquitto_message* message) {
      static_cast<MosquittoLink*>(self)->take_in(*message);
    });
    mosquitto_publish_callback_set(
        client_.get(), [](mosquitto*, void* self, int) { --static_cast<MosquittoLink*>(self)->in_flight_; });
    mosquitto_subscribe_callback_set(client_.get(), [](mosquitto*, void* self, int, int count, const int* granted) {
      for (int i = 0; i < count; ++i)
        if (granted[i] >= 128)
          static_cast<MosquittoLink*>(self)->tell_("the broker refuses a topic: it may not be read");
    });
  }

  ~MosquittoLink() override {
    if (!is_connected_) return;
    if (!will_.empty()) send(will_, "offline", true);
    finish(500);
    mosquitto_disconnect(client_.get());
  }

  void work(int wait) override {
    const auto until = Clock::now() + milliseconds(wait);
    if (!begun_ || has_gone_) connect_when_due(wait);
    if (begun_ && !has_gone_) {
      lose_unless_good(mosquitto_loop(client_.get(), wait, 1));
      for (std::size_t before = 0; !has_gone_ && came_.size() > before && came_.size() < most_at_once;) {
        before = came_.size();
        lose_unless_good(mosquitto_loop(client_.get(), 0, 1));
      }
    } else if (const auto rest = until - Clock::now(); rest > Clock::duration::zero()) {
      std::this_thread::sleep_for(rest);
    }
    tell_silent_topics();
  }

  void publish(const std::string& topic, const std::string& payload, Delivery delivery) override {
    if (is_connected_) {
      send(topic, payload, delivery == Delivery::latest);
    } else if (delivery == Delivery::latest) {
      latest_[topic] = payload;
    } else {
      waiting_.push_back({topic, payload});
      if (waiting_.size() > most_waiting) waiting_.pop_front();
    }
  }

  std::vector<MqttMessage> take() override { return std::exchange(came_, {}); }

  bool finish(int wait) override {
    const auto until = Clock::now() + milliseconds(wait);
    while ((in_flight_ > 0 || !is_connected_ || !waiting_.empty()) && Clock::now() < until) work(20);
    return in_flight_ == 0 && waiting_.empty();
  }

private:
  /// User, password and certificates, by their files.
  void identify() {
    if (!options_.login.empty()) {
      std::ifstream file(options_.login);
      std::string user, password;
      if (!std::getline(file, user) || user.empty() || !std::getline(file, password))
        throw InvalidInput("mqtt.login: " + options_.login.string() + " holds no user and password", "",
                           "write the user in its first line and the password in its second");
      mosquitto_username_pw_set(client_.get(), user.c_str(), password.c_str());
    }
    if (options_.authority.empty()) return;
    const auto or_null = [](const std::filesystem::path& file) { return file.empty() ? nullptr : file.c_str(); };
    const int code =
        mosquitto_tls_set(client_.get(), options_.authority.c_str(), nullptr, or_null(options_.certificate),
                          or_null(options_.key), [](char*, int, int, void*) { return 0; });
    if (code != MOSQ_ERR_SUCCESS)
      throw InvalidInput("the certificates of mqtt cannot be used", words_of(code),
                         "give files in PEM, and a key without a password");
  }

  void connect_when_due(int wait) {
    if (Clock::now() < next_try_) {
      std::this_thread::sleep_for(std::min<Clock::duration>(milliseconds(wait), next_try_ - Clock::now()));
      return;
    }
    next_try_ = Clock::now() + retry_interval;
    const int port = options_.port.value_or(options_.authority.empty() ? 1883 : 8883);
    const int code = begun_ ? mosquitto_reconnect_async(client_.get())
                            : mosquitto_connect_async(client_.get(), options_.broker.c_str(), port, keep_alive);
    has_gone_ = code != MOSQ_ERR_SUCCESS;
    begun_ = begun_ || !has_gone_;
    if (has_gone_) tell_away(words_of(code));
  }

  void connected(int code) {
    if (code != 0) {
      tell_away(mosquitto_connack_string(code));
      return;
    }
    if (told_away_) tell_("connected to the broker " + place_);
    told_away_ = false;
    is_connected_ = true;
    connected_at_ = Clock::now();
    for (const auto& topic : topics_) mosquitto_subscribe(client_.get(), nullptr, topic.filter.c_str(), once_at_least);
    if (!will_.empty()) send(will_, "online", true);
    for (const auto& [topic, payload] : std::exchange(latest_, {})) send(topic, payload, true);
    for (const auto& message : std::exchange(waiting_, {})) send(message.topic, message.payload, false);
  }

  void lose_unless_good(int code) {
    if (code == MOSQ_ERR_SUCCESS) return;
    has_gone_ = true;
    is_connected_ = false;
    next_try_ = Clock::now() + retry_interval;
    tell_away(words_of(code));
  }

  void tell_away(const std::string& why) {
    if (!told_away_) tell_("the broker " + place_ + " cannot be reached: " + why + "; it goes on trying");
    told_away_ = true;
  }

  void take_in(const mosquitto_message& message) {
    for (auto& topic : topics_) {
      bool matches = false;
      mosquitto_topic_matches_sub(topic.filter.c_str(), message.topic, &matches);
      topic.heard = topic.heard || matches;
    }
    came_.push_back({message.topic, std::string(static_cast<const char*>(message.payload),
                                                static_cast<std::size_t>(message.payloadlen))});
  }

  void tell_silent_topics() {
    if (!is_connected_ || Clock::now() - connected_at_ < patience) return;
    for (auto& topic : topics_)
      if (!topic.heard && !std::exchange(topic.told, true))
        tell_("no message has come on the topic '" + topic.filter + "' for " +
              std::to_string(std::chrono::seconds(patience).count()) + " s; it goes on waiting");
  }

  void send(const std::string& topic, const std::string& payload, bool retain) {
    const int code = mosquitto_publish(client_.get(), nullptr, topic.c_str(), static_cast<int>(payload.size()),
                                       payload.data(), once_at_least, retain);
    if (code == MOSQ_ERR_SUCCESS || code == MOSQ_ERR_NO_CONN) ++in_flight_;
  }

  MqttOptions options_;
  std::string place_, will_;
  Tell tell_;
  std::unique_ptr<mosquitto, Free> client_;
  std::vector<ReadTopic> topics_;
  std::vector<MqttMessage> came_;
  std::map<std::string, std::string> latest_;  ///< payloads that wait for the broker, by topic
  std::deque<MqttMessage> waiting_;
  long in_flight_ = 0;  ///< messages that the broker has not acknowledged
  bool begun_ = false, has_gone_ = false, is_connected_ = false, told_away_ = false;
  Clock::time_point next_try_{}, connected_at_{};
};

}  // namespace

std::unique_ptr<MqttLink> make_mqtt_link(const MqttOptions& options, const std::string& client, const std::string& will,
                                         MqttLink::Tell tell) {
  return std::make_unique<MosquittoLink>(options, client, will, std::move(tell));
}

}  // namespace kalfem::command
