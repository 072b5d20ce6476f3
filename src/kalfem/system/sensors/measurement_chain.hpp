// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <complex>
#include <variant>
#include <vector>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

/// First- or second-order analogue transfer function in the scaled variable sigma = s / rate,
///     order 1:  (b1 sigma + b0) / (sigma + 1)
///     order 2:  (b2 sigma^2 + b1 sigma + b0) / (sigma^2 + a sigma + 1).
/// The scaling keeps coefficients and states at the size of the signal, whatever the cut-off.
struct AnalogSection {
  int order = 2;
  double rate = 1.0;  ///< modulus of the poles [rad/s]
  double a = 0.0;     ///< twice the damping ratio; order 2 only
  double b0 = 0.0;
  double b1 = 0.0;
  double b2 = 0.0;  ///< order 2 only
};

/// Value at s = i omega, omega in rad/s.
std::complex<double> response(const AnalogSection& section, double omega);

/// Poles of a low-pass prototype of unit gain at frequency zero, in the upper half plane and on the real axis only: the
/// conjugates are implied. Modulus of the response at 1 rad/s: 1/sqrt(2).
using PrototypePoles = std::vector<std::complex<double>>;

/// Poles on the unit circle, flat amplitude. Order 1 to 12. Source: Butterworth, Wireless Engineer 7 (1930) 536-541.
PrototypePoles butterworth_poles(int order);

/// Roots of the reverse Bessel polynomial, flat group delay, scaled so that the amplitude at 1 rad/s is -3.01 dB
/// (not so that the delay is one). Order 1 to 12. Source: Thomson, Proc. IEE 96 III (1949) 487-490.
PrototypePoles bessel_poles(int order);

/// Roots of the reverse Bessel polynomial theta_n, upper half plane and real axis; the delay at frequency zero is 1.
PrototypePoles bessel_polynomial_roots(int order);

/// The prototype moved to cut-offs in rad/s, as cascade of sections with real coefficients.
std::vector<AnalogSection> low_pass(const PrototypePoles& poles, double cutoff);
std::vector<AnalogSection> high_pass(const PrototypePoles& poles, double cutoff);
/// Twice the prototype's order; amplitude 1 at sqrt(lower upper), -3.01 dB at both edges.
std::vector<AnalogSection> band_pass(const PrototypePoles& poles, double lower, double upper);

/// Pade all-pass [order/order] of the delay exp(-s delay); order even.
std::vector<AnalogSection> pade_delay(int order, double delay);

enum class FilterFamily { butterworth, bessel };
enum class FilterBand { low_pass, high_pass, band_pass };

/// Analogue filter. Every cut-off is a frequency of -3.01 dB, for Bessel filters too.
struct FilterSection {
  FilterFamily family = FilterFamily::butterworth;
  FilterBand band = FilterBand::low_pass;
  int order = 4;              ///< of the low-pass prototype, 1 to 12; a band-pass has twice as many poles
  double cutoff = 0.0;        ///< low-pass, high-pass: the cut-off; band-pass: the lower edge [Hz]
  double upper_cutoff = 0.0;  ///< band-pass: the upper edge [Hz]
};

/// Pure delay, by a diagonal Pade all-pass: amplitude exactly 1, and at the frequency f the phase error in degrees
///     order     f delay = 0.25      0.5        1      1.5      2
///       2                 0.65       13      110      250    410
///       4               1.2e-4     0.05      9.4       72    190
///       6               3.4e-9   2.4e-5     0.11      6.5     50
///       8              < 1e-12   3.1e-9   2.5e-4     0.11    4.4
///      10              < 1e-12  < 1e-12   2.2e-7   5.8e-4    0.1
/// so the default stays below one degree while the delay is shorter than a period.
struct DelaySection {
  double delay = 0.0;  ///< [s], >= 0
  int order = 6;       ///< even, 2 to 12
};

/// Roll-off of an accelerometer (or any sensor with one resonance): w0^2 / (s^2 + 2 zeta w0 s + w0^2).
struct ResonanceSection {
  double frequency = 0.0;  ///< w0 / (2 pi) [Hz]
  double damping = 0.7;    ///< zeta, > 0
};

/// Sensitivity: a constant factor, not zero.
struct GainSection {
  double gain = 1.0;
};

using ChainSection = std::variant<FilterSection, DelaySection, ResonanceSection, GainSection>;

struct MeasurementChainOptions {
  std::vector<ChainSection> sections;  ///< in the direction of the signal; none: the identity
};

IssueList validate(const MeasurementChainOptions& options);

/// Frequency above which the sections pass almost nothing: the lowest upper cut-off or resonance [Hz]; infinite if
/// there is none.
double bandwidth(const MeasurementChainOptions& options);

/// s' = A s + B y,  out = C s + D y  with one input and one output; the states have the unit of y.
struct ChainStateSpace {
  Eigen::MatrixXd A;     ///< [1/s], n x n, lower block triangular, all eigenvalues in the open left half plane
  Eigen::VectorXd B;     ///< [1/s], n
  Eigen::RowVectorXd C;  ///< n
  double D = 1.0;
};

/// What the filter's states are before the first sample: those of a signal that always had the first value, or zero.
enum class FilterStart { steady, zero };

/// Dynamics between the physical quantity and the recorded sample. Immutable.
class MeasurementChain {
public:
  MeasurementChain() = default;
  /// Throws InvalidInput with everything that validate() finds.
  explicit MeasurementChain(const MeasurementChainOptions& options);

  [[nodiscard]] Eigen::Index states() const;
  [[nodiscard]] bool is_identity() const { return sections_.empty() && gain_ == 1.0; }
  [[nodiscard]] ChainStateSpace realise() const;
  /// H(i 2 pi frequency), frequency in Hz.
  [[nodiscard]] std::complex<double> frequency_response(double frequency) const;
  /// The record after the chain; exact for a signal that is straight between its samples.
  /// Throws InvalidInput where a sample is not finite or the sampling rate [Hz] is not positive.
  [[nodiscard]] Eigen::VectorXd filter(const Eigen::Ref<const Eigen::VectorXd>& signal, double sample_rate,
                                       FilterStart start = FilterStart::steady) const;

private:
  std::vector<AnalogSection> sections_;
  double gain_ = 1.0;
};

}  // namespace kalfem
