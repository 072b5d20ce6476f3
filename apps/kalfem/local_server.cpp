// SPDX-License-Identifier: Apache-2.0
#include "local_server.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <list>
#include <string>

#include "kalfem/page/live_page.hpp"
#include "kalfem/watch/stream_source.hpp"

namespace kalfem::command {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int poll_interval = 100;                  ///< [ms]
constexpr std::size_t longest_request = 8192;       ///< bytes
constexpr std::size_t piece = 1 << 20;              ///< of messages, that are on their way to a client [bytes]
constexpr std::size_t most_clients = 64;            ///< at once; others wait
constexpr auto patience = std::chrono::seconds(2);  ///< with a request that is not whole
constexpr auto patience_with_readers = std::chrono::seconds(30);  ///< that take nothing
constexpr auto sign_of_life = std::chrono::seconds(15);           ///< to a page, where there is no message

bool asks(const std::string& request, const std::string& path) {
  return request.starts_with("GET " + path + " ") || request.starts_with("GET " + path + "?");
}

/// The host that a request names, without its port, in small letters; empty where it names none.
std::string host_of(std::string request) {
  std::ranges::transform(request, request.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  const auto found = request.find("\r\nhost:");
  if (found == std::string::npos) return "";
  const auto begin = request.find_first_not_of(' ', found + 7);
  const std::string host = request.substr(begin, request.find('\r', begin) - begin);
  return host.substr(0, host.starts_with('[') ? host.find(']') + 1 : host.find(':'));
}

bool names_this_computer(const std::string& request) {
  constexpr std::array<std::string_view, 4> names{"", "localhost", "127.0.0.1", "[::1]"};
  return std::ranges::find(names, host_of(request)) != names.end();
}

std::string response(const std::string& status, const std::string& type, const std::string& body) {
  return "HTTP/1.1 " + status + "\r\nContent-Type: " + type + "\r\nContent-Length: " + std::to_string(body.size()) +
         "\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n" + body;
}

constexpr const char* beginning_of_events =
    "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n"
    "retry: 1000\n\n";

}  // namespace

/// A connection: takes a request, sends the answer, and follows the messages where they were asked for.
class LocalServer::Client {
public:
  explicit Client(int descriptor) : descriptor_(descriptor) {}
  ~Client() { close(descriptor_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  [[nodiscard]] pollfd question() const {
    return {descriptor_, short(waiting_.empty() ? POLLIN : POLLIN | POLLOUT), 0};
  }

  /// What can be done without waiting; false once it is done with or the client has gone.
  bool work(const LocalServer& server) {
    if (!take()) return false;
    if (!answered_ && !is_whole()) return Clock::now() - since_ < patience;
    if (!answered_) answer(server);
    if (follows_ && waiting_.empty()) follow(*server.messages_);
    return send_waiting() && (follows_ || !waiting_.empty());
  }

private:
  [[nodiscard]] bool is_whole() const {
    return request_.find("\r\n\r\n") != std::string::npos || request_.size() >= longest_request;
  }

  /// What has come; false where the client has gone.
  bool take() {
    std::array<char, 2048> buffer{};
    const auto count = recv(descriptor_, buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (count < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    if (!answered_) request_.append(buffer.data(), static_cast<std::size_t>(count));
    return count > 0 || (answered_ && !follows_);
  }

  void answer(const LocalServer& server) {
    answered_ = true;
    follows_ = server.messages_ && asks(request_, "/events") && names_this_computer(request_);
    waiting_ = follows_ ? beginning_of_events : server.answer(request_);
  }

  void follow(const MessageHistory& messages) {
    waiting_ = messages.events_after(seen_, piece);
    if (waiting_.empty() && Clock::now() - since_ > sign_of_life) waiting_ = ":\n\n";
  }

  /// False where the client has gone.
  bool send_waiting() {
    while (!waiting_.empty()) {
      const auto count = send(descriptor_, waiting_.data(), waiting_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      const bool is_full = count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR);
      if (count <= 0) return is_full && Clock::now() - since_ < patience_with_readers;
      waiting_.erase(0, static_cast<std::size_t>(count));
      since_ = Clock::now();
    }
    return true;
  }

  int descriptor_;
  std::string request_, waiting_;
  bool answered_ = false, follows_ = false;
  std::int64_t seen_ = 0;                   ///< of the messages
  Clock::time_point since_ = Clock::now();  ///< it came, or the latest bytes went
};

LocalServer::LocalServer(int port, std::function<std::vector<WatchedHealth>()> cases, const MessageHistory* messages)
    : cases_(std::move(cases)),
      messages_(messages),
      listener_(open_loopback_port(port)),
      thread_([this](const std::stop_token& stop) { serve(stop); }) {}

LocalServer::~LocalServer() {
  thread_.request_stop();
  thread_.join();
  close(listener_);
}

void LocalServer::serve(const std::stop_token& stop) const {
  std::list<Client> clients;
  while (!stop.stop_requested()) {
    std::vector<pollfd> questions;
    for (const auto& client : clients) questions.push_back(client.question());
    if (clients.size() < most_clients) questions.push_back({listener_, POLLIN, 0});
    poll(questions.data(), questions.size(), poll_interval);
    if (questions.back().fd == listener_ && questions.back().revents != 0)
      if (const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC); client >= 0)
        clients.emplace_back(client);
    clients.remove_if([this](Client& client) { return !client.work(*this); });
  }
}

std::string LocalServer::answer(const std::string& request) const {
  if (asks(request, "/metrics"))
    return response("200 OK", "text/plain; version=0.0.4; charset=utf-8", metrics_text(cases_()));
  if (asks(request, "/health")) {
    const auto cases = cases_();
    return response(is_healthy(cases) ? "200 OK" : "503 Service Unavailable", "application/json", health_text(cases));
  }
  if (messages_ && !names_this_computer(request))
    return response("403 Forbidden", "text/plain", "the page is told to localhost and 127.0.0.1 alone\n");
  if (messages_ && asks(request, "/")) return response("200 OK", "text/html; charset=utf-8", live_page());
  return response("404 Not Found", "text/plain",
                  messages_ ? "there are /, /events, /metrics and /health\n" : "there are /metrics and /health\n");
}

}  // namespace kalfem::command
