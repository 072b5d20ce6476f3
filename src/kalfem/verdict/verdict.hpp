// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace kalfem {

/// Whether the numbers of a run agree with each other and with what was stated about them.
enum class VerdictState { consistent, suspicious, unusable };

std::string to_string(VerdictState state);

/// Why a run is not consistent.
struct Reason {
  std::string code;     ///< for programs: "innovation_large"
  std::string subject;  ///< the sensor, unknown, comparison or step, as the case names it
  std::string text;     ///< one sentence with the figure that was found and the one that was expected
  std::string remedy;   ///< one sentence: what to look at or to change
  VerdictState state = VerdictState::suspicious;  ///< that this reason alone leads to
  /// How far the deviations are wrong because of it, as a factor: orders the reasons of one state. Infinite for a
  /// cause, which stands before its symptoms.
  double weight = 1.0;
};

/// Text and remedy in one sentence.
std::string sentence_of(const Reason& reason);

/// What the numbers say about themselves. Consistent without any reason.
class Verdict {
public:
  /// Its state is held to what the rule of its code can lead to, see reason_kinds().
  void add(Reason reason);
  void add(const std::vector<Reason>& reasons) {
    for (const auto& reason : reasons) add(reason);
  }

  /// That of the worst reason.
  [[nodiscard]] VerdictState state() const;
  /// Worst first.
  [[nodiscard]] std::vector<Reason> reasons() const;

private:
  std::vector<Reason> reasons_;
};

/// Factors by which stated standard deviations are wrong from which it matters, and from which nothing can be built on
/// them.
constexpr double suspicious_widening = 1.5, unusable_widening = 5.0;

/// The state that a factor leads to: consistent below the first limit.
VerdictState state_of(double widening);

}  // namespace kalfem
