// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/stream_source.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "kalfem/base/atomic_file.hpp"

namespace kalfem {
namespace {

std::string words_of(int code) { return std::generic_category().message(code); }

/// Whether there is something to read.
bool is_ready(int descriptor, int milliseconds) {
  pollfd asked{descriptor, POLLIN, 0};
  return poll(&asked, 1, milliseconds) > 0;
}

/// Bytes that are there: none at the end, nothing where the descriptor fails.
long read_some(int descriptor, std::string& bytes) {
  std::array<char, 65536> buffer{};
  const auto count = ::read(descriptor, buffer.data(), buffer.size());
  if (count > 0) bytes.append(buffer.data(), static_cast<std::size_t>(count));
  return count;
}

}  // namespace

void LineCutter::add(std::string_view bytes, std::size_t longest,
                     const std::function<void(std::string_view)>& on_line) {
  while (!bytes.empty()) {
    const auto end = bytes.find('\n');
    const auto piece = bytes.substr(0, end);
    if (!too_long_) line_.append(piece.substr(0, longest + 1 - std::min(line_.size(), longest + 1)));
    too_long_ = too_long_ || line_.size() > longest;
    if (end == std::string_view::npos) return;
    on_line(line_);
    line_.clear();
    too_long_ = false;
    bytes.remove_prefix(end + 1);
  }
}

std::string LineCutter::take_rest() {
  too_long_ = false;
  return std::exchange(line_, {});
}

StreamSource::State DescriptorSource::read(int milliseconds, std::string& bytes) {
  if (!is_ready(descriptor_, milliseconds)) return State::waits;
  const long count = read_some(descriptor_, bytes);
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return State::waits;
  return count > 0 ? State::gave : State::ended;
}

int open_loopback_port(int port) {
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int yes = 1;
  setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (listener >= 0 && bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      listen(listener, 4) == 0)
    return listener;
  const int code = errno;
  if (listener >= 0) close(listener);
  throw InvalidInput("port " + std::to_string(port) + " cannot be opened on 127.0.0.1", words_of(code),
                     "give another one");
}

PortSource::PortSource(int port) : listener_(open_loopback_port(port)) {}

PortSource::~PortSource() {
  if (sender_ >= 0) close(sender_);
  close(listener_);
}

StreamSource::State PortSource::read(int milliseconds, std::string& bytes) {
  if (sender_ < 0) {
    if (is_ready(listener_, milliseconds)) sender_ = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    return State::waits;
  }
  if (!is_ready(sender_, milliseconds)) return State::waits;
  const long count = read_some(sender_, bytes);
  if (count > 0) return State::gave;
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return State::waits;
  close(sender_);
  sender_ = -1;
  bytes += "\n";  // what it began is no line of the next sender's
  return State::gave;
}

StreamLog::StreamLog(const std::filesystem::path& file)
    : file_(file), descriptor_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) fail_to_write(file, errno);
  size_ = lseek(descriptor_, 0, SEEK_END);
  char last = '\n';
  while (size_ > 0 && pread(descriptor_, &last, 1, size_ - 1) == 1 && last != '\n') --size_;  // a line that was cut off
  if (ftruncate(descriptor_, size_) != 0 || lseek(descriptor_, size_, SEEK_SET) < 0) {
    const int code = errno;
    close(descriptor_);
    fail_to_write(file, code);
  }
}

StreamLog::~StreamLog() {
  if (descriptor_ >= 0) close(descriptor_);
}

void StreamLog::add(std::string_view line) {
  const std::string whole = std::string(line) + "\n";
  const auto written = write(descriptor_, whole.data(), whole.size());
  if (written == std::ssize(whole)) {
    size_ += written;
    return;
  }
  const int code = written < 0 ? errno : ENOSPC;
  if (ftruncate(descriptor_, size_) == 0) lseek(descriptor_, size_, SEEK_SET);
  fail_to_write(file_, code);
}

}  // namespace kalfem
