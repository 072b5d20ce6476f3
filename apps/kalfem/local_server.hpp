// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <thread>
#include <vector>

#include "kalfem/watch/message_history.hpp"
#include "kalfem/watch/metrics_text.hpp"

namespace kalfem::command {

/// Tells what is watched by HTTP at a TCP port of this computer (127.0.0.1), from a thread of its own: GET /metrics for
/// Prometheus, GET /health with the status 200, or 503 where a case is not healthy; with messages also the page that
/// shows them (/), and the messages as they come (/events). It only tells: what a client sends changes nothing. The
/// page is given to clients that name this computer as their host, so that no other site can read it through a browser.
class LocalServer {
public:
  /// `cases`: asked from the server's thread. `messages`: null for no page. Throws InvalidInput where the port is
  /// taken.
  LocalServer(int port, std::function<std::vector<WatchedHealth>()> cases, const MessageHistory* messages);
  ~LocalServer();
  LocalServer(const LocalServer&) = delete;
  LocalServer& operator=(const LocalServer&) = delete;

private:
  class Client;

  void serve(const std::stop_token& stop) const;
  [[nodiscard]] std::string answer(const std::string& request) const;

  std::function<std::vector<WatchedHealth>()> cases_;
  const MessageHistory* messages_;
  int listener_;
  std::jthread thread_;
};

}  // namespace kalfem::command
