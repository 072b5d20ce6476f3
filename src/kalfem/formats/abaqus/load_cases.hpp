#pragma once

#include <vector>

#include "kalfem/formats/abaqus/kinematics.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem::abaqus {

/// One load case for each static step of the deck, "step1", "step2", ..., out of *CLOAD, *DLOAD (pressure P, P1 ... and
/// GRAV), *DSLOAD (P) and *BOUNDARY with values. Loads of earlier steps go on acting unless OP=NEW removes them, but
/// not in a *STEP, PERTURBATION. Other kinds of loads are notes. `model`: with its supports, its cells not yet
/// replaced.
std::vector<LoadCase> read_load_cases(const RawDeck& raw, PlacedDeck& deck, const NodeAxes& axes,
                                      const FiniteElementModel& model);

}  // namespace kalfem::abaqus
