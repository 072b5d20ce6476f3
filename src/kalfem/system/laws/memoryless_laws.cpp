// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/law_library.hpp"

#include <cmath>
#include <limits>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/laws/pointwise_law.hpp"

namespace kalfem {
namespace {

// Each law below is a kernel: force and its derivatives by d, v and a at one point, from parameters in the order of its
// list. PointwiseLaw runs it over all points. The derivatives are exact, for Newton's method on the connector forces
// and for the filter's tangents: what is left out or approximated there costs iterations and shows in the covariance.
struct LinearKernel {
  static constexpr std::size_t parameter_count = 2, state_count = 0;

  KALFEM_INLINE KernelOutput<> operator()(const KernelInput<2>& in) const {
    const auto [k, c] = in.p;
    return {.force = k * in.d + c * in.v, .stiffness = k, .damping = c, .inertance = 0.0, .s = {}};
  }
};

struct InerterKernel {
  static constexpr std::size_t parameter_count = 1, state_count = 0;
  static constexpr bool uses_acceleration = true;

  KALFEM_INLINE KernelOutput<> operator()(const KernelInput<1>& in) const {
    const auto [b] = in.p;
    return {.force = b * in.a, .stiffness = 0.0, .damping = 0.0, .inertance = b, .s = {}};
  }
};

struct PreloadKernel {
  static constexpr std::size_t parameter_count = 1, state_count = 0;

  KALFEM_INLINE KernelOutput<> operator()(const KernelInput<1>& in) const {
    const auto [f0] = in.p;
    return {.force = f0, .stiffness = 0.0, .damping = 0.0, .inertance = 0.0, .s = {}};
  }
};

/// A signal of a law is carried as a deformation, which nothing resists.
struct SignalKernel {
  static constexpr std::size_t parameter_count = 0, state_count = 0;

  KALFEM_INLINE KernelOutput<> operator()(const KernelInput<0>& /*in*/) const {
    return {.force = 0.0, .stiffness = 0.0, .damping = 0.0, .inertance = 0.0, .s = {}};
  }
};

struct LinearChangeKernel {
  static constexpr std::size_t parameter_count = 3, state_count = 0;
  static constexpr bool uses_acceleration = true;
  LinearNominal nominal;

  KALFEM_INLINE KernelOutput<> operator()(const KernelInput<3>& in) const {
    const double k = in.p[0] - nominal.stiffness, c = in.p[1] - nominal.damping, b = in.p[2] - nominal.inertance;
    return {.force = k * in.d + c * in.v + b * in.a, .stiffness = k, .damping = c, .inertance = b, .s = {}};
  }
};

void check(const LinearNominal& nominal) {
  IssueList issues;
  const auto require = [&](const char* name, double value) {
    if (!std::isfinite(value) || value < 0.0)
      issues.add({}, "linear_change: nominal " + std::string(name) + " is " + std::to_string(value),
                 "it must be a finite number, not negative", "give the value used in the linear part");
  };
  require("stiffness", nominal.stiffness);
  require("damping", nominal.damping);
  require("inertance", nominal.inertance);
  issues.raise();
}

}  // namespace

ConnectorLawPtr linear_law() {
  return std::make_shared<PointwiseLaw<LinearKernel>>(
      "linear", std::vector<LawQuantity>{{"k", "N/m", "stiffness", Range::nonnegative, 0.0},
                                         {"c", "N s/m", "damping", Range::nonnegative, 0.0}});
}

ConnectorLawPtr inerter_law() {
  return std::make_shared<PointwiseLaw<InerterKernel>>(
      "inerter", std::vector<LawQuantity>{{"b", "kg", "inertance", Range::nonnegative}});
}

ConnectorLawPtr preload_law() {
  return std::make_shared<PointwiseLaw<PreloadKernel>>("preload",
                                                       std::vector<LawQuantity>{{"f0", "N", "constant force"}});
}

ConnectorLawPtr signal_law() {
  return std::make_shared<PointwiseLaw<SignalKernel>>(signal_law_name, std::vector<LawQuantity>{});
}

ConnectorLawPtr linear_change_law(const LinearNominal& nominal) {
  check(nominal);
  return std::make_shared<PointwiseLaw<LinearChangeKernel>>(
      "linear_change",
      std::vector<LawQuantity>{{"k", "N/m", "true stiffness", Range::nonnegative, nominal.stiffness},
                               {"c", "N s/m", "true damping", Range::nonnegative, nominal.damping},
                               {"b", "kg", "true inertance or mass", Range::nonnegative, nominal.inertance}},
      std::vector<LawQuantity>{}, LinearChangeKernel{nominal});
}

namespace {

using Eigen::Index;

struct CubicKernel {
  static constexpr std::size_t parameter_count = 4, state_count = 0;

