#include "kalfem/system/sensors/measurement_chain.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

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

namespace {

using Complex = std::complex<double>;

bool is_real(Complex pole) { return pole.imag() == 0.0; }

/// Denominator of a pole and its conjugate (order 2) or of a real pole (order 1), numerator still zero.
AnalogSection section_of(Complex pole) {
  const double rate = std::abs(pole);
  return {.order = is_real(pole) ? 1 : 2, .rate = rate, .a = is_real(pole) ? 0.0 : -2.0 * pole.real() / rate};
}

/// Squared amplitude of the low-pass prototype with these poles.
double power(const PrototypePoles& poles, double omega) {
  double product = 1.0;
  for (const auto& section : low_pass(poles, 1.0)) product *= std::norm(response(section, omega));
  return product;
}

/// Frequency at which the prototype's power has fallen to one half; the power falls monotonically.
double half_power_frequency(const PrototypePoles& poles) {
  double low = 0.0, high = 1.0;
  while (power(poles, high) > 0.5) high *= 2.0;
  for (int bisection = 0; bisection < 60; ++bisection) {
    const double middle = 0.5 * (low + high);
    (power(poles, middle) > 0.5 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

std::complex<double> response(const AnalogSection& section, double omega) {
  const Complex sigma(0.0, omega / section.rate);
  if (section.order == 1) return (section.b1 * sigma + section.b0) / (sigma + 1.0);
  return (section.b2 * sigma * sigma + section.b1 * sigma + section.b0) / (sigma * sigma + section.a * sigma + 1.0);
}

PrototypePoles butterworth_poles(int order) {
  PrototypePoles poles;
  for (int k = 0; k < order / 2; ++k)
    poles.push_back(std::polar(1.0, std::numbers::pi * (0.5 + (2.0 * k + 1.0) / (2.0 * order))));
  if (order % 2 == 1) poles.emplace_back(-1.0, 0.0);
  return poles;
}

PrototypePoles bessel_poles(int order) {
  PrototypePoles poles = bessel_polynomial_roots(order);
  const double half_power = half_power_frequency(poles);
  for (auto& pole : poles) pole /= half_power;
  return poles;
}

std::vector<AnalogSection> low_pass(const PrototypePoles& poles, double cutoff) {
  std::vector<AnalogSection> sections;
  for (const auto& pole : poles) {
    sections.push_back(section_of(cutoff * pole));
    sections.back().b0 = 1.0;
  }
  return sections;
}

std::vector<AnalogSection> high_pass(const PrototypePoles& poles, double cutoff) {
  std::vector<AnalogSection> sections;
  for (const auto& pole : poles) {
    const Complex moved = is_real(pole) ? Complex(cutoff / pole.real()) : std::conj(cutoff / pole);
    sections.push_back(section_of(moved));
    (is_real(pole) ? sections.back().b1 : sections.back().b2) = 1.0;
  }
  return sections;
}

std::vector<AnalogSection> band_pass(const PrototypePoles& poles, double lower, double upper) {
  // s -> (s^2 + centre^2) / (width s): every pole p becomes the two roots of s^2 - p width s + centre^2.
  const double width = upper - lower;
  const double centre = std::sqrt(lower * upper);
  std::vector<AnalogSection> sections;
  for (const auto& pole : poles) {
    if (is_real(pole)) {
      const double damping = -pole.real() * width / centre;
      sections.push_back({.order = 2, .rate = centre, .a = damping, .b1 = damping});
      continue;
    }
    // The root of larger modulus first, the other from their product centre^2: no cancellation.
    const Complex half = 0.5 * pole * width;
    const Complex root = std::sqrt(half * half - centre * centre);
    const Complex large = std::abs(half + root) > std::abs(half - root) ? half + root : half - root;
    for (const Complex moved : {large, centre * centre / large}) {
      sections.push_back(section_of(moved));
      sections.back().b1 = std::abs(pole) * width / sections.back().rate;
    }
  }
  return sections;
}

std::vector<AnalogSection> pade_delay(int order, double delay) {
  // The denominator of the diagonal Pade approximant is theta_order(s delay / 2), the numerator its mirror image.
  std::vector<AnalogSection> sections;
  for (const auto& pole : bessel_polynomial_roots(order)) {
    AnalogSection section = section_of(2.0 / delay * pole);
    section.b2 = 1.0;
    section.b1 = -section.a;
    section.b0 = 1.0;
    sections.push_back(section);
  }
  return sections;
}

}  // namespace kalfem
