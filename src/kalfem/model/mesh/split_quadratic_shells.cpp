// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/mesh/split_quadratic_shells.hpp"

#include <algorithm>
#include <array>
#include <set>

namespace kalfem {
namespace {

using Nodes = std::vector<Eigen::Index>;

bool is_replaced(CellShape shape) {
  return shape == CellShape::line3 || shape == CellShape::triangle6 || shape == CellShape::quadrilateral8;
}

/// A quadrilateral of a collapsed cell may have two corners at one node: it is a triangle.
Nodes without_repeated(const Nodes& corners) {
  Nodes kept;
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (corners[i] != corners[(i + 1) % corners.size()]) kept.push_back(corners[i]);
  return kept.size() == 3 ? kept : corners;
}

// A quadratic line becomes two, a triangle four, a quadrilateral four about a new node at its centre (the serendipity
// interpolation there). The first part keeps the cell's number, further ones and new nodes are numbered on.
/// Replaces the cells of a mesh one by one.
class Replacement {
public:
  explicit Replacement(Mesh& mesh) : mesh_(mesh) {
    for (const auto id : mesh.node_ids) last_node_ = std::max(last_node_, id);
    for (const auto& cell : mesh.cells) last_cell_ = std::max(last_cell_, cell.id);
  }

  void replace(Eigen::Index index) {
    const Cell cell = mesh_.cells[static_cast<std::size_t>(index)];
    const auto given = mesh_.nodes_of(cell);
    const Nodes n(given.begin(), given.end());
    auto& parts = parts_[index];
    // The sides of all parts run along those of the cell, so that the first side of a part keeps the cell's direction.
    std::vector<Nodes> pieces;
    if (cell.shape == CellShape::line3) {
      pieces = {{n[0], n[2]}, {n[2], n[1]}};
    } else if (cell.shape == CellShape::triangle6) {
      pieces = {{n[0], n[3], n[5]}, {n[3], n[1], n[4]}, {n[5], n[4], n[2]}, {n[4], n[5], n[3]}};
    } else {
      const Eigen::Index c = add_centre(n);
      pieces = {{n[0], n[4], c, n[7]}, {n[4], n[1], n[5], c}, {c, n[5], n[2], n[6]}, {n[7], c, n[6], n[3]}};
    }
    if (cell.shape != CellShape::line3)
      for (std::size_t i = 0, corners = n.size() / 2; i < corners; ++i)
        middles_[n[corners + i]] = {n[i], n[(i + 1) % corners]};
    for (auto& piece : pieces) {
      if (piece.size() == 4) piece = without_repeated(piece);
      parts.push_back(parts.empty() ? put(index, cell.id, piece) : put(-1, ++last_cell_, piece));
    }
  }

  /// Puts the parts of each cell in the place of it.
  [[nodiscard]] std::vector<Eigen::Index> expanded(const std::vector<Eigen::Index>& cells) const {
    std::vector<Eigen::Index> all;
    for (const auto cell : cells) {
      const auto place = parts_.find(cell);
      if (place == parts_.end())
        all.push_back(cell);
      else
        all.insert(all.end(), place->second.begin(), place->second.end());
    }
    return all;
  }
  [[nodiscard]] std::size_t count(Eigen::Index cell) const {
    const auto place = parts_.find(cell);
    return place == parts_.end() ? 1 : place->second.size();
  }

  /// Nodes amid the sides of the shells, with the corners beside.
  [[nodiscard]] const std::map<Eigen::Index, std::array<Eigen::Index, 2>>& side_middles() const { return middles_; }

  void finish() {
    const Eigen::Index before = mesh_.node_count();
    mesh_.nodes.conservativeResize(3, before + static_cast<Eigen::Index>(centres_.size()));
    for (std::size_t i = 0; i < centres_.size(); ++i)
      mesh_.nodes.col(before + static_cast<Eigen::Index>(i)) = centres_[i];
    std::vector<Eigen::Index> connectivity;
    for (auto& cell : mesh_.cells) {
      const auto nodes = mesh_.nodes_of(cell);
      cell.first = static_cast<Eigen::Index>(connectivity.size());
      connectivity.insert(connectivity.end(), nodes.begin(), nodes.end());
    }
    mesh_.connectivity = std::move(connectivity);
    for (auto* groups : {&mesh_.regions, &mesh_.element_sets})
      for (auto& [name, cells] : *groups) cells = expanded(cells);
  }

private:
  Eigen::Index add_centre(const Nodes& n) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 4; ++i) centre += 0.5 * mesh_.nodes.col(n[i + 4]) - 0.25 * mesh_.nodes.col(n[i]);
    centres_.push_back(centre);
    mesh_.node_ids.push_back(++last_node_);
    return mesh_.node_count() + static_cast<Eigen::Index>(centres_.size()) - 1;
  }

