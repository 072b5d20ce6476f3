// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "kalfem/formats/nastran.hpp"
#include "kalfem/formats/rewriting/deck_text.hpp"

namespace kalfem::rewriting {

/// The bulk data of a deck whose texts, INCLUDEs in their places, read_nastran() accepts.
std::unique_ptr<DeckText> nastran_text(const std::string& content, const std::string& source,
                                       const NastranIncludes& includes);

}  // namespace kalfem::rewriting
