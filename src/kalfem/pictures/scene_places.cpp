// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/scene_places.hpp"

namespace kalfem {

using Eigen::Index;

ScenePlaces::ScenePlaces(const Mesh& mesh, const std::vector<std::string>& regions, std::size_t most_faces)
    : mesh_(mesh) {
  auto faces = outer_faces(mesh, regions);
  const Eigen::VectorXd weights = shape_weights(mesh.nodes, faces);
  surface_ = coarsened(mesh.nodes, std::move(faces), weights, most_faces);
  if (surface_.coarsened)
    add_clusters(weights);
  else
    add_corners();
}

Index ScenePlaces::of(Index node) {
  const auto [entry, is_new] = of_node_.try_emplace(node, count_);
  if (is_new) {
    shares_.emplace_back(node, entry->second, 1.0);
    ++count_;
  }
  return entry->second;
}

Eigen::SparseMatrix<double> ScenePlaces::averaging() const {
  Eigen::SparseMatrix<double> averaging(mesh_.node_count(), count_);
  averaging.setFromTriplets(shares_.begin(), shares_.end());
  return averaging;
}

void ScenePlaces::add_clusters(const Eigen::VectorXd& weights) {
  count_ = surface_.places.cols();
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(count_);
  const auto nodes = static_cast<Index>(surface_.place_of.size());
  const auto place_of = [&](Index node) { return surface_.place_of[static_cast<std::size_t>(node)]; };
  for (Index node = 0; node < nodes; ++node)
    if (place_of(node) >= 0) sums[place_of(node)] += weights[node];
  for (Index node = 0; node < nodes; ++node)
    if (const Index place = place_of(node); place >= 0) shares_.emplace_back(node, place, weights[node] / sums[place]);
}

/// The corners of faces alone: middles of sides and nodes inside of solids are not drawn.
void ScenePlaces::add_corners() {
  for (auto& face : surface_.faces)
    for (int i = 0; i < face.count; ++i) {
      Index& corner = face.nodes[static_cast<std::size_t>(i)];
      corner = of(corner);
    }
}

}  // namespace kalfem
