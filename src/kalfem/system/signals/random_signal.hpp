// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

/// The multiples of 1 / duration inside [lower, upper] (edges included): the spectral lines of a signal that repeats
/// after `duration`.
struct LineGrid {
  double lower = 0.0;     ///< [Hz]
  double upper = 0.0;     ///< [Hz]
  double duration = 1.0;  ///< [s]
};

/// Adds an issue when the band holds no line, or more than fit in memory.
void require_lines(IssueList& issues, const std::string& signal, const LineGrid& grid);

/// Number of the lowest line: its frequency is this / duration. The grid must have passed require_lines.
std::int64_t first_line(const LineGrid& grid);

/// Frequencies of the lines [Hz], rising. The grid must have passed require_lines.
std::vector<double> line_frequencies(const LineGrid& grid);

/// Stationary random signal with a flat spectrum between two frequencies and nothing outside.
///
///     x(t) = rms sqrt(2 / L) sum_l sin(2 pi f_l t + phi_l),   f_l = the L multiples of 1 / duration inside the band,
///
/// phi_l uniform: Gaussian in the limit of many lines, with exactly the asked RMS over the duration, after which it
/// repeats. The fade-in multiplies its beginning, which lowers the RMS of that part.
struct RandomSignalOptions {
  double rms = 1.0;               ///< [unit of the signal]
  double lower = 0.5;             ///< lower edge of the band [Hz]
  double upper = 30.0;            ///< upper edge of the band [Hz]
  double duration = 20.0;         ///< period, and 1 / the spacing of the lines [s]
  double fade_in = 0.5;           ///< time of the smooth start from rest at t = 0 [s]; 0: none
  bool integrated_twice = false;  ///< the signal is the second derivative of what is made, line by line; the fade-in
                                  ///< then acts on that displacement, so that it starts from rest and does not drift
  std::uint64_t seed = 1;
  std::string name = "random";  ///< names the random stream: other names give independent signals of one seed
};

IssueList validate(const RandomSignalOptions& options);
SignalPtr make_random(const RandomSignalOptions& options);

/// Vertical displacement [m] under a wheel that rolls over a road of ISO 8608 at constant speed.
///
/// One-sided displacement spectrum over the spatial frequency n:  Gd(n) = Gd(n0) (n / n0)^-2,  n0 = 0.1 cycles/m, with
/// Gd(n0) the geometric mean of the class: 16e-6 m^3 for A, four times more for each class after it. The profile is
///     r(t) = sum_l sqrt(2 Gd(n_l) dn) sin(2 pi n_l v t + phi_l),   n_l = the multiples of dn = 1/(v duration) in the
///     band,
/// phi_l uniform, and repeats after the duration.
/// Source: ISO 8608:2016, annex B; spectral representation: Shinozuka and Jan, J. Sound Vib. 25 (1972) 111-128.
struct RoadProfileOptions {
  char road_class = 'C';   ///< 'A' (very good) to 'H'
  double speed = 20.0;     ///< [m/s]
  double lower = 0.011;    ///< lowest spatial frequency [cycles/m]
  double upper = 2.83;     ///< highest spatial frequency [cycles/m]
  double duration = 20.0;  ///< [s]
  double fade_in = 0.5;    ///< time of the smooth start from the level at t = 0 [s]; 0: none
  std::uint64_t seed = 1;
  std::string name = "road";  ///< names the random stream: left and right wheel paths need two names
};

IssueList validate(const RoadProfileOptions& options);
SignalPtr make_road_profile(const RoadProfileOptions& options);

/// Gd(n) of the class [m^3], n in cycles/m.
double road_spectrum(char road_class, double spatial_frequency);

}  // namespace kalfem