  /// A new cell, or a new one in the place of that of an index.
  Eigen::Index put(Eigen::Index index, std::int64_t id, const Nodes& nodes) {
    const CellShape shape = nodes.size() == 2   ? CellShape::line2
                            : nodes.size() == 3 ? CellShape::triangle3
                                                : CellShape::quadrilateral4;
    const Eigen::Index added = mesh_.add_cell(shape, id, nodes);
    if (index < 0) return added;
    mesh_.cells[static_cast<std::size_t>(index)] = mesh_.cells.back();
    mesh_.cells.pop_back();
    return index;
  }

  Mesh& mesh_;
  std::int64_t last_node_ = 0, last_cell_ = 0;
  std::vector<Eigen::Vector3d> centres_;
  std::map<Eigen::Index, std::vector<Eigen::Index>> parts_;
  std::map<Eigen::Index, std::array<Eigen::Index, 2>> middles_;
};

/// The two halves of a beam's placement.
std::array<BeamPlacement, 2> halves(const BeamPlacement& whole) {
  std::array<BeamPlacement, 2> parts = {whole, whole};
  const Eigen::Vector3d middle = whole.offsets.rowwise().mean();
  parts[0].offsets.col(1) = parts[1].offsets.col(0) = middle;
  std::fill(parts[0].released.begin() + 6, parts[0].released.end(), false);
  std::fill(parts[1].released.begin(), parts[1].released.begin() + 6, false);
  return parts;
}

bool is_same_at_both_ends(const BeamPlacement& placement) {
  return placement.offsets.col(0) == placement.offsets.col(1) &&
         std::ranges::none_of(placement.released, [](bool released) { return released; });
}

/// One placement serves all cells as long as it serves the halves too.
void expand_placements(BeamProperty& beam, const std::vector<Eigen::Index>& cells, const Replacement& replacement) {
  if (beam.placements.empty() || (beam.placements.size() == 1 && is_same_at_both_ends(beam.placements.front()))) return;
  if (beam.placements.size() != 1 && beam.placements.size() != cells.size()) return;  // told by validate()
  std::vector<BeamPlacement> placements;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto& whole = beam.placement(i);
    if (replacement.count(cells[i]) == 1) {
      placements.push_back(whole);
    } else {
      const auto parts = halves(whole);
      placements.insert(placements.end(), parts.begin(), parts.end());
    }
  }
  beam.placements = std::move(placements);
}

void expand_directions(LaminateProperty& laminate, const std::vector<Eigen::Index>& cells,
                       const Replacement& replacement) {
  if (laminate.directions.size() <= 1 || laminate.directions.size() != cells.size()) return;
  std::vector<Eigen::Vector3d> directions;
  for (std::size_t i = 0; i < cells.size(); ++i)
    directions.insert(directions.end(), replacement.count(cells[i]), laminate.directions[i]);
  laminate.directions = std::move(directions);
}

}  // namespace

void replace_quadratic(FiniteElementModel& model) {
  std::set<Eigen::Index> replaced;
  for (const auto& [region, property] : model.properties) {
    const auto cells = model.mesh.regions.find(region);
    if (std::holds_alternative<SolidProperty>(property) || cells == model.mesh.regions.end()) continue;
    const int wanted = std::holds_alternative<BeamProperty>(property) ? 1 : 2;
    for (const auto index : cells->second) {
      const CellShape shape = model.mesh.cells[static_cast<std::size_t>(index)].shape;
      if (is_replaced(shape) && dimension(shape) == wanted) replaced.insert(index);
    }
  }
  if (replaced.empty()) return;
  Replacement replacement(model.mesh);
  for (const auto index : replaced) replacement.replace(index);
  for (auto& [region, property] : model.properties) {
    const auto cells = model.mesh.regions.find(region);
    if (cells == model.mesh.regions.end()) continue;
    if (auto* beam = std::get_if<BeamProperty>(&property)) expand_placements(*beam, cells->second, replacement);
    if (auto* laminate = std::get_if<LaminateProperty>(&property))
      expand_directions(*laminate, cells->second, replacement);
  }
  for (auto& factor : model.factors) factor.cells = replacement.expanded(factor.cells);
  replacement.finish();
  model.side_middles.insert(replacement.side_middles().begin(), replacement.side_middles().end());
}

}  // namespace kalfem
