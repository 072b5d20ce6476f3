// SPDX-License-Identifier: Apache-2.0
#include "calls.hpp"

namespace kalfem::python {
namespace {

using Clock = std::chrono::steady_clock;

/// Between two questions to Python: the GIL may have to be waited for.
constexpr std::chrono::milliseconds pause{50};

}  // namespace

LongCall::LongCall(const py::object& progress) : reporter_(progress), question_([this] { return shall_stop(); }) {
  if (!progress.is_none()) progress_ = [this](std::string_view words, double fraction) { report(words, fraction); };
}

bool LongCall::is_due(Clock::time_point& last) const {
  const auto now = Clock::now();
  if (now - last < pause) return false;
  last = now;
  return true;
}

/// What Python raises is kept: it has to pass through threads that know nothing of Python.
template <class Ask>
void LongCall::ask_python(const Ask& ask) {
  const py::gil_scoped_acquire acquired;
  try {
    ask();
  } catch (const py::error_already_set&) {
    if (!stopped_.exchange(true)) raised_ = std::current_exception();
  }
}

bool LongCall::shall_stop() {
  if (stopped_) return true;
  if (std::this_thread::get_id() != caller_ || !is_due(asked_)) return false;
  ask_python([] {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  });
  return stopped_;
}

void LongCall::report(std::string_view words, double fraction) {
  if (std::this_thread::get_id() != caller_) return;
  if (is_due(reported_)) ask_python([&] { reporter_(fraction, py::str(words.data(), words.size())); });
  if (stopped_) throw Interrupted();
}

void LongCall::raise() {
  if (raised_) std::rethrow_exception(std::exchange(raised_, nullptr));
  throw std::runtime_error("a computation was interrupted by nobody");
}

}  // namespace kalfem::python
