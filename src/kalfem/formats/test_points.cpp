// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/test_points.hpp"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <set>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/measured_file_reader.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

std::vector<std::string_view> cells_of(std::string_view line) {
  const char separator = line.find(';') != std::string_view::npos    ? ';'
                         : line.find('\t') != std::string_view::npos ? '\t'
                                                                     : ',';
  std::vector<std::string_view> cells;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find(separator, at), line.size());
    cells.push_back(trimmed(line.substr(at, end - at)));
    at = end + 1;
  }
  return cells;
}

std::optional<double> number_in(std::string_view cell) {
  if (cell.starts_with('+')) cell.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc{} || end != cell.data() + cell.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Unit vectors at right angles, right-handed, within what two digits round.
bool are_axes(const Eigen::Matrix3d& axes) {
  return (axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm() < 0.05 && axes.determinant() > 0.0;
}

/// The row as a point; nothing of a line of titles.
std::optional<TestPoint> point_of(const TextLine& line, double unit, bool is_first, const std::string& source,
                                  IssueList& issues) {
  const auto cells = cells_of(line.text);
  const auto refuse = [&](const std::string& what, const std::string& why) -> std::optional<TestPoint> {
    issues.add({source, line.number}, what, why, "write name, x, y, z, and nine numbers of axes where they are turned");
    return std::nullopt;
  };
  if (is_first && cells.size() > 1 && !number_in(cells[1])) return std::nullopt;
  if (cells.size() != 4 && cells.size() != 13)
    return refuse(fmt::format("the row has {} cells", cells.size()), "a point has 4, or 13 with its axes");
  std::vector<double> numbers;
  for (std::size_t i = 1; i < cells.size(); ++i) {
    const auto number = number_in(cells[i]);
    if (!number) return refuse("'" + std::string(cells[i].substr(0, 40)) + "' is not a number", "");
    numbers.push_back(*number);
  }
  TestPoint point{.name = std::string(cells[0]), .place = unit * Eigen::Vector3d(numbers[0], numbers[1], numbers[2])};
  if (numbers.size() > 3) {
    point.axes = Eigen::Map<const Eigen::Matrix3d>(numbers.data() + 3);
    for (auto axis : point.axes.colwise()) axis.normalize();
    if (!are_axes(point.axes))
      return refuse("the axes of '" + point.name + "' are not right-handed at right angles", "they turn the sensor");
  }
  return point;
}

std::vector<TestPoint> points_of_table(const std::filesystem::path& file, double unit) {
  const std::string text = read_text(file);
  std::vector<TestPoint> points;
  IssueList issues;
  std::set<std::string> names;
  bool is_first = true;
  for (const auto& line : split_lines(text)) {
    if (trimmed(line.text).empty() || line.text.starts_with('#')) continue;
    auto point = point_of(line, unit, is_first, file.string(), issues);
    is_first = false;
    if (!point) continue;
    if (!names.insert(point->name).second)
      issues.add({file.string(), line.number}, "the point '" + point->name + "' is given twice", "names must be unique",
                 "rename one");
    points.push_back(std::move(*point));
  }
  issues.raise();
  return points;
}

std::vector<TestPoint> points_of_bench(const std::filesystem::path& file, double unit) {
  std::vector<TestPoint> points;
  for (const auto& node : read_measured_file(file).nodes)
    points.push_back({.name = std::to_string(node.number),
                      .place = unit * Eigen::Vector3d(node.position[0], node.position[1], node.position[2])});
  return points;
}

}  // namespace

std::vector<TestPoint> read_test_points(const std::filesystem::path& file, double unit) {
  auto points = measured_format(file) ? points_of_bench(file, unit) : points_of_table(file, unit);
  if (points.empty())
    throw InvalidInput(Issue{{file.string(), 0},
                             "the file has no points",
                             "coordinates are datasets 15 and 2411 of a universal file, or rows of a table",
                             "export the test's geometry"});
  return points;
}

}  // namespace kalfem
