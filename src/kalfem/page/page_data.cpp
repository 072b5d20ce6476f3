// SPDX-License-Identifier: Apache-2.0
#include "kalfem/page/page.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>

#include "kalfem/page/typeset.hpp"

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

namespace {

using Json = nlohmann::ordered_json;
using Rows = std::vector<std::size_t>;

constexpr int x_digits = 10;  ///< a million samples stay apart
constexpr int y_digits = 7;   ///< finer than any screen or printer

/// The number with so many significant digits, which also shortens its text; null for a gap.
Json rounded(double value, int digits) {
  if (!std::isfinite(value)) return nullptr;
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::scientific, digits - 1).ptr;
  std::from_chars(text, end, value);
  return value;
}

Json picked(const std::vector<double>& values, const Rows& rows, int digits) {
  Json list = Json::array();
  if (values.empty()) return list;
  for (const std::size_t k : rows) list.push_back(rounded(values[k], digits));
  return list;
}

const char* name(Role role) {
  switch (role) {
    case Role::truth:
      return "truth";
    case Role::estimate:
      return "estimate";
    case Role::measured:
      return "measured";
    case Role::predicted:
      return "predicted";
    case Role::initial:
      return "initial";
    case Role::limit:
      return "limit";
    case Role::other:
      break;
  }
  return "other";
}

/// Every line of the chart, the edges of bands included.
std::vector<std::span<const double>> curves(const Chart& chart) {
  std::vector<std::span<const double>> all;
  for (const auto& series : chart.series) {
    for (const auto* values : {&series.y, &series.lower, &series.upper}) {
      if (!values->empty()) all.emplace_back(*values);
    }
  }
  return all;
}

/// Rows common to all curves. The part shown first has the full number of points to itself, so that it stays sharp.
Rows rows_of(const Chart& chart) {
  const auto all = curves(chart);
  const auto& x = chart.x;
  std::size_t from = 0;
  std::size_t to = x.size();
  if (chart.x_window) {
    from = static_cast<std::size_t>(std::lower_bound(x.begin(), x.end(), chart.x_window->front()) - x.begin());
    to = static_cast<std::size_t>(
        std::upper_bound(x.begin() + static_cast<std::ptrdiff_t>(from), x.end(), chart.x_window->back()) - x.begin());
  }
  Rows rows;
  for (const auto& [begin, end] : {std::pair{std::size_t{0}, from}, std::pair{from, to}, std::pair{to, x.size()}}) {
    const Rows part = rows_to_draw(all, begin, end, report_points);
    rows.insert(rows.end(), part.begin(), part.end());
  }
  return rows;
}

/// Points of a path: its extremes along both axes.
Rows rows_of(const Series& path) {
  const std::span<const double> both[] = {path.x, path.y};
  return rows_to_draw(both, 0, path.y.size(), report_points);
}

Json as_json(const Series& series, const Rows& rows, bool scatter) {
  Json json{{"label", typeset(series.label)}, {"role", name(series.role)}, {"y", picked(series.y, rows, y_digits)}};
  if (scatter) json["x"] = picked(series.x, rows, y_digits);
  if (series.points) json["points"] = true;
  if (!series.lower.empty()) {
    json["lower"] = picked(series.lower, rows, y_digits);
    json["upper"] = picked(series.upper, rows, y_digits);
  }
  return json;
}

Json as_json(const Chart& chart) {
  Json json{{"scatter", chart.scatter}, {"x_label", typeset(chart.x_label)}, {"y_label", typeset(chart.y_label)}};
  if (chart.x_window) json["x_window"] = *chart.x_window;
  if (chart.y_window) json["y_window"] = *chart.y_window;
  const Rows rows = chart.scatter ? Rows{} : rows_of(chart);
  if (!chart.scatter) json["x"] = picked(chart.x, rows, x_digits);
  json["series"] = Json::array();
  for (const auto& series : chart.series) {
    json["series"].push_back(as_json(series, chart.scatter ? rows_of(series) : rows, chart.scatter));
  }
  return json;
}

/// Inside JSON these characters stand only in strings, where a \u escape means the same.
std::string safe_inside_html(const std::string& json) {
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    switch (c) {
      case '<':
        safe += "\\u003c";
        break;
      case '>':
        safe += "\\u003e";
        break;
      case '&':
        safe += "\\u0026";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

/// The items of one kind in the order of the page.
template <typename Item>
std::string items_as_json(const Page& page) {
  Json list = Json::array();
  for (const auto& section : page.sections)
    for (const auto& item : section.items)
      if (const auto* wanted = std::get_if<Item>(&item)) list.push_back(as_json(*wanted));
  return safe_inside_html(list.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace

std::string charts_as_json(const Page& page) { return items_as_json<Chart>(page); }
std::string scenes_as_json(const Page& page) { return items_as_json<Scene>(page); }

}  // namespace kalfem
