#include "kalfem/system/laws/saturating_law.hpp"

#include <cmath>

#include "kalfem/system/laws/pointwise_law.hpp"

namespace kalfem {
namespace {

struct SaturatingKernel {
  static constexpr std::size_t parameter_count = 6, state_count = 0;

  KernelOutput<> operator()(const KernelInput<6>& in) const {
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

}  // namespace kalfem
