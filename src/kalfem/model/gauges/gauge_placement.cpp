// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/gauges/gauge_placement.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>

#include "kalfem/model/gauges/nearest_place.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

std::string metres(double length) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g m", length);
  return text;
}

double size_of(const Mesh& mesh, const Cell& cell) {
  const Eigen::Matrix3Xd corners = corner_places(mesh, cell);
  double size = 0.0;
  for (Index i = 0; i < corners.cols(); ++i)
    size = std::max(size, (corners.colwise() - Vector3d(corners.col(i))).colwise().norm().maxCoeff());
  return size;
}

Vector3d normal_of(const Mesh& mesh, const Cell& cell) {
  const Eigen::Matrix3Xd corners = corner_places(mesh, cell);
  const Index last = corners.cols() - 1;
  const Vector3d first = corners.col(last == 3 ? 2 : 1) - corners.col(0);
  const Vector3d second = corners.col(last) - corners.col(last == 3 ? 1 : 0);
  return first.cross(second).normalized();
}

/// Looks one gauge's element up and checks what suits it.
class Placement {
public:
  Placement(const FiniteElementModel& model, const GaugeDescription& given) : model_(model), given_(given) {}

  StrainGauge place() const {
    const CellPlace found = std::holds_alternative<Vector3d>(given_.place) ? at_place() : at_centre();
    StrainGauge gauge{.name = given_.name, .cell = found.cell, .natural = found.natural};
    const Cell& cell = cell_at(found.cell);
    set_surface(cell, gauge);
    set_fibre(cell, gauge);
    set_direction(cell, gauge);
    return gauge;
  }

private:
  [[noreturn]] void refuse(const std::string& what, const std::string& why, const std::string& fix) const {
    throw InvalidInput("strain gauge '" + given_.name + "' " + what, why, fix);
  }

  [[nodiscard]] const Cell& cell_at(Index index) const { return model_.mesh.cells[static_cast<std::size_t>(index)]; }

  [[nodiscard]] std::string title(const Cell& cell) const {
    return "element " + std::to_string(cell.id) + ", a " + to_string(cell.shape);
  }

  /// Elements of the region, or of all that have a property.
  [[nodiscard]] std::vector<Index> elements() const {
    std::vector<std::string> known;
    std::vector<Index> cells;
    for (const auto& [region, property] : model_.properties) {
      known.push_back(region);
      if (!given_.region.empty() && given_.region != region) continue;
      const auto& own = model_.mesh.regions.at(region);
      cells.insert(cells.end(), own.begin(), own.end());
    }
    if (!given_.region.empty() && std::ranges::find(known, given_.region) == known.end())
      refuse("names the region '" + given_.region + "', which has no elements" + did_you_mean(given_.region, known), "",
             "name a region with a property");
    if (cells.empty())
      refuse("has no element to stand on", "the model has no elements, whose strains a gauge measures",
             "use a mesh or a deck");
    std::ranges::sort(cells);
    return cells;
  }

  [[nodiscard]] CellPlace at_centre() const {
    const auto number = std::get<std::int64_t>(given_.place);
    for (const Index index : elements())
      if (cell_at(index).id == number) return {index, natural_centre(cell_at(index).shape), 0.0};
    const std::string where = given_.region.empty() ? model_.mesh.source : "the region '" + given_.region + "'";
    refuse("stands on element " + std::to_string(number) + ", which is no beam, shell or solid of " + where,
           "a gauge measures the strain of one of these",
           "name one of its elements, or give the place as at: [x, y, z]");
  }

  [[nodiscard]] CellPlace at_place() const {
    const auto found = nearest_places(model_.mesh, elements(), std::get<Vector3d>(given_.place));
    const CellPlace& first = found.front();
    const Cell& cell = cell_at(first.cell);
    const double size = size_of(model_.mesh, cell);
    if (first.distance > size)
      refuse("lies " + metres(first.distance) + " away from the nearest element, " + std::to_string(cell.id),
             "the elements there are " + metres(size) + " large: the place lies outside the model",
             "give coordinates in metres (check the units of the model) or an element's number");
    for (const CellPlace& other : found) refuse_fold(cell, cell_at(other.cell));
    return first;
  }

  /// Shells that meet at an angle, or solids and beams beside them, have strains of their own at a common edge.
  void refuse_fold(const Cell& one, const Cell& other) const {
    constexpr double least_cosine = 0.9;  // 26 degrees
    const bool unlike = dimension(one.shape) != dimension(other.shape);
    const bool folded = !unlike && dimension(one.shape) == 2 &&
                        std::abs(normal_of(model_.mesh, one).dot(normal_of(model_.mesh, other))) < least_cosine;
    if (!unlike && !folded) return;
    refuse("lies where the elements " + std::to_string(one.id) + " and " + std::to_string(other.id) + " meet",
           unlike ? "they are of different kinds" : "they meet at an angle, and each has a strain of its own there",
           "move the place into one of them, or name its region");
  }

  void set_surface(const Cell& cell, StrainGauge& gauge) const {
    const bool shell = dimension(cell.shape) == 2;
    if (shell && !given_.surface)
      refuse("stands on " + title(cell) + ", and does not say on which side",
             "the strains of a shell's two sides differ by its bending",
             "write surface: top (by the element's normal, the right-hand rule of its nodes), middle or bottom");
    if (!shell && given_.surface)
      refuse("has a surface, but stands on " + title(cell), "only a shell has a top and a bottom",
             dimension(cell.shape) == 3 ? "remove it: the place itself says where in the solid"
                                        : "remove it, and give the fibre [y, z]");
    gauge.surface = given_.surface.value_or(Layer::solid);
  }

  void set_fibre(const Cell& cell, StrainGauge& gauge) const {
    if (given_.fibre && dimension(cell.shape) != 1)
      refuse("has a fibre, but stands on " + title(cell), "only a beam has fibres", "remove it");
    gauge.fibre = given_.fibre.value_or(Eigen::Vector2d::Zero());
  }

  void set_direction(const Cell& cell, StrainGauge& gauge) const {
    if (given_.direction && !(given_.direction->norm() > 0.0 && given_.direction->allFinite()))
      refuse("has a direction of no length", "it measures along a line", "give its direction [x, y, z]");
    if (dimension(cell.shape) == 1) {
      const Eigen::Matrix3Xd ends = corner_places(model_.mesh, cell);
      gauge.direction = (ends.col(1) - ends.col(0)).normalized();
      constexpr double least_cosine = 0.95;  // 18 degrees: the beam's line may stand off its nodes
      if (given_.direction && std::abs(given_.direction->normalized().dot(gauge.direction)) < least_cosine)
        refuse("points across " + title(cell), "a fibre of a beam is strained along its axis alone",
               "remove the direction");
      return;
    }
    if (!given_.direction)
      refuse("has no direction", "it stands on " + title(cell) + ", whose strain depends on it",
             "write direction: [x, y, z]");
    gauge.direction = given_.direction->normalized();
  }

  const FiniteElementModel& model_;
  const GaugeDescription& given_;
};

}  // namespace

StrainGauge place_gauge(const FiniteElementModel& model, const GaugeDescription& given) {
  StrainGauge gauge = Placement(model, given).place();
  strain_row(model, gauge);  // refuses a direction or layer that does not suit the shell
  return gauge;
}

}  // namespace kalfem
