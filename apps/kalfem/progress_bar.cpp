#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <string>

#include "verbs.hpp"

namespace kalfem::command {
namespace {

/// One line on stderr that is drawn again and wiped at the end of a step.
class Bar {
public:
  ~Bar() { wipe(); }

  void show(std::string_view step, double fraction) {
    const auto now = std::chrono::steady_clock::now();
    if (step != step_ || fraction < fraction_) {
      wipe();
      step_ = step;
      start_ = now;
    }
    fraction_ = fraction;
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    if (elapsed < 1.0 || fraction <= 0.0) return;
    constexpr int columns = 32;
    const int filled = static_cast<int>(columns * fraction);
    draw(fmt::format("\r{:<10} [{}{}] {:3.0f} %, {:.0f} s left ", step_, std::string(filled, '='),
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

  std::string step_;
  double fraction_ = 0.0;
  std::chrono::steady_clock::time_point start_;
  bool drawn_ = false;
};

}  // namespace

Progress progress_bar() {
  if (!isatty(STDERR_FILENO)) return {};
  return [bar = std::make_shared<Bar>()](std::string_view step, double fraction) { bar->show(step, fraction); };
}

}  // namespace kalfem::command
