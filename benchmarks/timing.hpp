#pragma once

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
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

/// Of this process so far.
inline double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

inline void line(const char* what, double value, const char* unit) {
  std::printf("%-58s %10.4g %s\n", what, value, unit);
}

}  // namespace kalfem::benchmarks
