// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/sensors/measurement_chain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "kalfem/linalg/discretisation.hpp"
#include "kalfem/system/option_checks.hpp"

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

// Bessel's polynomial is scaled for a delay of one; a cutoff means half the power, so the poles are divided by the
// frequency at which that is reached.
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

namespace {

constexpr int highest_order = 12;
constexpr double turn = 2.0 * std::numbers::pi;

void check(IssueList& issues, const std::string& name, const FilterSection& section) {
  if (section.order < 1 || section.order > highest_order)
    issues.add({}, name + ": filter order is " + std::to_string(section.order), "orders from 1 to 12 are supported");
  if (section.band == FilterBand::band_pass)
    require_band(issues, name + ": pass band [Hz]", section.cutoff, section.upper_cutoff);
  else
    require_positive(issues, name + ": cutoff [Hz]", section.cutoff);
}

void check(IssueList& issues, const std::string& name, const DelaySection& section) {
  require_nonnegative(issues, name + ": delay [s]", section.delay);
  if (section.order < 2 || section.order > highest_order || section.order % 2 != 0)
    issues.add({}, name + ": order of the delay is " + std::to_string(section.order), "it must be even, from 2 to 12");
}

void check(IssueList& issues, const std::string& name, const ResonanceSection& section) {
  require_positive(issues, name + ": resonance frequency [Hz]", section.frequency);
  require_positive(issues, name + ": resonance damping ratio", section.damping);
}

void check(IssueList& issues, const std::string& name, const GainSection& section) {
  require_finite(issues, name + ": gain", section.gain);
  if (section.gain == 0.0) issues.add({}, name + ": gain is 0", "the record would be zero", "remove this section");
}

/// Poles of the normalised low-pass filter, moved to the band by the usual frequency transformations.
std::vector<AnalogSection> sections_of(const FilterSection& section) {
  const auto poles =
      section.family == FilterFamily::butterworth ? butterworth_poles(section.order) : bessel_poles(section.order);
  switch (section.band) {
    case FilterBand::low_pass:
      return low_pass(poles, turn * section.cutoff);
    case FilterBand::high_pass:
      return high_pass(poles, turn * section.cutoff);
    case FilterBand::band_pass:
      return band_pass(poles, turn * section.cutoff, turn * section.upper_cutoff);
  }
  return {};
}

std::vector<AnalogSection> sections_of(const DelaySection& section) {
  if (section.delay == 0.0) return {};
  return pade_delay(section.order, section.delay);
}

std::vector<AnalogSection> sections_of(const ResonanceSection& section) {
  return {{.order = 2, .rate = turn * section.frequency, .a = 2.0 * section.damping, .b0 = 1.0}};
}

std::vector<AnalogSection> sections_of(const GainSection&) { return {}; }

// A chain is a cascade of analog sections of first and second order, H(s) = gain prod_k H_k(s). Each description gives
// its sections (poles of Butterworth or Bessel filters, Pade's approximation of a delay, one resonance), each section a
// state space of one or two states, and the cascade feeds one by the output of the one before:
//     [x1'; x2'] = [A1 0; B2 C1  A2] [x1; x2] + [B1; B2 D1] u,     y = [D2 C1  C2] [x1; x2] + D2 D1 u.
// filter() runs the cascade over a record with the input linear between samples, which makes the step exact.
/// Controllable form in the states x1 and x2 = x1' / rate, of the size of the input.
ChainStateSpace realise(const AnalogSection& s) {
  if (s.order == 1)
    return {Eigen::MatrixXd::Constant(1, 1, -s.rate), Eigen::VectorXd::Constant(1, s.rate),
            Eigen::RowVectorXd::Constant(1, s.b0 - s.b1), s.b1};
  return {s.rate * Eigen::Matrix2d{{0.0, 1.0}, {-1.0, -s.a}}, s.rate * Eigen::Vector2d(0.0, 1.0),
          Eigen::RowVector2d(s.b0 - s.b2, s.b1 - s.a * s.b2), s.b2};
}

/// `second` fed by the output of `first`.
ChainStateSpace cascade(const ChainStateSpace& first, const ChainStateSpace& second) {
  const Eigen::Index n = first.A.rows();
  const Eigen::Index m = second.A.rows();
  ChainStateSpace both{Eigen::MatrixXd::Zero(n + m, n + m), Eigen::VectorXd(n + m), Eigen::RowVectorXd(n + m),
                       second.D * first.D};
  both.A.topLeftCorner(n, n) = first.A;
  both.A.bottomLeftCorner(m, n) = second.B * first.C;
  both.A.bottomRightCorner(m, m) = second.A;
  both.B << first.B, second.B * first.D;
  both.C << second.D * first.C, second.C;
  return both;
}

void check_record(const Eigen::Ref<const Eigen::VectorXd>& signal, double sample_rate) {
  IssueList issues;
  require_positive(issues, "sampling rate of the record to filter [Hz]", sample_rate);
  if (!signal.allFinite())
    issues.add({}, "the record to filter has infinite or undefined samples", "every sample must be finite",
               "repair or cut the record");
  issues.raise();
}

}  // namespace

