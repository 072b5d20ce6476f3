#include "console.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <string>
#include <system_error>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/text.hpp"

namespace kalfem::command {
namespace {

int output_error = 0;  ///< the first that stdout reported

/// Error code of writing all of the text, 0 for success.
int write_all(std::FILE* stream, const std::string& text) {
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stream) == text.size() && std::fflush(stream) == 0;
  return written ? 0 : errno != 0 ? errno : EIO;
}

}  // namespace

void prepare_streams() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) >= 0) continue;
    // The lowest free number is given, that of the stream. What cannot be written to tells of itself.
    if (open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY) < 0) return;
  }
}

void print_text(std::string_view text) {
  if (const int code = write_all(stdout, terminal_safe(text)); output_error == 0) output_error = code;
}

void print_error_text(std::string_view text) {
  static_cast<void>(write_all(stderr, terminal_safe(text)));  // there is nowhere to say it
}

void require_output() {
  if (output_error == 0 || output_error == EPIPE) return;
  if (output_error == EBADF)
    throw WriteFailure("cannot write to the standard output", "it is closed",
                       "open it, or discard the text by >/dev/null");
  throw WriteFailure("cannot write to the standard output", std::generic_category().message(output_error),
                     "redirect it to another place");
}

}  // namespace kalfem::command
