#include <algorithm>
#include <cstdio>

#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

namespace {

constexpr double static_tolerance = 1e-6;
constexpr double frequency_tolerance = 1e-2;
constexpr double least_mac = 0.9;

std::string hertz(double frequency) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g Hz", frequency);
  return text;
}

}  // namespace

std::vector<std::string> reduction_warnings(const ReductionErrorIndicators& error_indicators, double excitation_band,
                                            double sensor_bandwidth) {
  std::vector<std::string> warnings;
  const double left_out = error_indicators.next_left_out;
  if (left_out > 0.0 && left_out < excitation_band)
    warnings.push_back("the first mode left out, at " + hertz(left_out) + ", is inside the band of the excitation, " +
                       hertz(excitation_band) +
                       ": the excitation causes motion that the reduced model cannot represent");
  if (left_out > 0.0 && left_out < 3.0 * sensor_bandwidth)
    warnings.push_back("the kept modes end below " + hertz(left_out) + ", less than three times the sensors' " +
                       "bandwidth of " + hertz(sensor_bandwidth) + ": keep modes up to " +
                       hertz(3.0 * sensor_bandwidth) + ", better up to " + hertz(6.0 * sensor_bandwidth));
  for (const auto& mode : error_indicators.modes) {
    if (mode.full > sensor_bandwidth) break;
    const bool frequency_off = mode.reduced - mode.full > frequency_tolerance * mode.full;
    if (!frequency_off && mode.mac >= least_mac) continue;
    char mac[16];
    std::snprintf(mac, sizeof mac, "%.2f", mode.mac);
    warnings.push_back("the mode of the full model at " + hertz(mode.full) + ", inside the sensors' bandwidth, is at " +
                       hertz(mode.reduced) + " in the reduced model, with a MAC of " + mac +
                       ": keep more modes or add boundary nodes");
  }
  if (error_indicators.static_error > static_tolerance)
    warnings.push_back("the constraint modes leave " + std::to_string(error_indicators.static_error) +
                       " of the boundary forces unbalanced: the stiffness of the interior is almost singular");
  return warnings;
}

}  // namespace kalfem
