#include "kalfem/dynamics/matched_poles.hpp"

#include <cmath>
#include <complex>

namespace kalfem {
namespace {

constexpr double largest_step = 2.0;  ///< omega h; tanh has its pole where a period is two steps long, at pi

}  // namespace

void match_poles(LocallyNonlinearSystem& system, Eigen::Index first, double step) {
  using Complex = std::complex<double>;
  for (Eigen::Index i = first; i < system.size(); ++i) {
    const double stiffness = system.stiffness.coeff(i, i), decay = 0.5 * system.damping.coeff(i, i);
    if (!(stiffness > 0.0) || std::sqrt(stiffness) * step > largest_step) continue;
    const Complex root = std::sqrt(Complex(decay * decay - stiffness));
    const Complex p_1 = 2.0 / step * std::tanh(0.5 * step * (-decay + root)),
                  p_2 = 2.0 / step * std::tanh(0.5 * step * (-decay - root));
    const double mass = stiffness / (p_1 * p_2).real();
    system.mass.coeffRef(i, i) = mass;
    system.damping.coeffRef(i, i) = -(p_1 + p_2).real() * mass;
  }
}

}  // namespace kalfem
