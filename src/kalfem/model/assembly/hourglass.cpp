// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/hourglass.hpp"

#include <algorithm>

#include "kalfem/model/assembly/rigid_body.hpp"

namespace kalfem {
namespace {

/// The hexahedron of 8 nodes is stabilised against its hourglass modes.
bool can_hourglass(CellShape shape) { return shape == CellShape::hexahedron20 || shape == CellShape::wedge15; }

std::vector<std::string> reduced_regions(const FiniteElementModel& model) {
  std::vector<std::string> regions;
  for (const auto& [region, property] : model.properties) {
    const auto* solid = std::get_if<SolidProperty>(&property);
    const auto is_prone = [&](Eigen::Index cell) {
      return can_hourglass(model.mesh.cells[static_cast<std::size_t>(cell)].shape);
    };
    if (solid && solid->kind == SolidKind::reduced && std::ranges::any_of(model.mesh.regions.at(region), is_prone))
      regions.push_back(region);
  }
  return regions;
}

std::size_t count_mechanisms(const FiniteElementModel& model) { return find_mechanisms(model, assemble(model)).size(); }

FiniteElementModel integrated_fully(FiniteElementModel model, const std::vector<std::string>& regions) {
  for (const auto& region : regions) std::get<SolidProperty>(model.properties.at(region)).kind = SolidKind::full;
  return model;
}

}  // namespace

MechanismReason mechanism_reason(const FiniteElementModel& model) {
  const auto regions = reduced_regions(model);
  if (regions.empty() || count_mechanisms(integrated_fully(model, regions)) >= count_mechanisms(model))
    return {"nothing resists these motions: hinges, unrestrained rotations or disconnected parts",
            "fix or connect these degrees of freedom"};
  std::string names;
  for (const auto& region : regions) names += (names.empty() ? "'" : ", '") + region + "'";
  return {"these are hourglass modes of reduced integration in region " + names + ": they strain no integration point",
          "use `integration: full` there; in a deck the element type with full integration, such as C3D20"};
}

}  // namespace kalfem
