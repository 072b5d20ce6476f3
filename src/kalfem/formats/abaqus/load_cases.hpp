// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/formats/abaqus/kinematics.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"
#include "kalfem/formats/abaqus/steps.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem::abaqus {

/// One load case for each wanted static step of the deck that loads something, "step1", "step2", ...: *CLOAD; *DLOAD P,
/// P1
/// ..., GRAV, CENTRIF, BX, BY, BZ; *DSLOAD P; *BOUNDARY, with the supports of the step. Loads of earlier steps go on
/// acting, see ActiveLoads. A load that is not read is a problem. `model`: with its supports, its cells not yet
/// replaced.
std::vector<LoadCase> read_load_cases(const RawDeck& raw, PlacedDeck& deck, const NodeAxes& axes,
                                      const SupportHistory& history, const FiniteElementModel& model);

}  // namespace kalfem::abaqus
