// SPDX-License-Identifier: Apache-2.0
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "kalfem/model/statics/stresses.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// Cosine of the angle up to which neighbouring shells count as one surface.
const double same_surface = std::cos(30.0 * std::numbers::pi / 180.0);

/// Of two shells whose normals are opposite, the top of one lies on the bottom of the other.
Layer turned_over(Layer layer) {
  if (layer == Layer::top) return Layer::bottom;
  return layer == Layer::bottom ? Layer::top : layer;
}

/// A cell of a patch, with the place of the node among its own.
struct Member {
  const CellStress* cell = nullptr;
  Index place = 0;
};

/// Cells that meet at a node with one surface.
struct Patch {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of the first of them
  std::vector<Member> members;

  [[nodiscard]] bool has_surface(const Eigen::Vector3d& other) const {
    return other.isZero(0.0) || std::abs(normal.dot(other)) > same_surface;
  }
};

/// The part of a cell that lies in a layer of a patch with this normal.
const LayerStress& layer_of(const CellStress& cell, Layer layer, const Eigen::Vector3d& normal) {
  const Layer own = normal.dot(cell.normal) < 0.0 ? turned_over(layer) : layer;
  return *std::ranges::find(cell.layers, own, &LayerStress::layer);
}

// Inside a region the mean over the cells that meet is accurate to the second order. At its edges it is that of one
// side only, and of linear cells no better than the first order. There the polynomials of the patches of inner
// neighbours are extended to the node, in the manner of the superconvergent patch recovery: a linear field through the
// values at the cells' centres, where linear cells are most accurate [ZZ92].
/// Nodal values of one region.
class Recovery {
public:
  Recovery(const Mesh& mesh, const RegionStress& region) : mesh_(mesh) {
    for (const auto& cell : region.cells) add(cell);
    mark_edges(region);
  }

  [[nodiscard]] std::vector<NodalStress> values() const {
    std::vector<NodalStress> all;
    for (const auto& [node, patches] : patches_)
      for (const auto& patch : patches)
        for (const auto& part : patch.members.front().cell->layers) {
          const auto extended = edges_.contains(node) ? from_inside(node, patch, part.layer) : std::nullopt;
          all.push_back({node, part.layer, extended.value_or(mean(patch, part.layer)), largest(patch, part.layer)});
        }
    return all;
  }

private:
  [[nodiscard]] const Cell& cell_of(const CellStress& stress) const {
    return mesh_.cells[static_cast<std::size_t>(stress.cell)];
  }
  [[nodiscard]] bool is_linear(const CellStress& stress) const {
    const CellShape shape = cell_of(stress).shape;
    return node_count(shape) == corner_count(shape);
  }
  [[nodiscard]] Eigen::Vector3d centre(const CellStress& stress) const {
    return corner_places(mesh_, cell_of(stress)).rowwise().mean();
  }

  void add(const CellStress& cell) {
    const auto nodes = mesh_.nodes_of(cell_of(cell));
    for (Index i = 0; i < cell.layers.front().at_nodes.cols(); ++i) {
      auto& patches = patches_[nodes[static_cast<std::size_t>(i)]];
      auto patch = std::ranges::find_if(patches, [&](const auto& each) { return each.has_surface(cell.normal); });
      if (patch == patches.end()) patch = patches.insert(patches.end(), {.normal = cell.normal, .members = {}});
      patch->members.push_back({&cell, i});
    }
  }

  /// Nodes of sides of shells, and faces of solids, that no other cell of the same surface shares.
  void mark_edges(const RegionStress& region) {
    std::map<std::vector<Index>, std::vector<const CellStress*>> sides;
    for (const auto& cell : region.cells) {
      const auto nodes = mesh_.nodes_of(cell_of(cell));
      const auto note = [&](std::span<const int> places) {
        std::vector<Index> side;
        for (const int place : places) side.push_back(nodes[static_cast<std::size_t>(place)]);
        std::ranges::sort(side);
        sides[side].push_back(&cell);
      };
      if (dimension(cell_of(cell).shape) == 3)
        for (const auto& ring : corner_rings(cell_of(cell).shape)) note(ring.places());
      else
        for (const auto& side : corner_sides(cell_of(cell).shape)) note(side);
    }
    for (const auto& [side, cells] : sides)
      if (cells.size() != 2 ||
          (!cells[0]->normal.isZero(0.0) && std::abs(cells[0]->normal.dot(cells[1]->normal)) <= same_surface))
        edges_.insert(side.begin(), side.end());
  }

