// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <memory>

#include "kalfem/system/laws/law_library.hpp"
#include "kalfem/system/laws/slider.hpp"

namespace kalfem {

namespace {

constexpr std::size_t sliders = 20;    ///< of the power law; one more slips last
constexpr double widest_ratio = 1e-3;  ///< of the first slider's bin to the deformation of macroslip

/// Jenkins elements in parallel. The bins of the density are geometric; each element has its bin's stiffness, and slips
/// where it has its bin's force, so that stiffness at rest and force in macroslip are exact for any number of them.
struct IwanKernel {
  static constexpr std::size_t parameter_count = 6, state_count = sliders + 1;
  static constexpr bool has_branches = true;

  KALFEM_INLINE KernelOutput<state_count> operator()(const KernelInput<6, state_count>& in) const {
    const auto [f_s, k_t, stated_chi, beta, k, c] = in.p;
    const double chi = std::max(stated_chi, -0.99);  // no density has less, a sigma point may
    const double share = (chi + 1.0) / (chi + 2.0), macroslip = f_s * (1.0 + beta) / (k_t * (beta + share));
    const double of_power_law = k_t / (1.0 + beta);  // its stiffness at rest
    KernelOutput<state_count> out{
        .force = k * in.d + c * in.v, .stiffness = k, .damping = c, .inertance = 0.0, .s = {}};
    const double ratio = std::pow(widest_ratio, 1.0 / static_cast<double>(sliders - 1));
    double upper = 1.0, cumulated = 1.0, moment = 1.0;  // of the bin: end, int rho, int phi rho, from 0 on, relative
    for (std::size_t i = 0; i < sliders; ++i) {
      const double lower = i + 1 < sliders ? upper * ratio : 0.0;
      const double below = lower > 0.0 ? std::pow(lower, chi + 1.0) : 0.0, moment_below = below * lower;
      const double part = cumulated - below;
      add_slider(in, i, of_power_law * part, macroslip * share * (moment - moment_below) / part, out);
      upper = lower;
      cumulated = below;
      moment = moment_below;
    }
    add_slider(in, sliders, of_power_law * beta, macroslip, out);
    return out;
  }
};

}  // namespace

ConnectorLawPtr iwan_law() {
  return std::make_shared<PointwiseLaw<IwanKernel>>(
      "iwan",
      std::vector<LawQuantity>{
          {"f_s", "N", "force in macroslip", Range::positive},
          {"k_t", "N/m", "stiffness at small deformation", Range::positive},
          {"chi", "-", "dissipation grows with the force to the power 3 + chi, -1 < chi <= 0", Range::any},
          {"beta", "-", "stiffness of what slips last over that of the rest", Range::nonnegative},
          {"k", "N/m", "stiffness alongside", Range::nonnegative, 0.0},
          {"c", "N s/m", "damping alongside", Range::nonnegative, 0.0}},
      slips_of(sliders + 1));
}

}  // namespace kalfem
