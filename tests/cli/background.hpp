// SPDX-License-Identifier: Apache-2.0
// Programs that run beside a test.
#pragma once

#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>

namespace kalfem::test {

/// A port of TCP on the loopback that is free.
inline int free_port() {
  const int probe = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (bind(probe, reinterpret_cast<sockaddr*>(&address), size) != 0) return 0;
  getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size);
  close(probe);
  return ntohs(address.sin_port);
}

/// Waits up to half a minute.
inline bool comes_true(const std::function<bool()>& question) {
  for (int wait = 0; wait < 300; ++wait) {
    if (question()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return question();
}

/// A line of the shell, ended at the end of the test.
class Background {
public:
  explicit Background(const std::string& line) : child_(fork()) {
    if (child_ != 0) return;
    const std::string exec = "exec " + line;
    execl("/bin/sh", "sh", "-c", exec.c_str(), nullptr);
    _exit(127);
  }
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;
  ~Background() { end(SIGTERM); }

  /// Its exit code; -1 where a signal ended it or it had ended before.
  int end(int signal) {
    if (child_ <= 0) return -1;
    kill(child_, signal);
    return wait();
  }
  int wait() {
    int status = 0;
    waitpid(child_, &status, 0);
    child_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

private:
  pid_t child_;
};

}  // namespace kalfem::test
