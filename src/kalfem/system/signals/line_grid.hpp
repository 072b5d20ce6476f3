#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"

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

}  // namespace kalfem
