// SPDX-License-Identifier: Apache-2.0
// What tests over many random records share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include <fmt/format.h>

#include "random_record.hpp"

namespace kalfem::calibration {

/// A number from the environment, so that other seeds, or a part of them, can be looked at.
inline int number(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text ? std::atoi(text) : otherwise;
}

/// Whether a count of intervals that hold the truth lies in the 99 % binomial range of 95 %.
inline bool is_binomial(int held, int intervals) {
  return std::abs(held - 0.95 * intervals) <= 2.576 * std::sqrt(0.95 * 0.05 * intervals);
}

inline bool holds(const ParameterEstimate& found, double truth) {
  return found.interval_95.lower <= truth && truth <= found.interval_95.upper;
}

/// The codes of its reasons with their weights, worst first.
inline std::string codes_of(const Verdict& verdict) {
  std::string text;
  for (const auto& reason : verdict.reasons()) text += fmt::format(" {} ({:.2g})", reason.code, reason.weight);
  return text;
}

}  // namespace kalfem::calibration