  KALFEM_INLINE KernelOutput<> operator()(const KernelInput<4>& in) const {
    const auto [k, k3, c, c3] = in.p;
    const double d2 = in.d * in.d, v2 = in.v * in.v;
    return {.force = (k + k3 * d2) * in.d + (c + c3 * v2) * in.v,
            .stiffness = k + 3.0 * k3 * d2,
            .damping = c + 3.0 * c3 * v2,
            .inertance = 0.0,
            .s = {}};
  }
};

/// Horner's rule for sum_{i>=1} coefficient_i x^i and its derivative, over all points for one degree after the other.
void horner(const Eigen::Ref<const Eigen::ArrayXXd>& coefficients, const Eigen::Ref<const Eigen::ArrayXd>& x,
            Eigen::Ref<Eigen::ArrayXd> value, Eigen::Ref<Eigen::ArrayXd> slope) {
  value.setZero();
  slope.setZero();
  const double* at = x.data();
  double *p = value.data(), *dp = slope.data();
  const Index count = x.size();
  in_widest_registers([&]() KALFEM_INLINE {
    for (Index i = coefficients.cols() - 1; i >= 0; --i) {
      const double* coefficient = coefficients.data() + i * coefficients.outerStride();
      KALFEM_INDEPENDENT
      for (Index point = 0; point < count; ++point) {
        const double sum = p[point] + coefficient[point];
        dp[point] = dp[point] * at[point] + sum;
        p[point] = sum * at[point];
      }
    }
  });
}

// Parameters are the coefficients of d, d^2, ... and then of v, v^2, ...; all points are evaluated together, degree by
// degree.
class PolynomialLaw final : public ConnectorLaw {
public:
  PolynomialLaw(int stiffness_degree, int damping_degree)
      : stiffness_degree_(stiffness_degree), damping_degree_(damping_degree) {
    for (int i = 1; i <= stiffness_degree; ++i) add("k", i, "N/m", "stiffness");
    for (int i = 1; i <= damping_degree; ++i) add("c", i, "N s/m", "damping");
  }

  [[nodiscard]] std::string name() const override { return "polynomial"; }
  [[nodiscard]] const std::vector<LawQuantity>& parameters() const override { return parameters_; }
  [[nodiscard]] const std::vector<LawQuantity>& states() const override { return states_; }

  [[nodiscard]] bool uses_acceleration() const override { return false; }
  [[nodiscard]] bool vectorised() const override { return true; }

  void respond(const LawPoints& points, LawResponse out) const override {
    // The inertance, which is zero in the end, first holds the damper's force.
    horner(points.parameters.leftCols(stiffness_degree_), points.deformation, out.force, out.stiffness);
    horner(points.parameters.rightCols(damping_degree_), points.rate, out.inertance, out.damping);
    out.force += out.inertance;
    out.inertance.setZero();
  }

private:
  void add(const std::string& symbol, int degree, const std::string& unit, const std::string& meaning) {
    const std::string power = std::to_string(degree);
    const std::string unit_of_degree = degree == 1 ? unit : symbol == "k" ? "N/m^" + power : "N (s/m)^" + power;
    parameters_.push_back({symbol + power, unit_of_degree, meaning + " of degree " + power, Range::any, 0.0});
  }

