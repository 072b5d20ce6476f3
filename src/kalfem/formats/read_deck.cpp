#include "kalfem/formats/read_deck.hpp"

#include <algorithm>
#include <cctype>

#include "kalfem/formats/abaqus.hpp"
#include "kalfem/formats/nastran.hpp"

namespace kalfem {

Deck read_deck(const std::filesystem::path& file, DeckFormat format) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (format == DeckFormat::automatic) format = ending == ".inp" ? DeckFormat::abaqus : DeckFormat::nastran;
  return format == DeckFormat::abaqus ? read_abaqus(file) : read_nastran(file);
}

}  // namespace kalfem
