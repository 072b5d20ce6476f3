// SPDX-License-Identifier: Apache-2.0
#include "metrics_port.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <string>

#include "kalfem/watch/stream_source.hpp"

namespace kalfem::command {
namespace {

constexpr int poll_interval = 200;             ///< [ms]
constexpr std::size_t longest_request = 8192;  ///< bytes

bool is_ready(int descriptor, int milliseconds) {
  pollfd asked{descriptor, POLLIN, 0};
  return poll(&asked, 1, milliseconds) > 0;
}

/// The first line of a request, "GET /metrics HTTP/1.1"; what has come of it after a second.
std::string request_line(int client) {
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + std::chrono::seconds(1);
  std::string request;
  while (request.find("\r\n\r\n") == std::string::npos && request.size() < longest_request && Clock::now() < until) {
    if (!is_ready(client, 100)) continue;
    std::array<char, 2048> buffer{};
    const auto count = recv(client, buffer.data(), buffer.size(), 0);
    if (count <= 0) break;
    request.append(buffer.data(), static_cast<std::size_t>(count));
  }
  return request.substr(0, request.find("\r\n"));
}

std::string response(const std::string& status, const std::string& type, const std::string& body) {
  return "HTTP/1.1 " + status + "\r\nContent-Type: " + type + "\r\nContent-Length: " + std::to_string(body.size()) +
         "\r\nConnection: close\r\n\r\n" + body;
}

}  // namespace

MetricsPort::MetricsPort(int port, std::function<std::vector<WatchedHealth>()> cases)
    : cases_(std::move(cases)),
      listener_(open_loopback_port(port)),
      thread_([this](const std::stop_token& stop) { serve(stop); }) {}

MetricsPort::~MetricsPort() {
  thread_.request_stop();
  thread_.join();
  close(listener_);
}

void MetricsPort::serve(const std::stop_token& stop) const {
  while (!stop.stop_requested()) {
    if (!is_ready(listener_, poll_interval)) continue;
    const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) continue;
    answer(client);
    close(client);
  }
}

void MetricsPort::answer(int client) const {
  const std::string line = request_line(client);
  const auto asks = [&](const std::string& path) {
    return line.starts_with("GET " + path + " ") || line.starts_with("GET " + path + "?");
  };
  std::string text = response("404 Not Found", "text/plain", "there are /metrics and /health\n");
  if (asks("/metrics")) text = response("200 OK", "text/plain; version=0.0.4; charset=utf-8", metrics_text(cases_()));
  if (asks("/health")) {
    const auto cases = cases_();
    text = response(is_healthy(cases) ? "200 OK" : "503 Service Unavailable", "application/json", health_text(cases));
  }
  for (std::size_t sent = 0; sent < text.size();) {
    const auto count = send(client, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
    if (count <= 0) return;
    sent += static_cast<std::size_t>(count);
  }
}

}  // namespace kalfem::command