IssueList validate(const MeasurementChainOptions& options) {
  IssueList issues;
  for (std::size_t k = 0; k < options.sections.size(); ++k) {
    const std::string name = "measurement chain, section " + std::to_string(k + 1);
    std::visit([&](const auto& section) { check(issues, name, section); }, options.sections[k]);
  }
  return issues;
}

/// The lowest frequency at which some section starts to take the signal away.
double bandwidth(const MeasurementChainOptions& options) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& section : options.sections) {
    if (const auto* filter = std::get_if<FilterSection>(&section)) {
      if (filter->band == FilterBand::low_pass) lowest = std::min(lowest, filter->cutoff);
      if (filter->band == FilterBand::band_pass) lowest = std::min(lowest, filter->upper_cutoff);
    } else if (const auto* resonance = std::get_if<ResonanceSection>(&section)) {
      lowest = std::min(lowest, resonance->frequency);
    }
  }
  return lowest;
}

MeasurementChain::MeasurementChain(const MeasurementChainOptions& options) {
  validate(options).raise();
  for (const auto& section : options.sections) {
    const auto sections = std::visit([](const auto& s) { return sections_of(s); }, section);
    sections_.insert(sections_.end(), sections.begin(), sections.end());
    if (const auto* gain = std::get_if<GainSection>(&section)) gain_ *= gain->gain;
  }
}

Eigen::Index MeasurementChain::states() const {
  Eigen::Index count = 0;
  for (const auto& section : sections_) count += section.order;
  return count;
}

ChainStateSpace MeasurementChain::realise() const {
  ChainStateSpace chain{Eigen::MatrixXd(0, 0), Eigen::VectorXd(0), Eigen::RowVectorXd(0), gain_};
  for (const auto& section : sections_) chain = cascade(chain, kalfem::realise(section));
  return chain;
}

std::complex<double> MeasurementChain::frequency_response(double frequency) const {
  std::complex<double> product = gain_;
  for (const auto& section : sections_) product *= response(section, turn * frequency);
  return product;
}

Eigen::VectorXd MeasurementChain::filter(const Eigen::Ref<const Eigen::VectorXd>& signal, double sample_rate,
                                         FilterStart start) const {
  check_record(signal, sample_rate);
  if (states() == 0 || signal.size() == 0) return gain_ * signal;

  const ChainStateSpace chain = realise();
  const FirstOrderHold step = first_order_hold(chain.A, chain.B, 1.0 / sample_rate);
  Eigen::VectorXd state = Eigen::VectorXd::Zero(states());
  if (start == FilterStart::steady) state = chain.A.partialPivLu().solve(chain.B) * -signal(0);

  Eigen::VectorXd filtered(signal.size());
  Eigen::VectorXd next(states());
  for (Eigen::Index k = 0; k < signal.size(); ++k) {
    filtered(k) = chain.C.dot(state) + chain.D * signal(k);
    if (k + 1 == signal.size()) break;
    next.noalias() = step.transition * state;
    next += step.begin_weight.col(0) * signal(k) + step.end_weight.col(0) * signal(k + 1);
    state.swap(next);
  }
  return filtered;
}

}  // namespace kalfem
