#include "kalfem/system/laws/elastoplastic_laws.hpp"

#include "kalfem/system/laws/pointwise_law.hpp"

namespace kalfem {
namespace {

/// Return map of an elastic spring of stiffness k_stick in series with a slider of strength f_slip. At an instant
/// (duration 0) the force is still bounded, while the slip stays.
KernelOutput<1> stick_slip(double k_stick, double f_slip, double d, double slip, double duration) {
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

  KernelOutput<1> operator()(const KernelInput<4, 1>& in) const {
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

  KernelOutput<1> operator()(const KernelInput<4, 1>& in) const {
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

}  // namespace kalfem
