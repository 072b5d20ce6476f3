// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <map>
#include <string>
#include <vector>

#include "kalfem/model/mesh/mesh.hpp"
#include "kalfem/pictures/drawn_surface.hpp"

namespace kalfem {

/// The places of a scene: those of the drawn surface, each a weighted mean of nodes, and nodes of their own, on which
/// marks and lines stand.
class ScenePlaces {
public:
  /// Surfaces finer than so many faces are coarsened.
  ScenePlaces(const Mesh& mesh, const std::vector<std::string>& regions, std::size_t most_faces);

  [[nodiscard]] const std::vector<DrawnFace>& faces() const { return surface_.faces; }
  /// The place of one node alone.
  Eigen::Index of(Eigen::Index node);
  /// nodes x places: a field over the nodes times this is the field over the places.
  [[nodiscard]] Eigen::SparseMatrix<double> averaging() const;

private:
  void add_clusters(const Eigen::VectorXd& weights);
  void add_corners();

  const Mesh& mesh_;
  DrawnSurface surface_;
  Eigen::Index count_ = 0;
  std::map<Eigen::Index, Eigen::Index> of_node_;
  std::vector<Eigen::Triplet<double>> shares_;
};

}  // namespace kalfem