  static Stress mean(const Patch& patch, Layer layer) {
    Stress sum = Stress::Zero();
    for (const auto& [cell, place] : patch.members) sum += layer_of(*cell, layer, patch.normal).at_nodes.col(place);
    return sum / static_cast<double>(patch.members.size());
  }

  static Index largest(const Patch& patch, Layer layer) {
    const auto value = [&](const Member& member) {
      return von_mises(layer_of(*member.cell, layer, patch.normal).at_nodes.col(member.place));
    };
    return std::ranges::max_element(patch.members, {}, value)->cell->cell;
  }

  /// Mean of what the patches of inner neighbours give at the node; nothing where it has none or cells are quadratic.
  [[nodiscard]] std::optional<Stress> from_inside(Index node, const Patch& patch, Layer layer) const {
    std::set<Index> neighbours;
    for (const auto& [cell, place] : patch.members) {
      if (!is_linear(*cell)) return std::nullopt;
      for (const auto other : mesh_.nodes_of(cell_of(*cell)))
        if (!edges_.contains(other)) neighbours.insert(other);
    }
    if (neighbours.empty()) return std::nullopt;
    Stress sum = Stress::Zero();
    for (const auto inner : neighbours) sum += extended(patches_.at(inner).front(), patch.normal, layer, node);
    return sum / static_cast<double>(neighbours.size());
  }

  /// The linear field through the centres of a patch, at a node. Columns are scaled by the size of the patch; a plane
  /// patch leaves the slope across it 0.
  [[nodiscard]] Stress extended(const Patch& patch, const Eigen::Vector3d& normal, Layer layer, Index node) const {
    const auto count = static_cast<Index>(patch.members.size());
    Eigen::MatrixXd places(count, 3), values(count, 6);
    for (Index i = 0; i < count; ++i) {
      const auto& cell = *patch.members[static_cast<std::size_t>(i)].cell;
      places.row(i) = centre(cell);
      values.row(i) = layer_of(cell, layer, normal).centre;
    }
    const Eigen::RowVector3d middle = places.colwise().mean();
    places.rowwise() -= middle;
    const double size = std::max(places.rowwise().norm().maxCoeff(), 1e-300);
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> fit;
    fit.setThreshold(1e-6);
    fit.compute(places / size);
    const Eigen::MatrixXd slopes = fit.solve(values.rowwise() - values.colwise().mean());
    return values.colwise().mean() + (mesh_.nodes.col(node).transpose() - middle) / size * slopes;
  }

  const Mesh& mesh_;
  std::map<Index, std::vector<Patch>> patches_;
  std::set<Index> edges_;
};

std::optional<StressPeak> beam_peak(const Mesh& mesh, const RegionStress& region) {
  std::optional<StressPeak> peak;
  const auto offer = [&](double value, Index cell, std::size_t end) {
    if (peak && std::abs(value) <= std::abs(peak->value)) return;
    const Index node = mesh.nodes_of(mesh.cells[static_cast<std::size_t>(cell)])[end];
    peak = StressPeak{.region = region.region, .value = value, .cell = cell, .node = node, .of_beam = true};
  };
  for (const auto& beam : region.beams)
    for (std::size_t end = 0; end < 2; ++end) {
      offer(beam.axial[end], beam.cell, end);
      if (const auto& fibres = beam.fibres[end]) {
        offer(fibres->highest, beam.cell, end);
        offer(fibres->lowest, beam.cell, end);
      }
    }
  return peak;
}

}  // namespace

std::vector<NodalStress> nodal_stresses(const Mesh& mesh, const RegionStress& region) {
  return Recovery(mesh, region).values();
}

std::optional<StressPeak> stress_peak(const Mesh& mesh, const RegionStress& region,
                                      const std::vector<NodalStress>& means) {
  std::optional<StressPeak> peak = beam_peak(mesh, region);
  for (const auto& mean : means)
    if (const double value = von_mises(mean.stress); !peak || value > peak->value)
      peak = StressPeak{
          .region = region.region, .value = value, .cell = mean.cell, .node = mean.node, .layer = mean.layer};
  return peak;
}

}  // namespace kalfem
