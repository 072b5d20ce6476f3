// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace kalfem {

/// Leaves a long computation that its caller asked to stop. It is no std::exception: nothing on the way handles it.
struct Interrupted {};

/// Whether a computation shall stop. Asked at every time step, by every thread of the computation.
using StopQuestion = std::function<bool()>;

/// While it lives, the long computations of its thread, and the threads that they start, ask the question and throw
/// Interrupted once the answer is yes. Null: nobody asks.
class StopScope {
public:
  explicit StopScope(const StopQuestion* question) : outer_(asked_) { asked_ = question; }
  ~StopScope() { asked_ = outer_; }
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

  /// What the computations of this thread ask; null: nothing.
  [[nodiscard]] static const StopQuestion* question() { return asked_; }

private:
  const StopQuestion* outer_;
  static inline thread_local const StopQuestion* asked_ = nullptr;
};

/// To be called in the loops of long computations.
inline void stop_if_asked() {
  if (const auto* question = StopScope::question(); question && (*question)()) throw Interrupted();
}

}  // namespace kalfem
