// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

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
#include "kalfem/steps/correlation/point_match_words.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

using Json = nlohmann::ordered_json;

std::int64_t number_of(const Mesh& mesh, Eigen::Index node) { return mesh.node_ids[static_cast<std::size_t>(node)]; }

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
                         point_match_table(match, model.mesh)}}}};
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
    print("The test is {}\n\n{}\n{}{}", fit_words(found.fit), to_text(point_match_table(found, deck.model.mesh)),
          doubts(found), case_lines(found, deck.model.mesh, name));
  if (!arguments.page.empty())
    write_file_atomically(
        arguments.page,
        render_html(
            page_of(found, deck.model, std::filesystem::path(arguments.points).filename().string() + " on " + name)));
  return found.sure() ? done : not_usable;
}

}  // namespace kalfem::command