  int stiffness_degree_, damping_degree_;
  std::vector<LawQuantity> parameters_, states_;
};

}  // namespace

ConnectorLawPtr cubic_law() {
  return std::make_shared<PointwiseLaw<CubicKernel>>(
      "cubic", std::vector<LawQuantity>{{"k", "N/m", "stiffness", Range::nonnegative, 0.0},
                                        {"k3", "N/m^3", "cubic stiffness", Range::any, 0.0},
                                        {"c", "N s/m", "damping", Range::nonnegative, 0.0},
                                        {"c3", "N s^3/m^3", "cubic damping", Range::any, 0.0}});
}

ConnectorLawPtr polynomial_law(int stiffness_degree, int damping_degree) {
  constexpr int highest = 30;
  const auto outside = [](int degree) { return degree < 0 || degree > highest; };
  if (outside(stiffness_degree) || outside(damping_degree) || stiffness_degree + damping_degree == 0)
    throw InvalidInput("polynomial: stiffness degree " + std::to_string(stiffness_degree) + ", damping degree " +
                           std::to_string(damping_degree),
                       "each must lie between 0 and " + std::to_string(highest) + ", one of them above 0",
                       "name the coefficients of the law, such as k1, k2, k3, c1");
  return std::make_shared<PolynomialLaw>(stiffness_degree, damping_degree);
}

namespace {

// With g(x) = mu x / (m + |x|) the slope is g' = mu m / (m + |x|)^2: it is continuous at zero although |x| is not
// smooth.
struct SaturatingKernel {
  static constexpr std::size_t parameter_count = 6, state_count = 0;

  KALFEM_INLINE KernelOutput<> operator()(const KernelInput<6>& in) const {
    const auto [k, mu_k1, mu_k2, c, mu_c1, mu_c2] = in.p;
    const double share_d = 1.0 / (mu_k2 + std::abs(in.d)), share_v = 1.0 / (mu_c2 + std::abs(in.v));
    return {.force = (k + mu_k1 * share_d) * in.d + (c + mu_c1 * share_v) * in.v,
            .stiffness = k + mu_k1 * mu_k2 * share_d * share_d,
            .damping = c + mu_c1 * mu_c2 * share_v * share_v,
            .inertance = 0.0,
            .s = {}};
  }
};

}  // namespace

ConnectorLawPtr saturating_law() {
  return std::make_shared<PointwiseLaw<SaturatingKernel>>(
      "saturating",
      std::vector<LawQuantity>{
          {"k", "N/m", "linear stiffness", Range::nonnegative, 0.0},
          {"mu_k1", "N", "force at which the nonlinear spring saturates", Range::nonnegative},
          {"mu_k2", "m", "deformation at which the nonlinear spring has half that force", Range::positive},
          {"c", "N s/m", "linear damping", Range::nonnegative, 0.0},
          {"mu_c1", "N", "force at which the nonlinear damper saturates", Range::nonnegative},
          {"mu_c2", "m/s", "rate at which the nonlinear damper has half that force", Range::positive}});
}

namespace {

// tanh(v / v_ref) stands for the sign of the rate: its slope 1/v_ref at rest is a finite viscous damping, so that
// Newton's method and the filter have a tangent. Branches are announced because a step can pass the whole transition at
// once.
struct CoulombKernel {
  static constexpr std::size_t parameter_count = 4, state_count = 0;
  static constexpr bool has_branches = true;

  KALFEM_INLINE KernelOutput<> operator()(const KernelInput<4>& in) const {
    const auto [f_c, v_ref, k, c] = in.p;
    const double slide = std::tanh(in.v / v_ref);
    return {.force = k * in.d + c * in.v + f_c * slide,
            .stiffness = k,
            .damping = c + f_c * (1.0 - slide * slide) / v_ref,
            .inertance = 0.0,
            .s = {}};
  }
};

// The excess (f_s - f_c) exp(-(v/v_s)^2) of static friction falls with the rate, so the product rule gives the damping
// a negative term: friction that feeds energy in, as in stick-slip.
struct StribeckKernel {
  static constexpr std::size_t parameter_count = 6, state_count = 0;
  static constexpr bool has_branches = true;

