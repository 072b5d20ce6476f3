// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kalfem {

/// A broker of MQTT, what is read from it and where estimates go.
struct MqttOptions {
  std::string broker = "localhost";
  std::optional<int> port = {};          ///< empty: 1883, with `authority` 8883
  std::string client;                    ///< name by which the broker keeps the session; empty: after the case
  std::vector<std::string> topics = {};  ///< filters of what is read; none: samples come from elsewhere
  std::string publish;                   ///< topic under which estimates, verdict and alarms go out; empty: they do not
  std::filesystem::path login;           ///< file with the user in its first line and the password in its second
  std::filesystem::path authority;       ///< certificates that the broker's must be signed by: TLS
  std::filesystem::path certificate, key;  ///< of the client, where the broker asks for them
};

}  // namespace kalfem
