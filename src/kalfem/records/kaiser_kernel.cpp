// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/kaiser_kernel.hpp"

#include <cmath>
#include <numbers>

namespace kalfem {

namespace {

constexpr double window_shape = 10.06;  ///< Kaiser's beta for 100 dB

double sinc(double x) { return x == 0.0 ? 1.0 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x); }

}  // namespace

double windowed_sinc(double t, double cut_off, double half_length) {
  const double part = t / half_length;
  if (std::abs(part) >= 1.0) return 0.0;
  const double window =
      std::cyl_bessel_i(0.0, window_shape * std::sqrt(1.0 - part * part)) / std::cyl_bessel_i(0.0, window_shape);
  return sinc(2.0 * cut_off * t) * window;
}

}  // namespace kalfem