  KALFEM_INLINE KernelOutput<> operator()(const KernelInput<6>& in) const {
    const auto [f_c, f_s, v_s, v_ref, k, c] = in.p;
    const double slide = std::tanh(in.v / v_ref), slide_slope = (1.0 - slide * slide) / v_ref;
    const double ratio = in.v / v_s, excess = (f_s - f_c) * std::exp(-ratio * ratio);
    return {.force = k * in.d + c * in.v + (f_c + excess) * slide,
            .stiffness = k,
            .damping = c + (f_c + excess) * slide_slope - 2.0 * ratio / v_s * excess * slide,
            .inertance = 0.0,
            .s = {}};
  }
};

const LawQuantity sliding{"f_c", "N", "sliding friction force", Range::nonnegative};
const LawQuantity reference{"v_ref", "m/s", "rate below which friction is regularised", Range::positive};
const LawQuantity stiffness{"k", "N/m", "stiffness alongside", Range::nonnegative, 0.0};
const LawQuantity damping{"c", "N s/m", "damping alongside", Range::nonnegative, 0.0};

}  // namespace

ConnectorLawPtr coulomb_law() {
  return std::make_shared<PointwiseLaw<CoulombKernel>>(
      "coulomb", std::vector<LawQuantity>{sliding, reference, stiffness, damping});
}

ConnectorLawPtr stribeck_law() {
  return std::make_shared<PointwiseLaw<StribeckKernel>>(
      "stribeck", std::vector<LawQuantity>{sliding,
                                           {"f_s", "N", "static friction force", Range::nonnegative},
                                           {"v_s", "m/s", "Stribeck rate", Range::positive},
                                           reference,
                                           stiffness,
                                           damping});
}

namespace {

// A stop acts where it is reached and where its force pushes: a damper that would pull on the way back is switched off
// with its spring. Masks of 0 and 1 instead of branches keep the evaluation of many points vectorised.
struct GapKernel {
  static constexpr std::size_t parameter_count = 6, state_count = 0;

  KALFEM_INLINE KernelOutput<> operator()(const KernelInput<6>& in) const {
    const auto [k_stop, c_stop, gap_upper, gap_lower, k, c] = in.p;
    // The open side's overlap may be -infinity: it is replaced before it meets a stiffness, which may be zero.
    const double over = in.d - gap_upper, under = -in.d - gap_lower;
    const double push_upper = k_stop * (over > 0.0 ? over : 0.0) + c_stop * in.v;
    const double push_lower = k_stop * (under > 0.0 ? under : 0.0) - c_stop * in.v;
    const double upper = ((over > 0.0) & (push_upper > 0.0)) ? 1.0 : 0.0;
    const double lower = ((under > 0.0) & (push_lower > 0.0)) ? 1.0 : 0.0;
    return {.force = k * in.d + c * in.v + upper * push_upper - lower * push_lower,
            .stiffness = k + (upper + lower) * k_stop,
            .damping = c + (upper + lower) * c_stop,
            .inertance = 0.0,
            .s = {}};
  }
};

/// Contact whose damping grows with its overlap.
struct HuntCrossleyKernel {
  static constexpr std::size_t parameter_count = 6, state_count = 0;

  /// Of one side, and its derivatives by overlap and rate.
  struct Push {
    double force, stiffness, damping;
  };
  KALFEM_INLINE static Push push(double k_stop, double a, double overlap, double rate) {
    // The open side's overlap may be -infinity: it is replaced before it meets a stiffness, which may be zero.
    const double loss = 1.0 + 1.5 * a * rate, touches = ((overlap > 0.0) & (loss > 0.0)) ? 1.0 : 0.0;
    const double spring = touches * k_stop * (overlap > 0.0 ? overlap : 0.0);
    return {spring * loss, touches * k_stop * loss, 1.5 * a * spring};
  }

