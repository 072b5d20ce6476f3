// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace kalfem {

/// Hysteresis of Ramberg and Osgood with Masing's rules, in the words of the rules: a list of the reversals whose loops
/// are open, and the backbone inverted by Newton's method. Nothing of it is approximated.
class MasingBranches {
public:
  MasingBranches(double k, double f_y, double alpha, double r) : k_(k), f_y_(f_y), alpha_(alpha), r_(r) {}

  [[nodiscard]] double backbone_deformation(double f) const {
    return f / k_ * (1.0 + alpha_ * std::pow(std::abs(f) / f_y_, r_ - 1.0));
  }

  /// From above, where the deformation is a convex function of the force.
  [[nodiscard]] double backbone(double d) const {
    const double size = std::abs(d);
    if (size == 0.0) return 0.0;
    double f = std::min(k_ * size, f_y_ * std::pow(k_ * size / (alpha_ * f_y_), 1.0 / r_));
    for (int i = 0; i < 60; ++i) {
      const double u = alpha_ * std::pow(f / f_y_, r_ - 1.0);
      const double correction = (f * (1.0 + u) / k_ - size) * k_ / (1.0 + r_ * u);
      f -= correction;
      if (std::abs(correction) <= 1e-14 * f) break;
    }
    return std::copysign(f, d);
  }

  /// Force at the end of a monotone path to the deformation d.
  double move_to(double d) {
    if (d == at_.d) return at_.f;
    const double direction = d > at_.d ? 1.0 : -1.0;
    if (direction * direction_ < 0.0) reversals_.push_back(at_);
    direction_ = direction;
    while (reversals_.size() >= 2 && (d - reversals_[reversals_.size() - 2].d) * direction >= 0.0)
      reversals_.resize(reversals_.size() - 2);
    if (reversals_.size() == 1 && (d + reversals_.front().d) * direction >= 0.0) reversals_.clear();
    at_ = {d, reversals_.empty() ? backbone(d) : reversals_.back().f + 2.0 * backbone(0.5 * (d - reversals_.back().d))};
    return at_.f;
  }

private:
  struct Point {
    double d = 0.0, f = 0.0;
  };

  double k_, f_y_, alpha_, r_;
  double direction_ = 0.0;
  Point at_;
  std::vector<Point> reversals_;
};

}  // namespace kalfem
