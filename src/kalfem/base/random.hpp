// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>
#include <string_view>

namespace kalfem {

/// A reproducible stream of random numbers: the same seed and name give the same numbers on every machine, and streams
/// of different names are independent, so adding a sensor does not change the noise of the others.
class RandomStream {
public:
  RandomStream(std::uint64_t seed, std::string_view name);

  /// Uniform in [0, 1), 53 random bits.
  double uniform();
  /// Standard normal by the polar method of Marsaglia (1964).
  double normal();

private:
  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace kalfem
