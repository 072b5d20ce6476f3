// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/formats/deck.hpp"
#include "kalfem/formats/nastran/bulk_data.hpp"
#include "kalfem/formats/nastran/card_stream.hpp"
#include "kalfem/formats/nastran/case_control.hpp"

namespace kalfem::nastran {

/// Gives materials with a MATTi card their values at one temperature: the one that the user states, otherwise that of
/// all grid points in the set that TEMPERATURE(MATERIAL) chooses, or in the only set of a deck without case control.
/// Without any the values of the MATi cards stay, with a note, as in Nastran. Temperatures that differ between grid
/// points, missing tables and materials are problems.
void apply_temperature(BulkData& bulk, const CaseControl& control, DeckFiles& files, DeckNotes& notes);

}  // namespace kalfem::nastran
