#include "kalfem/system/laws/linear_laws.hpp"

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/laws/pointwise_law.hpp"

namespace kalfem {
namespace {

struct LinearKernel {
  static constexpr std::size_t parameter_count = 2, state_count = 0;

  KernelOutput<> operator()(const KernelInput<2>& in) const {
    const auto [k, c] = in.p;
    return {.force = k * in.d + c * in.v, .stiffness = k, .damping = c, .inertance = 0.0, .s = {}};
  }
};

struct InerterKernel {
  static constexpr std::size_t parameter_count = 1, state_count = 0;
  static constexpr bool uses_acceleration = true;

  KernelOutput<> operator()(const KernelInput<1>& in) const {
    const auto [b] = in.p;
    return {.force = b * in.a, .stiffness = 0.0, .damping = 0.0, .inertance = b, .s = {}};
  }
};

struct PreloadKernel {
  static constexpr std::size_t parameter_count = 1, state_count = 0;

  KernelOutput<> operator()(const KernelInput<1>& in) const {
    const auto [f0] = in.p;
    return {.force = f0, .stiffness = 0.0, .damping = 0.0, .inertance = 0.0, .s = {}};
  }
};

struct LinearChangeKernel {
  static constexpr std::size_t parameter_count = 3, state_count = 0;
  static constexpr bool uses_acceleration = true;
  LinearNominal nominal;

  KernelOutput<> operator()(const KernelInput<3>& in) const {
    const double k = in.p[0] - nominal.stiffness, c = in.p[1] - nominal.damping, b = in.p[2] - nominal.inertance;
    return {.force = k * in.d + c * in.v + b * in.a, .stiffness = k, .damping = c, .inertance = b, .s = {}};
  }
};

void check(const LinearNominal& nominal) {
  IssueList issues;
  const auto require = [&](const char* name, double value) {
    if (!std::isfinite(value) || value < 0.0)
      issues.add({}, "linear_change: nominal " + std::string(name) + " is " + std::to_string(value),
                 "it must be a finite number, not negative", "give the value that the linear part holds");
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

ConnectorLawPtr linear_change_law(const LinearNominal& nominal) {
  check(nominal);
  return std::make_shared<PointwiseLaw<LinearChangeKernel>>(
      "linear_change",
      std::vector<LawQuantity>{{"k", "N/m", "true stiffness", Range::nonnegative, nominal.stiffness},
                               {"c", "N s/m", "true damping", Range::nonnegative, nominal.damping},
                               {"b", "kg", "true inertance or mass", Range::nonnegative, nominal.inertance}},
      std::vector<LawQuantity>{}, LinearChangeKernel{nominal});
}

}  // namespace kalfem
