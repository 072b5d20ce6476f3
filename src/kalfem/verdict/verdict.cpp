// SPDX-License-Identifier: Apache-2.0
#include "kalfem/verdict/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "kalfem/verdict/reason_kinds.hpp"

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

void Verdict::add(Reason reason) {
  reason.state = allowed_state(reason.code, reason.state);
  reasons_.push_back(std::move(reason));
}

VerdictState Verdict::state() const {
  VerdictState worst = VerdictState::consistent;
  for (const auto& reason : reasons_) worst = std::max(worst, reason.state);
  return worst;
}

namespace {

/// A cause, then its symptoms, the gravest first, then what they do to the deviations of the unknowns.
std::tuple<bool, VerdictState, bool, double> order_of(const Reason& reason) {
  return {std::isinf(reason.weight), reason.state, reason.code != "deviation_too_small", reason.weight};
}

}  // namespace

std::vector<Reason> Verdict::reasons() const {
  auto sorted = reasons_;
  std::ranges::stable_sort(sorted,
                           [](const Reason& one, const Reason& other) { return order_of(one) > order_of(other); });
  return sorted;
}

VerdictState state_of(double widening) {
  if (widening >= unusable_widening) return VerdictState::unusable;
  return widening >= suspicious_widening ? VerdictState::suspicious : VerdictState::consistent;
}

}  // namespace kalfem
