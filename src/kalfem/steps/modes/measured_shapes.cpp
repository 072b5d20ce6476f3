// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/modes/measured_shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "kalfem/page/words.hpp"
#include "kalfem/pictures/nodal_translations.hpp"
#include "kalfem/study/candidate_nodes.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::VectorXd;

/// One entry of the measured shapes on the mesh.
struct MeasuredPlace {
  Index entry = 0;      ///< of the shape
  Index node = 0;       ///< of the mesh
  Index place = 0;      ///< in MeasuredShapes::nodes
  int direction = 0;    ///< x, y, z
  double weight = 1.0;  ///< the entry is weight times the translation
};

std::vector<MeasuredPlace> places_of(const CorrelatedComparison& comparison, const FiniteElementPart& part,
                                     std::vector<Index>& nodes) {
  std::vector<MeasuredPlace> places;
  for (std::size_t i = 0; i < comparison.points.size(); ++i) {
    if (comparison.points[i].size() != 1) continue;
    const auto& [dof, weight] = *comparison.points[i].begin();
    const auto found = candidate_nodes(part, dof, 0.0);
    if (!found || found->of_region || found->nodes.size() != 1 || found->directions.size() != 1 || weight == 0.0 ||
        found->directions.front() > 2)
      continue;
    const Index node = found->nodes.front();
    auto at = std::ranges::find(nodes, node);
    if (at == nodes.end()) at = nodes.insert(nodes.end(), node);
    places.push_back({static_cast<Index>(i), node, at - nodes.begin(), found->directions.front(), weight});
  }
  return places;
}

/// The least-squares factor of the measured entries; nothing where they and the model's share nothing.
std::optional<double> scale_of(const VectorXd& measured, const Matrix3Xd& model,
                               const std::vector<MeasuredPlace>& places) {
  double mixed = 0.0, size = 0.0;
  for (const auto& at : places) {
    const double value = measured[at.entry];
    if (!std::isfinite(value)) continue;
    mixed += value * at.weight * model(at.direction, at.node);
    size += value * value;
  }
  return size > 0.0 && mixed != 0.0 ? std::optional(mixed / size) : std::nullopt;
}

}  // namespace

std::vector<Index> measured_nodes(const CorrelatedComparison& comparison, const FiniteElementPart& part) {
  std::vector<Index> nodes;
  places_of(comparison, part, nodes);
  return nodes;
}

MeasuredShapes measured_shapes(const CorrelatedComparison& comparison, const FiniteElementPart& part,
                               const SubstructureModes& modes) {
  MeasuredShapes shapes;
  const auto places = places_of(comparison, part, shapes.nodes);
  const Index low = (modes.frequencies.array() <= comparison.above).count();
  for (const auto& pair : comparison.correlation.pairs) {
    const Index mode = low + pair.model_mode.value_or(0) - 1;
    const auto& measured = comparison.measured[pair.measured].shape;
    if (!pair.model_mode || mode >= modes.shapes.cols() || measured.size() == 0) continue;
    const Matrix3Xd model = nodal_translations(part, modes.shapes.col(mode));
    const auto scale = scale_of(measured, model, places);
    if (!scale) continue;
    Matrix3Xd displacement = Matrix3Xd::Zero(3, std::ssize(shapes.nodes));
    for (const auto& at : places)
      if (std::isfinite(measured[at.entry]))
        displacement(at.direction, at.place) = *scale * measured[at.entry] / at.weight;
    shapes.pairs.push_back(
        {fmt::format("measured {} Hz over mode {}, {} Hz, MAC {:.3f}", four_digits(pair.measured_frequency), mode + 1,
                     four_digits(pair.model_frequency), pair.mac),
         mode, std::move(displacement)});
  }
  return shapes;
}

}  // namespace kalfem
