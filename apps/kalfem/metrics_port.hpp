// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <thread>
#include <vector>

#include "kalfem/watch/metrics_text.hpp"

namespace kalfem::command {

/// Tells metrics and health by HTTP at a TCP port of this computer (127.0.0.1), from a thread of its own: GET /metrics
/// for Prometheus, GET /health with the status 200, or 503 where a case is not healthy.
class MetricsPort {
public:
  /// Throws InvalidInput where the port is taken.
  MetricsPort(int port, std::function<std::vector<WatchedHealth>()> cases);
  ~MetricsPort();
  MetricsPort(const MetricsPort&) = delete;
  MetricsPort& operator=(const MetricsPort&) = delete;

private:
  void serve(const std::stop_token& stop) const;
  void answer(int client) const;

  std::function<std::vector<WatchedHealth>()> cases_;
  int listener_;
  std::jthread thread_;
};

}  // namespace kalfem::command
