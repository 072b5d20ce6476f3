#include "console.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
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

namespace {

/// One line on stderr that is drawn again and wiped at the end of a step.
class Bar {
public:
  ~Bar() { wipe(); }

  void show(std::string_view outcome, double fraction) {
    const auto now = std::chrono::steady_clock::now();
    if (outcome != outcome_ || fraction < fraction_) {
      wipe();
      outcome_ = outcome;
      start_ = now;
    }
    fraction_ = fraction;
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    if (elapsed < 1.0 || fraction <= 0.0) return;
    constexpr int columns = 32;
    const int filled = static_cast<int>(columns * fraction);
    draw(fmt::format("\r{:<10} [{}{}] {:3.0f} %, {:.0f} s left ", outcome_, std::string(filled, '='),
                     std::string(columns - filled, ' '), 100.0 * fraction, elapsed * (1.0 / fraction - 1.0)));
    drawn_ = true;
  }

private:
  /// A terminal that has gone does not end the run.
  static void draw(const std::string& text) {
    std::fputs(text.c_str(), stderr);
    std::fflush(stderr);
  }

  void wipe() {
    if (drawn_) draw(fmt::format("\r{:72}\r", ""));
    drawn_ = false;
  }

  std::string outcome_;
  double fraction_ = 0.0;
  std::chrono::steady_clock::time_point start_;
  bool drawn_ = false;
};

}  // namespace

Progress progress_bar() {
  if (!isatty(STDERR_FILENO)) return {};
  return [bar = std::make_shared<Bar>()](std::string_view outcome, double fraction) { bar->show(outcome, fraction); };
}

}  // namespace kalfem::command