  KALFEM_INLINE KernelOutput<> operator()(const KernelInput<6>& in) const {
    const auto [k_stop, a_stop, gap_upper, gap_lower, k, c] = in.p;
    const Push upper = push(k_stop, a_stop, in.d - gap_upper, in.v);
    const Push lower = push(k_stop, a_stop, -in.d - gap_lower, -in.v);
    return {.force = k * in.d + c * in.v + upper.force - lower.force,
            .stiffness = k + upper.stiffness + lower.stiffness,
            .damping = c + upper.damping + lower.damping,
            .inertance = 0.0,
            .s = {}};
  }
};

struct DamperKernel {
  static constexpr std::size_t parameter_count = 5, state_count = 0;

  KALFEM_INLINE KernelOutput<> operator()(const KernelInput<5>& in) const {
    const auto [c_rebound, c_compression, v_rebound, v_compression, k] = in.p;
    const bool extends = in.v > 0.0;
    const double c = extends ? c_rebound : c_compression, knee = extends ? v_rebound : v_compression;
    const double bend = 1.0 / (1.0 + (extends ? in.v : -in.v) / knee);
    return {.force = k * in.d + c * in.v * bend, .stiffness = k, .damping = c * bend * bend, .inertance = 0.0, .s = {}};
  }
};

}  // namespace

ConnectorLawPtr gap_law() {
  constexpr double absent = std::numeric_limits<double>::infinity();
  return std::make_shared<PointwiseLaw<GapKernel>>(
      "gap",
      std::vector<LawQuantity>{
          {"k_stop", "N/m", "stiffness of a stop in contact", Range::nonnegative},
          {"c_stop", "N s/m", "damping of a stop in contact", Range::nonnegative, 0.0},
          {"gap_upper", "m", "deformation at which the upper stop is reached (positive)", Range::nonnegative, absent},
          {"gap_lower", "m", "magnitude of the negative deformation at which the lower stop is reached",
           Range::nonnegative, absent},
          {"k", "N/m", "stiffness alongside", Range::nonnegative, 0.0},
          {"c", "N s/m", "damping alongside", Range::nonnegative, 0.0}});
}

ConnectorLawPtr hunt_crossley_law() {
  constexpr double absent = std::numeric_limits<double>::infinity();
  return std::make_shared<PointwiseLaw<HuntCrossleyKernel>>(
      "hunt_crossley",
      std::vector<LawQuantity>{
          {"k_stop", "N/m", "stiffness of a stop in contact", Range::nonnegative},
          {"a_stop", "s/m", "loss of rebound speed per speed of impact, about", Range::nonnegative, 0.0},
          {"gap_upper", "m", "deformation at which the upper stop is reached (positive)", Range::nonnegative, absent},
          {"gap_lower", "m", "magnitude of the negative deformation at which the lower stop is reached",
           Range::nonnegative, absent},
          {"k", "N/m", "stiffness alongside", Range::nonnegative, 0.0},
          {"c", "N s/m", "damping alongside", Range::nonnegative, 0.0}});
}

ConnectorLawPtr damper_law() {
  constexpr double linear = std::numeric_limits<double>::infinity();
  return std::make_shared<PointwiseLaw<DamperKernel>>(
      "damper",
      std::vector<LawQuantity>{
          {"c_rebound", "N s/m", "damping at small positive rate (extension)", Range::nonnegative},
          {"c_compression", "N s/m", "damping at small negative rate", Range::nonnegative},
          {"v_rebound", "m/s", "rate at which the rebound's damping has halved", Range::positive, linear},
          {"v_compression", "m/s", "rate at which the compression's damping has halved", Range::positive, linear},
          {"k", "N/m", "stiffness alongside", Range::nonnegative, 0.0}});
}

}  // namespace kalfem
