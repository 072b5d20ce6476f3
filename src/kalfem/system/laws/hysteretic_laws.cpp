// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/law_library.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/system/laws/pointwise_law.hpp"

namespace kalfem {
namespace {

/// Return map of an elastic spring of stiffness k_stick in series with a slider of strength f_slip. At an instant
/// (duration 0) the force is still bounded, while the slip stays.
KALFEM_INLINE inline KernelOutput<1> stick_slip(double k_stick, double f_slip, double d, double slip, double duration) {
  const double trial = k_stick * (d - slip);
  const double strength = f_slip > 0.0 ? f_slip : 0.0;
  const double bounded = trial > strength ? strength : (trial < -strength ? -strength : trial);
  const bool sticks = bounded == trial;
  return {.force = bounded,
          .stiffness = sticks ? k_stick : 0.0,
          .damping = 0.0,
          .inertance = 0.0,
          .s = {sticks || duration == 0.0 ? slip : d - bounded / k_stick}};
}

struct JenkinsKernel {
  static constexpr std::size_t parameter_count = 4, state_count = 1;

  KALFEM_INLINE KernelOutput<1> operator()(const KernelInput<4, 1>& in) const {
    const auto [k_stick, f_slip, k, c] = in.p;
    KernelOutput<1> out = stick_slip(k_stick, f_slip, in.d, in.s[0], in.duration);
    out.force += k * in.d + c * in.v;
    out.stiffness += k;
    out.damping = c;
    return out;
  }
};

struct BilinearKernel {
  static constexpr std::size_t parameter_count = 4, state_count = 1;

