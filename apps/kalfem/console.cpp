// SPDX-License-Identifier: Apache-2.0
#include "console.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
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

namespace {

bool bar_is_drawn = false;

/// Other output begins on an empty line.
void wipe_bar() {
  if (!bar_is_drawn) return;
  std::fputs("\r\x1b[K", stderr);
  std::fflush(stderr);
  bar_is_drawn = false;
}

/// Text without control characters of others.
void print_safe(const std::string& text) {
  wipe_bar();
  if (const int code = write_all(stdout, text); output_error == 0) output_error = code;
}

}  // namespace

bool is_read_on_terminal() { return isatty(STDOUT_FILENO) == 1; }
void print_text(std::string_view text) { print_safe(terminal_safe(text)); }

void print_error_text(std::string_view text) {
  wipe_bar();
  static_cast<void>(write_all(stderr, terminal_safe(text)));  // there is nowhere to say it
}

bool reader_has_gone() { return output_error == EPIPE; }

void require_output() {
  if (output_error == 0 || output_error == EPIPE) return;
  if (output_error == EBADF)
    throw WriteFailure("cannot write to the standard output", "it is closed",
                       "open it, or discard the text by >/dev/null");
  throw WriteFailure("cannot write to the standard output", std::generic_category().message(output_error),
                     "redirect it to another place");
}

namespace {

/// The program draws on a terminal in colours unless the user objects, see no-color.org.
bool draws_in_colour() {
  static const bool answer = [] {
    const char *objection = std::getenv("NO_COLOR"), *terminal = std::getenv("TERM");
    const bool objects = objection != nullptr && *objection != 0;
    const bool can = terminal != nullptr && std::string_view(terminal) != "dumb";
    return isatty(STDOUT_FILENO) == 1 && can && !objects;
  }();
  return answer;
}

std::string in_style(const char* code, std::string_view text) { return fmt::format("\x1b[{}m{}\x1b[0m", code, text); }

/// Whether a line stands below the head of a table: dashes only.
bool is_rule(std::string_view line) {
  return line.find('-') != std::string_view::npos && line.find_first_not_of(" -") == std::string_view::npos;
}

std::string with_bold_heads(std::string_view text) {
  std::string styled;
  while (!text.empty()) {
    const auto length = std::min(text.find('\n'), text.size() - 1) + 1;
    const std::string_view line = text.substr(0, length), rest = text.substr(length);
    const bool is_head = is_rule(rest.substr(0, rest.find('\n')));
    styled += is_head ? in_style("1", line.substr(0, line.find('\n'))) + "\n" : std::string(line);
    text = rest;
  }
  return styled;
}

const char* colour_of(VerdictState state) {
  if (state == VerdictState::consistent) return "32";
  return state == VerdictState::suspicious ? "33" : "31";
}

}  // namespace

void print_report(std::string_view text) {
  const std::string safe = terminal_safe(text);
  print_safe(draws_in_colour() ? with_bold_heads(safe) : safe);
}

void print_verdict(std::optional<VerdictState> state, const std::string& why_none) {
  const std::string line = "Verdict: " + (state ? to_string(*state) : "none, " + why_none);
  print_safe((state && draws_in_colour() ? in_style(colour_of(*state), line) : line) + "\n");
}

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// "2 min 5 s" left of a job, as its fraction and the time that this took tell.
std::string time_left(double elapsed, double fraction) {
  const auto seconds = static_cast<long long>(std::ceil(elapsed * (1.0 / fraction - 1.0)));
  if (seconds < 60) return fmt::format("{} s left", seconds);
  return seconds < 3600 ? fmt::format("{} min {} s left", seconds / 60, seconds % 60)
                        : fmt::format("{} h {} min left", seconds / 3600, seconds / 60 % 60);
}

/// A line on stdout for each tenth of a long job, for files and pipes.
class Lines {
public:
  void show(std::string_view words, double fraction) {
    const int tenths = static_cast<int>(10.0 * fraction + 1e-9);
    if (seconds_since(start_) < 5.0 || tenths <= tenths_) return;
    tenths_ = tenths;
    command::print("{} %, {}: {}\n", 10 * tenths, time_left(seconds_since(start_), fraction), words);
  }

private:
  Clock::time_point start_ = Clock::now();
  int tenths_ = 0;
};

/// One line on stderr that is drawn again, ten times a second at most.
class Bar {
public:
  ~Bar() { wipe_bar(); }

  void show(std::string_view words, double fraction) {
    if (seconds_since(start_) < 1.0 || fraction <= 0.0 || Clock::now() - drawn_at_ < std::chrono::milliseconds(100))
      return;
    wipe_bar();
    const int filled = static_cast<int>(columns * fraction);
    draw(fmt::format("\r[{}{}] {:3.0f} %, {}: {}", std::string(static_cast<std::size_t>(filled), '='),
                     std::string(static_cast<std::size_t>(columns - filled), ' '), 100.0 * fraction,
                     time_left(seconds_since(start_), fraction), words)
             .substr(0, width()));
    drawn_at_ = Clock::now();
  }

private:
  static constexpr int columns = 24;

  /// Of the terminal, less one; a longer line would not be wiped.
  static std::size_t width() {
    winsize size{};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1U : 79U;
  }

  /// A terminal that has gone does not end the run.
  static void draw(const std::string& text) {
    std::fputs(text.c_str(), stderr);
    std::fflush(stderr);
    bar_is_drawn = true;
  }

  Clock::time_point start_ = Clock::now(), drawn_at_ = {};
};

template <class Shown>
Progress shown_by() {
  return [shown = std::make_shared<Shown>()](std::string_view words, double fraction) { shown->show(words, fraction); };
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
