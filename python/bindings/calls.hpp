// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "bindings.hpp"

namespace kalfem::python {

/// A long call of the library: it runs without the GIL, tells Python of its progress, and stops within a moment where
/// Ctrl-C is pressed or a function of Python raised.
class LongCall {
public:
  /// `progress`: called with (fraction, words), or None.
  explicit LongCall(const py::object& progress);

  /// What `work(progress)` returns. Throws what it throws, and what Python raised meanwhile.
  template <class Work>
  auto run(const Work& work) {
    try {
      const py::gil_scoped_release released;
      const StopScope scope(&question_);
      return work(progress_);
    } catch (const Interrupted&) {
      raise();
    }
  }

private:
  bool shall_stop();
  void report(std::string_view words, double fraction);
  template <class Ask>
  void ask_python(const Ask& ask);
  [[noreturn]] void raise();
  bool is_due(std::chrono::steady_clock::time_point& last) const;

  py::object reporter_;
  std::thread::id caller_ = std::this_thread::get_id();
  std::chrono::steady_clock::time_point asked_ = std::chrono::steady_clock::now(), reported_ = {};
  std::atomic<bool> stopped_ = false;
  std::exception_ptr raised_;
  StopQuestion question_;
  Progress progress_;
};

/// Raises what a law of the structure that is a Python function raised in the call that has ended; such a law cannot
/// raise through the library. See python_law().
void raise_of_laws(const Structure& structure);

/// Warns of laws that are Python functions where the calls that so many samples take are expected to last for long: by
/// the time that a call takes now.
void warn_of_slow_laws(const Structure& structure, Eigen::Index samples);

/// A long call about structures whose laws may be functions of Python.
template <class Work>
auto long_call(const std::vector<Structure>& structures, const py::object& progress, const Work& work) {
  try {
    auto result = LongCall(progress).run(work);
    for (const auto& structure : structures) raise_of_laws(structure);
    return result;
  } catch (const InvalidInput&) {
    for (const auto& structure : structures) raise_of_laws(structure);
    throw;
  }
}
template <class Work>
auto long_call(const Structure& structure, const py::object& progress, const Work& work) {
  return long_call(std::vector{structure}, progress, work);
}

/// A law that is a function f(x, v, *parameters) of arrays, shape (points,) each.
Law python_law(const py::function& force, const NamedValues& values);

}  // namespace kalfem::python
