// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/correlation/expanded_shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/pictures/mesh_picture.hpp"
#include "kalfem/pictures/nodal_translations.hpp"
#include "kalfem/pictures/scene_places.hpp"
#include "kalfem/steps/modes/measured_shapes.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

constexpr std::size_t most_faces = 20000, most_shapes = 40;
constexpr double gap = 0.25;  ///< between the copies, of the diagonal

const PairedMode& pair_of(const ExpandedShape& shape, const CorrelatedComparison& comparison) {
  return comparison.correlation.pairs[shape.measured];
}

/// "0.512 +- 0.004", with as many decimals as the deviation has two digits of.
std::string with_deviation(double value, double deviation) {
  const int decimals = deviation > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(deviation))), 0, 9) : 4;
  return fmt::format("{:.{}f} +- {:.{}f}", value, decimals, deviation, decimals);
}

Table expanded_table(const CorrelatedComparison& comparison) {
  Table table{.title = "Measured shapes at all points",
              .columns = {"point"},
              .caption = "In the scale of the measured shapes, with one standard deviation."};
  for (const auto& shape : comparison.correlation.expansion.shapes)
    table.columns.push_back(four_digits(pair_of(shape, comparison).measured_frequency) + " Hz");
  for (const auto& point : comparison.reported) {
    std::vector<std::string> row = {point.name};
    for (const auto& shape : comparison.correlation.expansion.shapes)
      row.push_back(
          with_deviation(point.weight * shape.shape[point.dof], std::abs(point.weight) * shape.deviation[point.dof]));
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Where the second copy of a mesh stands: beside the first, along the second longest of its sides.
Vector3d beside(const Matrix3Xd& nodes) {
  const Vector3d sides = nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff();
  std::array<int, 3> axes = {0, 1, 2};
  std::ranges::stable_sort(axes, std::greater(), [&](int axis) { return sides[axis]; });
  return (sides[axes[1]] + gap * sides.norm()) * Vector3d::Unit(axes[1]);
}

}  // namespace

std::string mixing_words(const ShapeExpansion& expansion) {
  if (expansion.shapes.empty()) return "";
  return fmt::format(
      "  Shapes differ as by a stiffness that is wrong by {}, and by noise of {:.3g} times what is stated.\n"
      "  Band: deviation of the whole shape, expanded to all points ({}).\n\n",
      fmt::format("{:.2g} %", 100.0 * expansion.mixing.stiffness_error), expansion.mixing.noise,
      word_of(expansion.method));
}

Json expansion_json(const CorrelatedComparison& comparison) {
  const auto& expansion = comparison.correlation.expansion;
  if (expansion.shapes.empty()) return {};
  Json modes = Json::array(), points = Json::object();
  for (const auto& shape : expansion.shapes)
    modes.push_back(
        {{"measured_hz", number(pair_of(shape, comparison).measured_frequency)}, {"band", number(shape.band)}});
  for (const auto& point : comparison.reported) {
    Json values = Json::array(), deviations = Json::array();
    for (const auto& shape : expansion.shapes) {
      values.push_back(number(point.weight * shape.shape[point.dof]));
      deviations.push_back(number(std::abs(point.weight) * shape.deviation[point.dof]));
    }
    points[point.name] = {{"shape", values}, {"std", deviations}};
  }
  return {{"method", word_of(expansion.method)},
          {"stiffness_error", number(expansion.mixing.stiffness_error)},
          {"noise", number(expansion.mixing.noise)},
          {"modes", modes},
          {"points", points}};
}

std::optional<Scene> side_by_side(const CorrelatedComparison& comparison) {
  const auto& shapes = comparison.correlation.expansion.shapes;
  if (!comparison.part || shapes.empty()) return std::nullopt;
  const auto& part = *comparison.part;
  const auto regions = drawn_regions(part.elements);
  ScenePlaces places(part.elements.mesh, regions, most_faces);
  if (places.faces().empty()) return std::nullopt;
  Scene scene{.title = "Measured and model: '" + comparison.name + "'",
              .caption =
                  "One copy of the mesh takes the measured shape, expanded to all nodes, with its sensors; the "
                  "other, beside it, the mode of the model in the same scale.",
              .regions = regions};
  for (const Index node : measured_nodes(comparison, part))
    scene.marks.push_back({SceneMarkKind::sensor, places.of(node), ""});
  const Eigen::SparseMatrix<double> averaging = places.averaging();
  const Matrix3Xd once = part.elements.mesh.nodes * averaging;
  const Index count = once.cols();
  scene.places.resize(3, 2 * count);
  scene.places << once, once.colwise() + beside(part.elements.mesh.nodes);
  scene.faces = places.faces();
  for (auto face : places.faces()) {
    for (auto& node : face.nodes) node += count;
    scene.faces.push_back(face);
  }
  for (const auto& shape : shapes) {
    if (scene.fields.size() == most_shapes) break;
    MatrixXd both(6 * count, 1);
    both << (nodal_translations(part, shape.shape) * averaging).reshaped(),
        (nodal_translations(part, shape.model) * averaging).reshaped();
    const auto& pair = pair_of(shape, comparison);
    scene.fields.push_back(
        {.name = fmt::format("measured {} Hz beside mode {}, {} Hz, MAC {:.3f}", four_digits(pair.measured_frequency),
                             *pair.model_mode, four_digits(pair.model_frequency), pair.mac),
         .shapes = std::move(both)});
  }
  return scene;
}

void add_expanded_shapes(const CorrelatedComparison& comparison, Section& section) {
  if (comparison.correlation.expansion.shapes.empty()) return;
  if (auto scene = side_by_side(comparison)) section.items.emplace_back(std::move(*scene));
  if (!comparison.reported.empty()) section.items.emplace_back(expanded_table(comparison));
}

}  // namespace kalfem
