// SPDX-License-Identifier: Apache-2.0
#include "kalfem/verdict/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace kalfem {

std::string to_string(VerdictState state) {
  switch (state) {
    case VerdictState::consistent:
      return "consistent";
    case VerdictState::suspicious:
      return "suspicious";
    case VerdictState::unusable:
      return "unusable";
  }
  return "";
}

std::string sentence_of(const Reason& reason) {
  return reason.remedy.empty() ? reason.text : reason.text + "; " + reason.remedy;
}

VerdictState Verdict::state() const {
  VerdictState worst = VerdictState::consistent;
  for (const auto& reason : reasons_) worst = std::max(worst, reason.state);
  return worst;
}

std::vector<Reason> Verdict::reasons() const {
  auto sorted = reasons_;
  std::ranges::stable_sort(sorted, [](const Reason& one, const Reason& other) {
    const bool is_cause = std::isinf(one.weight), other_is = std::isinf(other.weight);
    return std::tie(is_cause, one.state, one.weight) > std::tie(other_is, other.state, other.weight);
  });
  return sorted;
}

VerdictState state_of(double widening) {
  if (widening >= unusable_widening) return VerdictState::unusable;
  return widening >= suspicious_widening ? VerdictState::suspicious : VerdictState::consistent;
}

}  // namespace kalfem
