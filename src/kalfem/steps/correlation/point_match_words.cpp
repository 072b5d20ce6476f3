// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/correlation/point_match_words.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "kalfem/page/words.hpp"

namespace kalfem {
namespace {

std::int64_t number_of(const Mesh& mesh, Eigen::Index node) { return mesh.node_ids[static_cast<std::size_t>(node)]; }

std::string millimetres(double length) { return fmt::format("{:.1f}", 1e3 * length); }

}  // namespace

Table point_match_table(const PointMatch& match, const Mesh& mesh) {
  Table table{
      "Points of the test at nodes of the model",
      {"point", "node", "distance [mm]", "next node", "distance [mm]", "probability", "x looks", "y looks", "z looks"},
      {},
      {}};
  for (const auto& point : match.points) {
    std::vector<std::string> row = {point.name,
                                    std::to_string(number_of(mesh, point.node)),
                                    millimetres(point.distance),
                                    point.next < 0 ? "-" : std::to_string(number_of(mesh, point.next)),
                                    point.next < 0 ? "-" : millimetres(point.next_distance),
                                    (point.sure ? "" : "not sure: ") + fmt::format("{:.3g}", point.probability)};
    for (const auto& axis : point.axes.colwise()) row.push_back(direction_words(axis));
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string fit_words(const PlaceFit& fit) {
  const Eigen::AngleAxisd turn(fit.rotation);
  const auto place = [&](int axis) { return std::abs(fit.shift[axis]) < 1e-9 ? 0.0 : fit.shift[axis]; };
  return fmt::format(
      "turned by {:.2f} deg about {}, shifted by ({:.4g}, {:.4g}, {:.4g}) m{}; {} mm from the nodes (rms)",
      turn.angle() * 180.0 / std::numbers::pi, direction_words(turn.axis()), place(0), place(1), place(2),
      fit.scale == 1.0 ? "" : fmt::format(", lengths times {:.4f}", fit.scale), millimetres(fit.rms));
}

std::string doubts(const PointMatch& match) {
  std::string text;
  if (!match.others.empty()) {
    text += fmt::format("The structure allows {} as well (it is symmetric, or the points do not reach its edges):\n",
                        counted(std::ssize(match.others), "other position"));
    for (const auto& other : match.others) text += "  " + fit_words(other) + "\n";
    text += "Measure a point that is on one side only, or take the position that you know.\n";
  }
  std::string unsure;
  for (const auto& point : match.points)
    if (!point.sure) unsure += (unsure.empty() ? "" : ", ") + point.name;
  if (!unsure.empty()) text += "Not sure: " + unsure + "\n";
  return text;
}

}  // namespace kalfem
