// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

namespace kalfem::benchmarks {

/// Seconds that the work takes; what it returns is dropped.
template <typename Work>
double seconds(Work work) {
  const auto begin = std::chrono::steady_clock::now();
  (void)work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

inline double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

/// A line of this process's /proc/self/status in MB: VmRSS, what is resident; VmHWM, its peak.
inline double memory_megabytes(const std::string& which) {
  std::ifstream status("/proc/self/status");
  std::string word;
  double kilobytes = 0.0;
  while (status >> word)
    if (word == which + ":") status >> kilobytes;
  return kilobytes / 1024.0;
}

/// Gives freed memory back and begins a new peak.
inline void forget_peak() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";
}

inline void line(const char* what, double value, const char* unit) {
  std::printf("%-58s %10.4g %s\n", what, value, unit);
}

}  // namespace kalfem::benchmarks
