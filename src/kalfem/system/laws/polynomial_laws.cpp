#include "kalfem/system/laws/polynomial_laws.hpp"

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/laws/pointwise_law.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

struct CubicKernel {
  static constexpr std::size_t parameter_count = 4, state_count = 0;

  KernelOutput<> operator()(const KernelInput<4>& in) const {
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
  for (Index i = coefficients.cols() - 1; i >= 0; --i) {
    value += coefficients.col(i);
    slope = slope * x + value;
    value *= x;
  }
}

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
                       "name the coefficients that the law has, such as k1, k2, k3, c1");
  return std::make_shared<PolynomialLaw>(stiffness_degree, damping_degree);
}

}  // namespace kalfem
