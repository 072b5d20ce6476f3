#include "kalfem/report/decimate.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kalfem {
namespace {

/// Appends the rows of [begin, end) at which `curve` is lowest and highest; the first row when it is nowhere finite.
void append_extremes(std::span<const double> curve, std::size_t begin, std::size_t end,
                     std::vector<std::size_t>& rows) {
  std::size_t lowest = end;
  std::size_t highest = end;
  for (std::size_t k = begin; k < end; ++k) {
    if (!std::isfinite(curve[k])) continue;
    if (lowest == end || curve[k] < curve[lowest]) lowest = k;
    if (highest == end || curve[k] > curve[highest]) highest = k;
  }
  rows.push_back(lowest == end ? begin : lowest);
  rows.push_back(highest == end ? begin : highest);
}

/// The first and the last row of [begin, end) and the extremes of each curve in each of so many buckets.
std::vector<std::size_t> extremes(std::span<const std::span<const double>> curves, std::size_t begin, std::size_t end,
                                  std::size_t buckets) {
  std::vector<std::size_t> rows{begin, end - 1};
  for (std::size_t b = 0; b < buckets; ++b) {
    const std::size_t from = begin + b * (end - begin) / buckets;
    const std::size_t to = begin + (b + 1) * (end - begin) / buckets;
    for (const auto& curve : curves) append_extremes(curve, from, to, rows);
  }
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

}  // namespace

std::vector<std::size_t> rows_to_draw(std::span<const std::span<const double>> curves, std::size_t begin,
                                      std::size_t end, std::size_t limit) {
  if (end - begin <= limit) {
    std::vector<std::size_t> all(end - begin);
    std::iota(all.begin(), all.end(), begin);
    return all;
  }
  // Curves that move together share most of their extremes, so start from what a single curve could use.
  std::size_t buckets = std::max<std::size_t>(1, limit / 2);
  auto rows = extremes(curves, begin, end, buckets);
  while (rows.size() > limit && buckets > 1) {
    buckets = buckets * 3 / 4;
    rows = extremes(curves, begin, end, buckets);
  }
  return rows;
}

}  // namespace kalfem
