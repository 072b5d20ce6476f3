#include "kalfem/system/signals/uniform_spline.hpp"

namespace kalfem {

namespace {

double second_difference(const Eigen::VectorXd& y, Eigen::Index i) { return y(i - 1) - 2.0 * y(i) + y(i + 1); }

/// Thomas elimination of x_{i-1} + 4 x_i + x_{i+1} = right_i over first..last, with x known just outside.
void solve_between(Eigen::VectorXd& x, const Eigen::VectorXd& y, Eigen::Index first, Eigen::Index last) {
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(x.size());
  for (Eigen::Index i = first; i <= last; ++i) {
    const double pivot = 4.0 - weight(i - 1);
    weight(i) = 1.0 / pivot;
    x(i) = (6.0 * second_difference(y, i) - x(i - 1)) / pivot;
  }
  for (Eigen::Index i = last; i >= first; --i) x(i) -= weight(i) * x(i + 1);
}

}  // namespace

Eigen::VectorXd not_a_knot_curvature(const Eigen::VectorXd& y) {
  const Eigen::Index n = y.size();
  Eigen::VectorXd M = Eigen::VectorXd::Zero(n);
  if (n < 3) return M;
  if (n == 3) return Eigen::VectorXd::Constant(n, second_difference(y, 1));
  M(1) = second_difference(y, 1);
  M(n - 2) = second_difference(y, n - 2);
  solve_between(M, y, 2, n - 3);
  M(0) = 2.0 * M(1) - M(2);
  M(n - 1) = 2.0 * M(n - 2) - M(n - 3);
  return M;
}

std::array<double, 3> spline_segment(double y0, double y1, double M0, double M1, double x) {
  const double r = 1.0 - x;
  return {r * y0 + x * y1 + (M0 * (r * r * r - r) + M1 * (x * x * x - x)) / 6.0,
          y1 - y0 + (M0 * (1.0 - 3.0 * r * r) + M1 * (3.0 * x * x - 1.0)) / 6.0, r * M0 + x * M1};
}

}  // namespace kalfem
