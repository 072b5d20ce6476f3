// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// What a reason leads to. `either`: unusable where deviations are wrong by unusable_widening, or as grave as what it
/// explains.
enum class Gravity { suspicious, either, unusable };

std::string_view to_string(Gravity gravity);

/// One rule of the verdict: the codes of its reasons, and what they can lead to.
struct ReasonKind {
  std::vector<std::string_view> codes;
  std::string_view contradiction;         ///< what contradicts what, with Markdown's marks
  Gravity gravity = Gravity::suspicious;  ///< Verdict::add() holds every reason to it
  /// Whether a mistake in the case may be behind it. None is where a sensor's fault was found and left out, where the
  /// record holds little about an unknown, and where the reason itself says what is stated wrongly.
  bool has_a_cause = true;
};

/// Every rule, in the order of docs/verdict.md, whose table they are.
std::span<const ReasonKind> reason_kinds();

/// The mistakes that a diagnosis undoes. As reasons they are as grave as what they explain.
std::span<const ReasonKind> mistake_kinds();

/// Nothing for a code that no rule has.
const ReasonKind* kind_of_reason(std::string_view code);

/// The state nearest to this one that the rule of the code allows.
VerdictState allowed_state(std::string_view code, VerdictState state);

}  // namespace kalfem
