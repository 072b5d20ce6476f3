#pragma once

#include <filesystem>

#include "kalfem/formats/deck.hpp"

namespace kalfem {

enum class DeckFormat { automatic, abaqus, nastran };

/// Whether a file's name ends as those of decks do: .inp, .bdf, .dat, .nas, .blk, in any case.
bool is_deck(const std::filesystem::path& file);

/// Reads another code's input file, see abaqus.hpp and nastran.hpp. `automatic`: a name that ends in .inp is of Abaqus
/// or CalculiX, any other of Nastran.
Deck read_deck(const std::filesystem::path& file, DeckFormat format = DeckFormat::automatic);

}  // namespace kalfem
