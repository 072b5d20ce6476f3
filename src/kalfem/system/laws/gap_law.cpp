#include "kalfem/system/laws/gap_law.hpp"

#include <limits>

#include "kalfem/system/laws/pointwise_law.hpp"

namespace kalfem {
namespace {

struct GapKernel {
  static constexpr std::size_t parameter_count = 6, state_count = 0;

  KernelOutput<> operator()(const KernelInput<6>& in) const {
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

}  // namespace

ConnectorLawPtr gap_law() {
  constexpr double absent = std::numeric_limits<double>::infinity();
  return std::make_shared<PointwiseLaw<GapKernel>>(
      "gap", std::vector<LawQuantity>{
                 {"k_stop", "N/m", "stiffness of a stop in contact", Range::nonnegative},
                 {"c_stop", "N s/m", "damping of a stop in contact", Range::nonnegative, 0.0},
                 {"gap_upper", "m", "positive deformation at which the upper stop is met", Range::nonnegative, absent},
                 {"gap_lower", "m", "size of the negative deformation at which the lower stop is met",
                  Range::nonnegative, absent},
                 {"k", "N/m", "stiffness alongside", Range::nonnegative, 0.0},
                 {"c", "N s/m", "damping alongside", Range::nonnegative, 0.0}});
}

}  // namespace kalfem
