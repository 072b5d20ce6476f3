// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <set>

#include "kalfem/model/elements/solid.hpp"
#include "kalfem/model/statics/loaded_faces.hpp"

namespace kalfem {
namespace {

using Corners = std::vector<Eigen::Index>;  ///< of a face, ascending

Corners corners_of(const LoadedFace& face) {
  Corners corners(face.nodes.begin(), face.nodes.begin() + corner_count(face.shape));
  std::ranges::sort(corners);
  return corners;
}

/// Node of a quadratic solid in the middle of the side between two of its corners.
int middle_of(CellShape shape, int one, int other) {
  const SolidNodes natural = natural_nodes(shape);
  Eigen::Index node = 0;
  (natural.colwise() - 0.5 * (natural.col(one) + natural.col(other))).colwise().squaredNorm().minCoeff(&node);
  return static_cast<int>(node);
}

LoadedFace shell_face(const Mesh& mesh, const Cell& cell) {
  LoadedFace face{.shape = cell.shape};
  std::ranges::copy(mesh.nodes_of(cell), face.nodes.begin());
  return face;
}

LoadedFace solid_face(const Mesh& mesh, const Cell& cell, const CornerRing& ring) {
  const auto nodes = mesh.nodes_of(cell);
  const auto places = ring.places();
  const bool quadratic = node_count(cell.shape) > corner_count(cell.shape);
  LoadedFace face;
  if (ring.count == 3) face.shape = quadratic ? CellShape::triangle6 : CellShape::triangle3;
  if (ring.count == 4) face.shape = quadratic ? CellShape::quadrilateral8 : CellShape::quadrilateral4;
  for (std::size_t i = 0; i < places.size(); ++i) {
    face.nodes[i] = nodes[static_cast<std::size_t>(places[i])];
    if (quadratic)
      face.nodes[places.size() + i] =
          nodes[static_cast<std::size_t>(middle_of(cell.shape, places[i], places[(i + 1) % places.size()]))];
  }
  return face;
}

}  // namespace

std::vector<LoadedFace> faces_of_cell(const Mesh& mesh, const Cell& cell) {
  if (dimension(cell.shape) == 2) return {shell_face(mesh, cell)};
  std::vector<LoadedFace> faces;
  if (dimension(cell.shape) == 3)
    for (const auto& ring : corner_rings(cell.shape)) faces.push_back(solid_face(mesh, cell, ring));
  return faces;
}

namespace {

/// Shells and outer faces of solids of the regions that have a property, by their corners.
std::map<Corners, LoadedFace> outer_faces(const FiniteElementModel& model) {
  std::map<Corners, LoadedFace> shells, faces;
  std::set<Corners> inner;
  for (const auto& [region, property] : model.properties)
    for (const auto index : model.mesh.regions.at(region)) {
      const auto& cell = model.mesh.cells[static_cast<std::size_t>(index)];
      const bool is_shell = dimension(cell.shape) == 2;
      for (const auto& face : faces_of_cell(model.mesh, cell))
        if (!(is_shell ? shells : faces).insert({corners_of(face), face}).second && !is_shell)
          inner.insert(corners_of(face));
    }
  for (const auto& corners : inner) faces.erase(corners);
  shells.insert(faces.begin(), faces.end());  // a skin on a solid stands for the solid's face
  return shells;
}

}  // namespace

std::vector<LoadedFace> faces_of_cells(const FiniteElementModel& model, const std::vector<Eigen::Index>& cells) {
  const auto faces = outer_faces(model);
  std::vector<LoadedFace> found;
  for (const auto index : cells) {
    const auto& cell = model.mesh.cells[static_cast<std::size_t>(index)];
    if (dimension(cell.shape) != 2) continue;
    if (const auto face = faces.find(corners_of(shell_face(model.mesh, cell))); face != faces.end())
      found.push_back(face->second);
  }
  return found;
}

std::vector<LoadedFace> faces_between_nodes(const FiniteElementModel& model, const std::vector<Eigen::Index>& nodes) {
  const std::set<Eigen::Index> wanted(nodes.begin(), nodes.end());
  std::vector<LoadedFace> found;
  for (const auto& [corners, face] : outer_faces(model))
    if (std::ranges::all_of(corners, [&](Eigen::Index node) { return wanted.contains(node); })) found.push_back(face);
  return found;
}

}  // namespace kalfem
