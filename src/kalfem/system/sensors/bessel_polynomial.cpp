#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/system/sensors/analog_section.hpp"

namespace kalfem {

namespace {

using Complex = std::complex<double>;

/// theta_n(x) / theta_n'(x) by theta_k = (2k - 1) theta_{k-1} + x^2 theta_{k-2} and theta_n' = theta_n - x theta_{n-1}.
Complex newton_step(int order, Complex x) {
  Complex previous = 1.0;
  Complex current = x + 1.0;
  for (int k = 2; k <= order; ++k) {
    const Complex next = (2.0 * k - 1.0) * current + x * x * previous;
    previous = current;
    current = next;
  }
  return current / (current - x * previous);
}

/// Starting points on an arc in the left half plane, where the roots lie at a distance of roughly 0.7 n to n.
std::vector<Complex> starting_points(int order) {
  std::vector<Complex> roots;
  for (int k = 0; k < order; ++k)
    roots.push_back(std::polar(0.9 * order, std::numbers::pi * (0.55 + 0.9 * (k + 0.4) / order)));
  return roots;
}

/// One sweep of simultaneous corrections; returns the largest, relative.
double aberth_sweep(int order, std::vector<Complex>& roots) {
  double largest = 0.0;
  for (auto& root : roots) {
    Complex repulsion = 0.0;
    for (const auto& other : roots)
      if (&other != &root) repulsion += 1.0 / (root - other);
    const Complex newton = newton_step(order, root);
    const Complex correction = newton / (1.0 - newton * repulsion);
    root -= correction;
    largest = std::max(largest, std::abs(correction / root));
  }
  return largest;
}

}  // namespace

/// Aberth, Math. Comp. 27 (1973) 339-344, on the recurrence: the coefficients of theta_n themselves would overwhelm it.
PrototypePoles bessel_polynomial_roots(int order) {
  std::vector<Complex> roots = starting_points(order);
  for (int sweep = 0; sweep < 100 && aberth_sweep(order, roots) > 1e-14; ++sweep) continue;

  PrototypePoles upper;
  for (const auto& root : roots) {
    if (std::abs(root.imag()) < 1e-9 * std::abs(root))
      upper.emplace_back(root.real(), 0.0);
    else if (root.imag() > 0.0)
      upper.push_back(root);
  }
  return upper;
}

}  // namespace kalfem
