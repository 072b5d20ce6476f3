// SPDX-License-Identifier: Apache-2.0
#include "kalfem/yaml/bounds.hpp"

#include <cmath>

namespace kalfem {
namespace {

/// Magnitudes in SI that can be multiplied without overflow; anything beyond is a typing error.
constexpr double smallest = 1e-100, largest = 1e100;

double require_within(double value, const std::string& shown, const Bounds& bounds) {
  if (!bounds.contain(value)) throw InvalidInput(shown + " given", "it must be " + bounds.to_string(), "");
  if (value != 0.0 && !(std::abs(value) >= smallest && std::abs(value) <= largest))
    throw InvalidInput(shown + " given",
                       "it must be 0, or between " + shortest(smallest) + " and " + shortest(largest) + " in magnitude",
                       "");
  return value;
}

}  // namespace

bool Bounds::contain(double x) const { return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high); }

std::string Bounds::to_string() const {
  const bool below = std::isfinite(low), above = std::isfinite(high);
  if (below && above)
    return std::string("in ") + (low_open ? "(" : "[") + shortest(low) + ", " + shortest(high) +
           (high_open ? ")" : "]");
  if (below) return (low_open ? "> " : ">= ") + shortest(low);
  if (above) return (high_open ? "< " : "<= ") + shortest(high);
  return "";
}

double checked_number(const std::string& text, const std::string& unit, const Bounds& bounds) {
  return require_within(to_si(text, unit), text, bounds);
}

double checked_number(const Located<Quantity>& given, const std::string& unit, const Bounds& bounds) {
  try {
    return require_within(to_si(given.value, unit), shortest(given.value.value), bounds);
  } catch (const InvalidInput& error) {
    std::vector<Issue> issues;
    for (const auto& each : error.issues()) issues.push_back(given.issue(each.what, each.why, each.fix));
    throw InvalidInput(std::move(issues));
  }
}

}  // namespace kalfem
