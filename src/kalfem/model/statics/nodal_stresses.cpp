#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "kalfem/model/statics/stresses.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// Cosine of the angle up to which neighbouring shells count as one surface.
const double same_surface = std::cos(30.0 * std::numbers::pi / 180.0);

/// Cells that meet at a node with one surface.
struct Patch {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of the first of them
  double count = 0.0;
  std::map<Layer, Stress> sums;
  std::map<Layer, std::pair<double, Index>> largest;  ///< von Mises stress and its cell

  void add(Layer layer, const Stress& stress, Index cell) {
    sums.try_emplace(layer, Stress::Zero()).first->second += stress;
    const double value = von_mises(stress);
    const auto [place, is_new] = largest.try_emplace(layer, value, cell);
    if (!is_new && value > place->second.first) place->second = {value, cell};
  }
};

/// Of two shells whose normals are opposite, the top of one lies on the bottom of the other.
Layer turned_over(Layer layer) {
  if (layer == Layer::top) return Layer::bottom;
  return layer == Layer::bottom ? Layer::top : layer;
}

Patch& patch_with(std::vector<Patch>& patches, const Eigen::Vector3d& normal) {
  for (auto& patch : patches)
    if (normal.isZero(0.0) || std::abs(patch.normal.dot(normal)) > same_surface) return patch;
  patches.push_back({.normal = normal});
  return patches.back();
}

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
  std::map<Index, std::vector<Patch>> by_node;
  for (const auto& cell : region.cells) {
    const auto nodes = mesh.nodes_of(mesh.cells[static_cast<std::size_t>(cell.cell)]);
    const Index count = cell.layers.front().at_nodes.cols();
    for (Index i = 0; i < count; ++i) {
      Patch& patch = patch_with(by_node[nodes[static_cast<std::size_t>(i)]], cell.normal);
      const bool opposite = patch.normal.dot(cell.normal) < 0.0;
      patch.count += 1.0;
      for (const auto& [layer, centre, strain, at_nodes] : cell.layers)
        patch.add(opposite ? turned_over(layer) : layer, at_nodes.col(i), cell.cell);
    }
  }
  std::vector<NodalStress> means;
  for (const auto& [node, patches] : by_node)
    for (const auto& patch : patches)
      for (const auto& [layer, sum] : patch.sums)
        means.push_back({node, layer, sum / patch.count, patch.largest.at(layer).second});
  return means;
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
