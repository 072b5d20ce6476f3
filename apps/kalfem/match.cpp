// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/correlation/point_match.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/formats/test_points.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/pictures/mesh_picture.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

using Json = nlohmann::ordered_json;

std::int64_t number_of(const Mesh& mesh, Eigen::Index node) { return mesh.node_ids[static_cast<std::size_t>(node)]; }

std::string millimetres(double length) { return fmt::format("{:.1f}", 1e3 * length); }

Table match_table(const PointMatch& match, const Mesh& mesh) {
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

/// The turn as an axis and an angle, the shift, and how well the points fit.
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

/// Lines for a case: names of nodes, and each sensor's motion along an axis of the model.
std::string case_lines(const PointMatch& match, const Mesh& mesh, const std::string& substructure) {
  std::string nodes, points;
  for (const auto& point : match.points) {
    if (!point.sure) continue;
    nodes += fmt::format("{}p{}: {}", nodes.empty() ? "" : ", ", point.name, number_of(mesh, point.node));
    for (int axis = 0; axis < 3; ++axis) {
      const auto words = direction_words(point.axes.col(axis));
      if (words.size() != 2 || !match.others.empty()) continue;  // another position turns the sensors too
      points += fmt::format("{}p{}.{}: \"{}:{}{}\"", points.empty() ? "" : ", ", point.name, words[1], point.name,
                            words[0], "XYZ"[axis]);
    }
  }
  std::string text = fmt::format("substructures.{}.finite_elements:\n  nodes: {{{}}}\n", substructure, nodes);
  if (!points.empty()) text += fmt::format("update.compare.NAME, with `file`:\n  points: {{{}}}\n", points);
  return text;
}

Json to_json(const PlaceFit& fit) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < 3; ++i) rows.push_back(numbers(fit.rotation.row(i).transpose()));
  return {
      {"rotation", rows}, {"shift_m", numbers(fit.shift)}, {"scale", number(fit.scale)}, {"rms_m", number(fit.rms)}};
}

Json to_json(const PointMatch& match, const Mesh& mesh) {
  Json all{{"fit", to_json(match.fit)},
           {"noise_m", number(match.noise)},
           {"other_fits", Json::array()},
           {"points", Json::array()}};
  for (const auto& other : match.others) all["other_fits"].push_back(to_json(other));
  for (const auto& point : match.points) {
    Json axes = Json::array();
    for (const auto& axis : point.axes.colwise()) axes.push_back(numbers(Eigen::VectorXd(axis)));
    all["points"].push_back({{"name", point.name},
                             {"node", number_of(mesh, point.node)},
                             {"distance_m", number(point.distance)},
                             {"next_node", point.next < 0 ? Json(nullptr) : Json(number_of(mesh, point.next))},
                             {"next_distance_m", number(point.next_distance)},
                             {"probability", number(point.probability)},
                             {"sure", point.sure},
                             {"axes", axes}});
  }
  return all;
}

Page page_of(const PointMatch& match, const FiniteElementModel& model, const std::string& title) {
  MeshPictureOptions options{.plain = true};
  for (const auto& point : match.points)
    options.marks.push_back({point.sure ? MarkKind::point : MarkKind::finding, point.node, point.name});
  return {.title = title,
          .subtitle = counted(std::ssize(match.points), "point"),
          .status = match.sure() ? VerdictState::consistent : VerdictState::suspicious,
          .summary = match.sure() ? "Every point has its node." : doubts(match),
          .sections = {{"Position of the test",
                        capitalised(fit_words(match.fit)) + ".",
                        {Picture{.title = "Points on the model",
                                 .caption = "Rings: nodes of the points. Crosses: nodes that are not sure.",
                                 .svg = mesh_picture_svg(model.mesh, options)},
                         match_table(match, model.mesh)}}}};
}

}  // namespace

ExitCode match(const MatchArguments& arguments) {
  if (!arguments.page.empty()) require_writable(arguments.page);
  if (!is_deck(arguments.model))
    throw InvalidInput("'" + arguments.model + "' is not a deck", "nodes are those of a deck",
                       "name a .bdf, .dat, .nas or .inp file");
  const auto points = read_test_points(arguments.points, to_si("1 " + arguments.length, "m"));
  Deck deck = read_deck(arguments.model);
  to_si(deck.model, unit_system(arguments.units));
  const auto found =
      match_points(points, deck.model.mesh, {.scale = arguments.scale, .noise = 1e-3 * arguments.noise.value_or(0.0)});
  const std::string name = std::filesystem::path(arguments.model).stem().string();
  if (arguments.as_json)
    print("{}\n", to_json(found, deck.model.mesh).dump(2, ' ', false, Json::error_handler_t::replace));
  else
    print("The test is {}\n\n{}\n{}{}", fit_words(found.fit), to_text(match_table(found, deck.model.mesh)),
          doubts(found), case_lines(found, deck.model.mesh, name));
  if (!arguments.page.empty())
    write_file_atomically(
        arguments.page,
        render_html(
            page_of(found, deck.model, std::filesystem::path(arguments.points).filename().string() + " on " + name)));
  return found.sure() ? done : not_usable;
}

}  // namespace kalfem::command
