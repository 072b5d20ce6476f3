// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

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

/// Harmonics of one period, all multiples of 1 / period from the line `first` on: line l has the frequency
/// (first + l) / period.
struct LineSeries {
  double period = 1.0;     ///< [s], > 0
  Eigen::Index first = 1;  ///< >= 0
  std::vector<double> amplitude;
  std::vector<double> phase;  ///< [rad], one a line
};

/// sum_l amplitude_l sin(2 pi (first + l) t / period + phase_l) with its derivatives, at all times.
///
/// A few lines are summed one by one (make_spectral_lines). Many are synthesised by one fast Fourier transform of the
/// complex envelope about the middle of the band; between the points of its grid, twice as fine as the band asks for,
/// the envelope is the sum of 18 points weighted by a Kaiser-Bessel window [FS03]. So L lines cost L log L once and
/// each instant the same, however long the period. The error is below 1e-12 of the sum's rms. Throws InvalidInput where
/// the period is not positive, a number not finite, or amplitudes and phases differ in number.
SignalPtr make_line_series(LineSeries series);

/// The same by the fast Fourier transform for any number of lines (at least one).
SignalPtr make_transformed_lines(const LineSeries& series);

}  // namespace kalfem
