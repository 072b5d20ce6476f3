#pragma once

#include "kalfem/system/signal.hpp"

namespace kalfem {

/// One harmonic: amplitude * sin(2 pi frequency t + phase).
struct SpectralLine {
  double amplitude = 0.0;
  double frequency = 0.0;  ///< [Hz]
  double phase = 0.0;      ///< [rad]
};

/// Amplitude of the harmonic whose second derivative is the harmonic of this amplitude: -amplitude / (2 pi
/// frequency)^2.
double amplitude_integrated_twice(double amplitude, double frequency);

/// Sum of harmonics with exact derivatives, known at all times (negative ones too).
///
/// Within a block of samples sin(2 pi f (t_b + j step) + phi) is split by the addition theorem into a table over j and
/// two coefficients per block, so that many lines at many instants become one matrix product: few sines are evaluated
/// and no recurrence gathers rounding.
SignalPtr make_spectral_lines(std::vector<SpectralLine> lines);

}  // namespace kalfem
