// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signals/cubic_spline.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

double second_difference(const Eigen::Ref<const VectorXd>& y, Index i) { return y(i - 1) - 2.0 * y(i) + y(i + 1); }

/// Thomas elimination of x_{i-1} + 4 x_i + x_{i+1} = right_i over first..last, with x known just outside.
void solve_between(VectorXd& x, const Eigen::Ref<const VectorXd>& y, Index first, Index last) {
  VectorXd weight = VectorXd::Zero(x.size());
  for (Index i = first; i <= last; ++i) {
    const double pivot = 4.0 - weight(i - 1);
    weight(i) = 1.0 / pivot;
    x(i) = (6.0 * second_difference(y, i) - x(i - 1)) / pivot;
  }
  for (Index i = last; i >= first; --i) x(i) -= weight(i) * x(i + 1);
}

}  // namespace

VectorXd not_a_knot_curvature(const Eigen::Ref<const VectorXd>& y) {
  const Index n = y.size();
  VectorXd M = VectorXd::Zero(n);
  if (n < 3) return M;
  if (n == 3) return VectorXd::Constant(n, second_difference(y, 1));
  M(1) = second_difference(y, 1);
  M(n - 2) = second_difference(y, n - 2);
  solve_between(M, y, 2, n - 3);
  M(0) = 2.0 * M(1) - M(2);
  M(n - 1) = 2.0 * M(n - 2) - M(n - 3);
  return M;
}

VectorXd continued_curvature(const Eigen::Ref<const VectorXd>& y, double first) {
  const Index n = y.size();
  VectorXd M = VectorXd::Constant(n, first);
  if (n < 3) return M;
  M(n - 2) = second_difference(y, n - 2);
  solve_between(M, y, 1, n - 3);
  M(n - 1) = 2.0 * M(n - 2) - M(n - 3);
  return M;
}

std::array<double, 3> spline_segment(double y0, double y1, double M0, double M1, double x) {
  const double r = 1.0 - x;
  return {r * y0 + x * y1 + (M0 * (r * r * r - r) + M1 * (x * x * x - x)) / 6.0,
          y1 - y0 + (M0 * (1.0 - 3.0 * r * r) + M1 * (3.0 * x * x - 1.0)) / 6.0, r * M0 + x * M1};
}

std::array<double, 3> hermite_segment(const std::array<double, 3>& begin, const std::array<double, 3>& end, double x) {
  const auto& [value, slope, curvature] = begin;
  const double c2 = 0.5 * curvature;
  const double d = end[0] - value - slope - c2, e = end[1] - slope - curvature, f = end[2] - curvature;
  const double c3 = 10.0 * d - 4.0 * e + 0.5 * f, c4 = -15.0 * d + 7.0 * e - f, c5 = 6.0 * d - 3.0 * e + 0.5 * f;
  return {value + x * (slope + x * (c2 + x * (c3 + x * (c4 + x * c5)))),
          slope + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5))),
          2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5))};
}

double spline_integral(double y0, double y1, double M0, double M1, double x) {
  const double r = 1.0 - x, from_begin = 0.5 * (1.0 - r * r), to_end = 0.5 * x * x;
  return y0 * from_begin + y1 * to_end +
         (M0 * (0.25 * (1.0 - r * r * r * r) - from_begin) + M1 * (0.25 * x * x * x * x - to_end)) / 6.0;
}

}  // namespace kalfem
