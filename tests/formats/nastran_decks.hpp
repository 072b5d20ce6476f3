#pragma once

#include <cmath>
#include <map>
#include <numbers>

#include "kalfem/formats/nastran.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly.hpp"
#include "kalfem/model/mass_properties.hpp"

namespace kalfem::test {

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

/// Lowest natural frequencies [Hz] in the deck's units.
inline Eigen::VectorXd frequencies(const FiniteElementModel& model, Eigen::Index count) {
  const auto assembled = assemble(model);
  const auto modes = lowest_modes(evaluate(assembled.stiffness, assembled.parameters),
                                  evaluate(assembled.mass, assembled.parameters), {.count = count});
  return modes.values.cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi);
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
  return mass_properties(model, assemble(model));
}

}  // namespace kalfem::test
