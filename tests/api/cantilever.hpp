// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "chain.hpp"

namespace kalfem {

/// The mesh of a beam along x, 1 m long, of ten elements: nodes 1 to 11. Elements from `outer` on are the region
/// "outer", the others "bar".
inline FiniteElementModel beam_mesh(Eigen::Index outer = 10) {
  FiniteElementModel model;
  model.mesh.nodes.resize(3, 11);
  for (Eigen::Index i = 0; i < 11; ++i) {
    model.mesh.nodes.col(i) << 0.1 * static_cast<double>(i), 0.0, 0.0;
    model.mesh.node_ids.push_back(i + 1);
  }
  for (Eigen::Index i = 0; i < 10; ++i) {
    const std::array<Eigen::Index, 2> nodes = {i, i + 1};
    model.mesh.regions[i < outer ? "bar" : "outer"].push_back(model.mesh.add_cell(CellShape::line2, i + 1, nodes));
  }
  return model;
}

/// A slender steel beam of that mesh, held at its root.
inline FiniteElements cantilever(double youngs_modulus = 210e9) {
  FiniteElementModel model = beam_mesh();
  model.materials["steel"] = {youngs_modulus, 0.3, 7850.0};
  BeamSection section = rectangular_section(0.02, 0.01);
  section.shear_factor_y = section.shear_factor_z = 0.0;
  model.properties["bar"] = BeamProperty{"steel", section};
  return FiniteElements("beam", model).node("root", 1).node("tip", Eigen::Vector3d(1.0, 0.0, 0.0)).fix("root");
}

/// First bending frequency of the thin side of that beam, (1.8751 / L)^2 sqrt(E I / (rho A)) / 2 pi [Hz].
inline double first_frequency(double youngs_modulus = 210e9) {
  const double radius_of_gyration = 0.01 / std::sqrt(12.0);
  return 1.8751041 * 1.8751041 * radius_of_gyration * std::sqrt(youngs_modulus / 7850.0) / (2.0 * EIGEN_PI);
}

}  // namespace kalfem
