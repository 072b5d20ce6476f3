#include "kalfem/system/sensors/measurement_chain.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "kalfem/linalg/discretisation.hpp"
#include "kalfem/system/option_checks.hpp"

namespace kalfem {

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
