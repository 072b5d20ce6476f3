#pragma once

#include <cstdint>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

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

}  // namespace kalfem
