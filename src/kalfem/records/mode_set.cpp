// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/mode_set.hpp"

#include <algorithm>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// "-a3" and "12:-Z" look against a3 and 12:+Z.
std::string opposite(std::string name) {
  if (name.starts_with('-')) return name.substr(1);
  if (const auto sign = name.find(":-"); sign != std::string::npos) name[sign + 1] = '+';
  return name;
}

struct Row {
  Index number = 0;
  double sign = 1.0;
};

std::vector<Row> rows_of(const ModeSet& set, const std::vector<std::string>& points) {
  std::vector<Row> rows;
  IssueList issues;
  const auto find = [&](const std::string& name) { return std::ranges::find(set.points, name); };
  for (const auto& point : points) {
    auto found = find(point);
    const bool against = found == set.points.end();
    if (against) found = find(opposite(point));
    if (found == set.points.end())
      issues.add({}, "the modes were not measured at '" + point + "'" + did_you_mean(point, set.points), "",
                 "`kalfem inspect` lists what the file holds");
    else
      rows.push_back({found - set.points.begin(), against ? -1.0 : 1.0});
  }
  issues.raise();
  return rows;
}

}  // namespace

ModeSet at_points(const ModeSet& set, const std::vector<std::string>& points) {
  const auto rows = rows_of(set, points);
  const Index count = std::ssize(rows), all = std::ssize(set.points);
  ModeSet taken{.points = points, .nodes = set.nodes};
  std::vector<Index> numbers;
  Eigen::VectorXd signs(2 * count);
  for (Index i = 0; i < count; ++i) {
    const auto& [number, sign] = rows[static_cast<std::size_t>(i)];
    numbers.push_back(number);
    signs[i] = signs[count + i] = sign;
    if (set.places.empty()) continue;
    taken.places.push_back(set.places[static_cast<std::size_t>(number)]);
    if (sign < 0.0) taken.places.back().direction *= -1;
  }
  std::vector<Index> parts = numbers;
  for (const Index number : numbers) parts.push_back(all + number);
  for (ModeSet::Mode mode : set.modes) {
    mode.shape = mode.shape(numbers).cwiseProduct(signs.head(count)).eval();
    if (mode.shape_covariance.size() > 0)
      mode.shape_covariance = (signs.asDiagonal() * mode.shape_covariance(parts, parts) * signs.asDiagonal()).eval();
    taken.modes.push_back(std::move(mode));
  }
  return taken;
}

}  // namespace kalfem
