#pragma once

#include <cstdint>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

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
