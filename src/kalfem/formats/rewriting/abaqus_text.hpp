// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "kalfem/formats/abaqus.hpp"
#include "kalfem/formats/rewriting/deck_text.hpp"

namespace kalfem::rewriting {

/// The keywords of a deck of Abaqus or CalculiX that read_abaqus() accepts; `origins` as it found them.
std::unique_ptr<DeckText> abaqus_text(const std::string& content, const std::string& source, const DeckLoader& loader,
                                      const DeckOrigins& origins);

}  // namespace kalfem::rewriting
