// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {

/// After a card has been read: tells of each filled field that its reader left untouched. Fields that the manual gives
/// and that have no effect on stiffness, mass, damping and constraints are notes of their kind; any other field is a
/// doubtful one, or one without effect where it is 0. Where a ledger is kept, enters what became of every filled field
/// under the name `shown`.
void account_for_fields(const Card& card, const Reading& reading, std::string_view shown);

}  // namespace kalfem::nastran
