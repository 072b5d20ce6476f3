// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <map>

#include "kalfem/formats/nastran.hpp"
#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "model/fe_models.hpp"

namespace kalfem::test {

/// Material 1 of most decks.
const std::string aluminium = "MAT1,1,7.E10,,.3,2700.\n";

inline Deck nastran(const std::string& text) { return parse_nastran(text, "deck.bdf"); }

/// The message of the InvalidInput that a deck causes, "" if it causes none.
inline std::string nastran_problem(const std::string& text) {
  try {
    nastran(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

inline bool has_note(const Deck& deck, const std::string& part) {
  for (const auto& note : deck.notes)
    if ((note.what + ": " + note.consequence).find(part) != std::string::npos) return true;
  return false;
}

/// Static displacements, six a node, under loads at nodal degrees of freedom.
inline Eigen::VectorXd displacements(const FiniteElementModel& model,
                                     const std::vector<std::pair<NodalDof, double>>& loads) {
  const auto assembled = assemble(model);
  Eigen::VectorXd all = Eigen::VectorXd::Zero(6 * model.mesh.node_count());
  for (const auto& [dof, value] : loads) all[6 * dof.node + dof.direction] += value;
  const Eigen::VectorXd load = assembled.expansion.transpose() * all;
  const Eigen::MatrixXd stiffness(evaluate(assembled.stiffness, assembled.parameters));
  return assembled.expansion * Eigen::VectorXd(stiffness.fullPivLu().solve(load));
}

/// All mass of a model that nothing holds.
inline MassProperties masses(FiniteElementModel model) {
  model.fixed.clear();
  return mass_properties(assemble(model));
}

}  // namespace kalfem::test
