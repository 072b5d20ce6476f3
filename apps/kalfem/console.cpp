#include "console.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
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

using Clock = std::chrono::steady_clock;

/// How long a step has run, and how long it will.
class StepClock {
public:
  /// Whether another step has begun.
  bool at(std::string_view step, double fraction) {
    const bool begins = step != step_ || fraction < fraction_;
    if (begins) {
      step_ = step;
      start_ = Clock::now();
    }
    fraction_ = fraction;
    return begins;
  }

  [[nodiscard]] const std::string& step() const { return step_; }
  [[nodiscard]] double elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  [[nodiscard]] double left() const { return elapsed() * (1.0 / fraction_ - 1.0); }  ///< [s]

private:
  std::string step_;
  double fraction_ = 0.0;
  Clock::time_point start_;
};

/// A line on stdout for each tenth of a long step, for files and pipes.
class Lines {
public:
  void show(std::string_view step, double fraction) {
    if (clock_.at(step, fraction)) tenths_ = 0;
    const int tenths = static_cast<int>(10.0 * fraction);
    if (clock_.elapsed() < 5.0 || tenths <= tenths_) return;
    tenths_ = tenths;
    command::print("{}: {} %, {:.0f} s left\n", clock_.step(), 10 * tenths, clock_.left());
  }

private:
  StepClock clock_;
  int tenths_ = 0;
};

/// One line on stderr that is drawn again, ten times a second at most, and wiped at the end of a step.
class Bar {
public:
  ~Bar() { wipe(); }

  void show(std::string_view step, double fraction) {
    if (clock_.at(step, fraction)) wipe();
    if (clock_.elapsed() < 1.0 || fraction <= 0.0 || Clock::now() - drawn_at_ < std::chrono::milliseconds(100)) return;
    constexpr int columns = 32;
    const int filled = static_cast<int>(columns * fraction);
    draw(fmt::format("\r{:<10} [{}{}] {:3.0f} %, {:.0f} s left ", clock_.step(), std::string(filled, '='),
                     std::string(columns - filled, ' '), 100.0 * fraction, clock_.left()));
    drawn_ = true;
    drawn_at_ = Clock::now();
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

  StepClock clock_;
  Clock::time_point drawn_at_ = {};
  bool drawn_ = false;
};

template <class Shown>
Progress shown_by() {
  return [shown = std::make_shared<Shown>()](std::string_view step, double fraction) { shown->show(step, fraction); };
}

std::atomic<bool> asked_to_stop = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal may come at any time");

extern "C" void ask_to_stop(int signal) {
  if (asked_to_stop.exchange(true)) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

}  // namespace

Progress progress_bar(bool in_lines) {
  if (isatty(STDERR_FILENO)) return shown_by<Bar>();
  return in_lines ? shown_by<Lines>() : Progress();
}

void listen_to_signals() {
  for (const int signal : {SIGINT, SIGTERM})
    if (std::signal(signal, ask_to_stop) == SIG_IGN) std::signal(signal, SIG_IGN);
}

const StopQuestion& stop_question() {
  static const StopQuestion question = [] { return asked_to_stop.load(); };
  return question;
}

}  // namespace kalfem::command
