// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>

#include "kalfem/model/finite_element_model.hpp"
#include "model/calculix.hpp"

// Parts of CalculiX decks of models with one region, whose elements are the set "all".

namespace kalfem::test {

inline void write_mesh(const FiniteElementModel& model, const std::string& type, const IsotropicMaterial& material,
                       std::ostream& deck) {
  deck.precision(15);
  deck << "*NODE, NSET=all\n";
  for (Eigen::Index i = 0; i < model.mesh.node_count(); ++i)
    deck << i + 1 << ", " << model.mesh.nodes(0, i) << ", " << model.mesh.nodes(1, i) << ", " << model.mesh.nodes(2, i)
         << "\n";
  deck << "*ELEMENT, TYPE=" << type << ", ELSET=all\n";
  for (const auto& cell : model.mesh.cells) {
    deck << cell.id;
    int on_line = 1;
    for (const Eigen::Index node : model.mesh.nodes_of(cell)) deck << (on_line++ % 16 == 0 ? ",\n" : ", ") << node + 1;
    deck << "\n";
  }
  deck << "*MATERIAL, NAME=material\n*ELASTIC\n"
       << material.youngs_modulus << ", " << material.poissons_ratio << "\n*DENSITY\n"
       << material.density << "\n";
}

inline void write_supports(const FiniteElementModel& model, std::ostream& deck) {
  deck << "*BOUNDARY\n";
  for (const auto& support : model.fixed)
    for (const Eigen::Index node : support.nodes)
      for (int direction = 0; direction < 6; ++direction)
        if (support.directions[static_cast<std::size_t>(direction)])
          deck << node + 1 << ", " << direction + 1 << ", " << direction + 1 << "\n";
}

/// Forces at all degrees of freedom, 6 to a node.
inline void write_forces(const Eigen::VectorXd& forces, std::ostream& deck) {
  deck << "*CLOAD\n";
  for (Eigen::Index i = 0; i < forces.size(); ++i)
    if (forces[i] != 0.0) deck << i / 6 + 1 << ", " << i % 6 + 1 << ", " << forces[i] << "\n";
}

}  // namespace kalfem::test
