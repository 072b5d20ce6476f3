// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/invalid_input.hpp"
#include "mqtt_link.hpp"

namespace kalfem::command {

std::unique_ptr<MqttLink> make_mqtt_link(const MqttOptions&, const std::string&, const std::string&, MqttLink::Tell) {
  throw InvalidInput("this kalfem speaks no MQTT", "libmosquitto was not there when it was built",
                     "install libmosquitto-dev (scripts/setup does) and build again");
}

}  // namespace kalfem::command
