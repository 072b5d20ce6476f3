// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>

namespace kalfem {

/// Filter steps that a search may take: a pass over a record takes samples x substeps of them. Steps are counted, not
/// seconds, so the same case gives the same numbers on every machine.
class StepBudget {
public:
  static constexpr double unlimited = std::numeric_limits<double>::infinity();

  explicit StepBudget(double steps = unlimited) : left_(steps) {}

  [[nodiscard]] double left() const { return left_; }
  [[nodiscard]] bool is_limited() const { return std::isfinite(left_); }
  [[nodiscard]] bool allows(double steps) const { return steps <= left_; }
  /// Takes so many; where fewer are left, none, and says false.
  bool take(double steps) {
    refused_ = refused_ || !allows(steps);
    if (!allows(steps)) return false;
    left_ -= steps;
    return true;
  }
  [[nodiscard]] bool refused() const { return refused_; }  ///< whether take() ever said false

private:
  double left_;
  bool refused_ = false;
};

}  // namespace kalfem
