// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "kalfem/formats/abaqus.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly/assembly.hpp"

namespace kalfem {

/// A deck without included files.
inline Deck parse_deck(const std::string& text) {
  return parse_abaqus(text, "deck.inp", [](const std::filesystem::path& path) -> std::string {
    throw InvalidInput(Issue{{path.string(), 0}, "no such file", "", ""});
  });
}

/// The assembled model with its matrices at their present values.
struct Matrices {
  AssembledModel model;
  SparseMatrix stiffness, mass;

  explicit Matrices(const FiniteElementModel& description)
      : model(assemble(description)),
        stiffness(evaluate(model.stiffness, model.parameters)),
        mass(evaluate(model.mass, model.parameters)) {}

  /// Frequencies [Hz], as many as there are up to `count`.
  [[nodiscard]] Eigen::VectorXd frequencies(Eigen::Index count) const {
    const auto modes = lowest_modes(stiffness, mass, {.count = std::min(count, model.size())});
    return modes.values.cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi);
  }

  /// Rigid translation along an axis, in the free degrees of freedom.
  [[nodiscard]] Eigen::VectorXd translation(int axis) const {
    Eigen::VectorXd shape = Eigen::VectorXd::Zero(model.size());
    for (std::size_t i = 0; i < model.dofs.size(); ++i)
      if (model.dofs[i].direction == axis) shape[static_cast<Eigen::Index>(i)] = 1.0;
    return shape;
  }
};

const std::string deck_steel = "*MATERIAL, NAME=steel\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7850.\n";

}  // namespace kalfem
