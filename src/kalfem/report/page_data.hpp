#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "kalfem/report/page.hpp"

namespace kalfem {

/// Rows of [begin, end) to draw so that no curve loses a peak, ascending, at most `limit` of them
/// (more only when even the whole range's extremes are more).
///
/// The range is cut into buckets of equal length; of each bucket the rows stay at which some curve has its minimum or
/// its maximum, so what is drawn are true samples at their true places. A bucket in which a curve has no finite value
/// keeps its first row, so that the gap is seen. The first and the last row stay; nothing is dropped when
/// end - begin <= limit. All curves have at least `end` values.
std::vector<std::size_t> rows_to_draw(std::span<const std::span<const double>> curves, std::size_t begin,
                                      std::size_t end, std::size_t limit);

/// The charts of a page, in the order of their appearance, as a JSON array that may stand inside a script element:
/// thinned to about `report_points` rows, gaps as null, "<", ">" and "&" escaped.
std::string charts_as_json(const Page& page);

}  // namespace kalfem
