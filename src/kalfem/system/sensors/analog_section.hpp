#pragma once

#include <complex>
#include <vector>

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

}  // namespace kalfem