  KALFEM_INLINE KernelOutput<1> operator()(const KernelInput<4, 1>& in) const {
    const auto [k, f_y, alpha, c] = in.p;
    KernelOutput<1> out = stick_slip((1.0 - alpha) * k, (1.0 - alpha) * f_y, in.d, in.s[0], in.duration);
    out.force += alpha * k * in.d + c * in.v;
    out.stiffness += alpha * k;
    out.damping = c;
    return out;
  }
};

}  // namespace

ConnectorLawPtr jenkins_law() {
  return std::make_shared<PointwiseLaw<JenkinsKernel>>(
      "jenkins",
      std::vector<LawQuantity>{{"k_stick", "N/m", "stiffness while sticking", Range::positive},
                               {"f_slip", "N", "force at which the slider slips", Range::nonnegative},
                               {"k", "N/m", "stiffness alongside", Range::nonnegative, 0.0},
                               {"c", "N s/m", "damping alongside", Range::nonnegative, 0.0}},
      std::vector<LawQuantity>{{"slip", "m", "displacement of the slider"}});
}

ConnectorLawPtr bilinear_law() {
  return std::make_shared<PointwiseLaw<BilinearKernel>>(
      "bilinear",
      std::vector<LawQuantity>{{"k", "N/m", "elastic stiffness", Range::positive},
                               {"f_y", "N", "yield force", Range::nonnegative},
                               {"alpha", "-", "stiffness after yield over elastic stiffness", Range::fraction, 0.0},
                               {"c", "N s/m", "damping alongside", Range::nonnegative, 0.0}},
      std::vector<LawQuantity>{{"slip", "m", "plastic deformation"}});
}

namespace {

/// A value and its derivative by the deformation at the interval's end.
struct Dual {
  double value = 0.0, slope = 0.0;
};

/// The root y >= 0 of y + c y^n = rhs and its derivatives.
struct PowerRoot {
  double y = 0.0, by_rhs = 0.0, by_coefficient = 0.0;
};

constexpr double least_slope =
    0.25;  ///< the left side is continued linearly where c < 0 would bring its slope below this

double power(double y, double n) { return n == 1.0 ? y : n == 2.0 ? y * y : std::pow(y, n); }

PowerRoot linear_root(double c, double rhs) {
  if (1.0 + c <= least_slope) return {rhs / least_slope, 1.0 / least_slope, 0.0};
  const double y = rhs / (1.0 + c);
  return {y, 1.0 / (1.0 + c), -y / (1.0 + c)};
}

/// Root on the linear continuation beyond y_limit, where 1 + n c y^(n-1) = least_slope.
PowerRoot continued_root(double c, double n, double rhs, double y_limit) {
  const double share = 1.0 - (1.0 - (1.0 - least_slope) / n) / least_slope;  // y = rhs / least_slope + share y_limit
  return {rhs / least_slope + share * y_limit, 1.0 / least_slope, -share * y_limit / ((n - 1.0) * c)};
}

// An implicit stage of Bouc-Wen leaves one scalar equation y + c y^n = rhs. Newton's method starts on the side from
// which it approaches monotonically; where c < 0 would turn the left side down, it is continued by its tangent.
/// Newton's method from rhs (or the nearer bound where c is large). The left side is increasing, and convex for c > 0,
/// concave for c < 0, so that the iterates approach the root from one side.
PowerRoot power_root(double c, double n, double rhs) {
  if (n == 1.0) return linear_root(c, rhs);
  if (c < 0.0) {
    const double y_limit = std::pow((1.0 - least_slope) / (-n * c), 1.0 / (n - 1.0));
    if (y_limit < rhs / least_slope && y_limit + c * power(y_limit, n) < rhs) return continued_root(c, n, rhs, y_limit);
  }
  double y = rhs;
  if (c * power(rhs, n) > rhs) y = std::pow(rhs / c, 1.0 / n);
  double slope = 1.0, raised = 0.0;
  for (int iteration = 0; iteration < 60; ++iteration) {
    raised = power(y, n);
    slope = 1.0 + (y > 0.0 ? n * c * raised / y : 0.0);
    const double correction = (y + c * raised - rhs) / slope;
    y -= correction;
    if (!(std::abs(correction) > 1e-14 * std::abs(y))) break;
  }
  return {y, 1.0 / slope, -raised / slope};
}

/// Solves z = base + weight * increment * dz/dd(z), an implicit stage along the signed increment of the deformation.
Dual implicit_stage(const Dual& base, double weight, const KernelInput<7, 1>& in, double increment, double direction) {
  const double A = in.p[2], beta = in.p[3], gamma = in.p[4], n = std::max(in.p[5], 1.0);
  const double rhs = base.value + weight * A * increment, rhs_slope = base.slope + weight * A;
  const double sign = rhs < 0.0 ? -1.0 : 1.0;
  const double coefficient_slope = weight * (beta * direction + sign * gamma);
  const PowerRoot root = power_root(coefficient_slope * increment, n, std::abs(rhs));
  return {sign * root.y, root.by_rhs * rhs_slope + sign * root.by_coefficient * coefficient_slope};
}

/// z at the interval's end.
Dual advance(const KernelInput<7, 1>& in) {
  constexpr double weight = 0.29289321881345248;  // 1 - 1/sqrt(2), the L-stable choice
  const double begin = in.s[0], increment = in.d - in.begin_d;
  const double direction = (increment != 0.0 ? increment : in.v) < 0.0 ? -1.0 : 1.0;
  const Dual middle = implicit_stage({begin, 0.0}, weight, in, increment, direction);
  const double reach = (1.0 - weight) / weight;  // the first stage's share of the second, by its own increment
  return implicit_stage({begin + reach * (middle.value - begin), reach * middle.slope}, weight, in, increment,
                        direction);
}

struct BoucWenKernel {
  static constexpr std::size_t parameter_count = 7, state_count = 1;
  static constexpr bool has_branches = true;

  KALFEM_INLINE KernelOutput<1> operator()(const KernelInput<7, 1>& in) const {
    const double k = in.p[0], alpha = in.p[1], c = in.p[6];
    const Dual z = in.duration == 0.0 ? Dual{in.s[0], 0.0} : advance(in);
    return {.force = alpha * k * in.d + (1.0 - alpha) * k * z.value + c * in.v,
            .stiffness = alpha * k + (1.0 - alpha) * k * z.slope,
            .damping = c,
            .inertance = 0.0,
            .s = {z.value}};
  }
};

}  // namespace

ConnectorLawPtr bouc_wen_law() {
  return std::make_shared<PointwiseLaw<BoucWenKernel>>(
      "bouc_wen",
      std::vector<LawQuantity>{{"k", "N/m", "stiffness at small deformation (for A = 1)", Range::nonnegative},
                               {"alpha", "-", "stiffness after yield over k", Range::fraction, 0.0},
                               {"A", "-", "initial slope of z over d", Range::nonnegative, 1.0},
                               {"beta", "1/m^n", "energy dissipation of the loop", Range::nonnegative},
                               {"gamma", "1/m^n", "shape of the loop: softening > 0, hardening < 0", Range::any},
                               {"n", "-", "sharpness of the transition", Range::at_least_one, 1.0},
                               {"c", "N s/m", "damping alongside", Range::nonnegative, 0.0}},
      std::vector<LawQuantity>{{"z", "m", "hysteretic deformation"}});
}

}  // namespace kalfem
