// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/option_checks.hpp"

#include <array>
#include <charconv>
#include <cmath>

namespace kalfem {

std::string to_string(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

void require_finite(IssueList& issues, const std::string& option, double value) {
  if (!std::isfinite(value)) issues.add({}, option + " is " + to_string(value), "it must be a finite number");
}

void require_positive(IssueList& issues, const std::string& option, double value) {
  if (!(value > 0.0) || !std::isfinite(value))
    issues.add({}, option + " is " + to_string(value), "it must be positive and finite");
}

void require_nonnegative(IssueList& issues, const std::string& option, double value) {
  if (!(value >= 0.0) || !std::isfinite(value))
    issues.add({}, option + " is " + to_string(value), "it must be zero or positive, and finite");
}

void require_band(IssueList& issues, const std::string& option, double low, double high) {
  if (!(low > 0.0) || !(low < high) || !std::isfinite(high))
    issues.add({}, option + " is [" + to_string(low) + ", " + to_string(high) + "]",
               "a band needs two finite bounds with 0 < lower < upper");
}

}  // namespace kalfem
