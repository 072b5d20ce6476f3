#include "kalfem/system/signals/line_grid.hpp"

#include <cmath>

#include "kalfem/system/option_checks.hpp"

namespace kalfem {

namespace {

constexpr double most_lines = 2e6;       ///< about 100 bytes each
constexpr double edge_tolerance = 1e-9;  // of a line spacing: an edge that is a multiple but for rounding belongs to it

double lowest_line(const LineGrid& grid) { return std::ceil(grid.lower * grid.duration - edge_tolerance); }
double last_line(const LineGrid& grid) { return std::floor(grid.upper * grid.duration + edge_tolerance); }

}  // namespace

void require_lines(IssueList& issues, const std::string& signal, const LineGrid& grid) {
  const double count = last_line(grid) - lowest_line(grid) + 1.0;
  const std::string band = "[" + shown(grid.lower) + ", " + shown(grid.upper) + "] Hz";
  if (!(count >= 1.0))
    issues.add({}, signal + ": no multiple of 1/duration = " + shown(1.0 / grid.duration) + " Hz lies in " + band,
               "the signal is a sum of lines with this spacing", "widen the band or lengthen the duration");
  if (count > most_lines)
    issues.add({}, signal + ": " + band + " over " + shown(grid.duration) + " s needs " + shown(count) + " lines",
               "at most " + shown(most_lines) + " can be computed", "narrow the band or shorten the duration");
}

std::int64_t first_line(const LineGrid& grid) { return static_cast<std::int64_t>(lowest_line(grid)); }

std::vector<double> line_frequencies(const LineGrid& grid) {
  std::vector<double> frequencies;
  for (double line = lowest_line(grid); line <= last_line(grid); ++line) frequencies.push_back(line / grid.duration);
  return frequencies;
}

}  // namespace kalfem
