#include "kalfem/system/laws/friction_laws.hpp"

#include <cmath>

#include "kalfem/system/laws/pointwise_law.hpp"

namespace kalfem {
namespace {

struct CoulombKernel {
  static constexpr std::size_t parameter_count = 4, state_count = 0;
  static constexpr bool has_branches = true;

  KernelOutput<> operator()(const KernelInput<4>& in) const {
    const auto [f_c, v_ref, k, c] = in.p;
    const double slide = std::tanh(in.v / v_ref);
    return {.force = k * in.d + c * in.v + f_c * slide,
            .stiffness = k,
            .damping = c + f_c * (1.0 - slide * slide) / v_ref,
            .inertance = 0.0,
            .s = {}};
  }
};

struct StribeckKernel {
  static constexpr std::size_t parameter_count = 6, state_count = 0;
  static constexpr bool has_branches = true;

  KernelOutput<> operator()(const KernelInput<6>& in) const {
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

}  // namespace kalfem
