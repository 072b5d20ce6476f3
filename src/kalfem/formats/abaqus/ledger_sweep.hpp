// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/formats/abaqus/raw_deck.hpp"
#include "kalfem/formats/ledger.hpp"

namespace kalfem::abaqus {

/// Settles every parameter of a keyword line and every field of a data line that is kept, once the model is built. What
/// the reader asked for is used. Of the rest, what is known to have no effect on a linear model is told, and a
/// parameter or field that may change the model is a note of the kind `missing`; further fields behind a line's own are
/// told as doubtful. A keyword that nothing refers to is told as a whole. `ledger` may be nullptr.
void settle_ledger(const RawDeck& raw, DeckNotes& notes, const Problems& problems, Ledger* ledger);

/// Takes back the fields of a line from a position on, which were looked at and do not count.
void forget_from(const DataLine& line, std::size_t first);

}  // namespace kalfem::abaqus
