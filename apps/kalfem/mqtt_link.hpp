// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kalfem/study/mqtt_options.hpp"

namespace kalfem::command {

struct MqttMessage {
  std::string topic, payload;
};

/// What happens to a message that cannot go out because the broker is away.
enum class Delivery {
  latest,  ///< the latest of its topic is sent once the broker is back; the broker retains it
  every    ///< each is sent once the broker is back
};

/// A connection to a broker: quality of service 1 both ways, and a session that the broker keeps, so that it holds what
/// comes while nobody listens. A broker that is away is told once, tried again every second, and told once when it is
/// back; a topic without a message is told once. All work is done in work(), in the caller's thread.
class MqttLink {
public:
  using Tell = std::function<void(const std::string&)>;
  virtual ~MqttLink() = default;
  /// Moves data both ways, and waits for it for so long at most.
  virtual void work(int milliseconds) = 0;
  virtual void publish(const std::string& topic, const std::string& payload, Delivery delivery) = 0;
  /// Messages that have come.
  virtual std::vector<MqttMessage> take() = 0;
  /// Waits until everything has gone out, for so long at most. Whether it has.
  virtual bool finish(int milliseconds) = 0;
};

/// `client`: name of the session where the options give none. `will`: topic that gets "offline", retained, when the
/// process dies, and "online" after each connection; empty: none. Throws InvalidInput where a file of the options
/// cannot be used, and in a program that was built without libmosquitto.
std::unique_ptr<MqttLink> make_mqtt_link(const MqttOptions& options, const std::string& client, const std::string& will,
                                         MqttLink::Tell tell);

}  // namespace kalfem::command
