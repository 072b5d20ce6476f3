// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <memory>

#include "kalfem/system/laws/law_library.hpp"
#include "kalfem/system/laws/slider.hpp"

namespace kalfem {

namespace {

constexpr std::size_t sliders = 20;
constexpr double least_part = 0.01, largest_part = 20.0;  ///< plastic over elastic deformation, first and last tangent
constexpr double least_exponent = 1.1, least_alpha = 1e-9;  ///< a sigma point may have less

// Jenkins elements in parallel obey Masing's rules exactly, each branch and each nested loop included [Iwa67]. So only
// the backbone is approximated: the plastic deformation over the force by its tangents at forces at which plastic over
// elastic deformation u is in geometric progression,
//     g = f_y (u / alpha)^(1/(r-1)),     p(f) = u g / k + r u (f - g) / k.
// Two neighbours meet at a corner, where one slider begins to slip. Tangents of a power over a geometric progression
// are too low by the same share at every corner: half of that share, added to all, leaves the mean without error.

/// The sum of the stretched springs of the sliders, and of the spring that never slips.
struct RambergOsgoodKernel {
  static constexpr std::size_t parameter_count = 5, state_count = sliders;
  static constexpr bool has_branches = true;

  KALFEM_INLINE KernelOutput<state_count> operator()(const KernelInput<5, state_count>& in) const {
    const auto [k, f_y, stated_alpha, stated_r, c] = in.p;
    const double r = std::max(stated_r, least_exponent), alpha = std::max(stated_alpha, least_alpha);
    const double ratio = std::pow(largest_part / least_part, 1.0 / static_cast<double>(sliders - 1));
    const double force_ratio = std::pow(ratio, 1.0 / (r - 1.0)), balance = balance_of(r, ratio, force_ratio);
    KernelOutput<state_count> out{.force = c * in.v, .stiffness = 0.0, .damping = c, .inertance = 0.0, .s = {}};
    double u = least_part, g = std::max(f_y, 0.0) * std::pow(u / alpha, 1.0 / (r - 1.0));
    double last_u = 0.0, last_product = 0.0, last_slope = k;
    for (std::size_t i = 0; i < sliders; ++i) {
      const double corner = (r - 1.0) / r * (u * g - last_product) / (u - last_u);  // force
      const double plastic = balance * (r * last_u * corner - (r - 1.0) * last_product);
      const double slope = k / (1.0 + balance * r * u);
      add_slider(in, i, last_slope - slope, (corner + plastic) / k, out);
      last_u = u;
      last_product = u * g;
      last_slope = slope;
      u *= ratio;
      g *= force_ratio;
    }
    out.force += last_slope * in.d;
    out.stiffness += last_slope;
    return out;
  }

private:
  /// Factor on the plastic deformation of the tangents.
  static double balance_of(double r, double ratio, double force_ratio) {
    const double corner = (r - 1.0) / r * (ratio * force_ratio - 1.0) / (ratio - 1.0);
    const double exact = std::pow(corner, r), tangent = 1.0 + r * (corner - 1.0);
    return 2.0 * exact / (exact + tangent);
  }
};

}  // namespace

ConnectorLawPtr ramberg_osgood_law() {
  return std::make_shared<PointwiseLaw<RambergOsgoodKernel>>(
      "ramberg_osgood",
      std::vector<LawQuantity>{
          {"k", "N/m", "stiffness at small deformation", Range::positive},
          {"f_y", "N", "force whose plastic deformation is alpha times the elastic one", Range::positive},
          {"alpha", "-", "plastic over elastic deformation at f_y; hold it fixed, it sets the meaning of f_y",
           Range::positive, 1.0},
          {"r", "-", "exponent of the plastic deformation, below 1.1 counts as 1.1: the larger, the sharper the knee",
           Range::at_least_one},
          {"c", "N s/m", "damping alongside", Range::nonnegative, 0.0}},
      slips_of(sliders));
}

}  // namespace kalfem
