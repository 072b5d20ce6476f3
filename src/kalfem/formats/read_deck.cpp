#include "kalfem/formats/read_deck.hpp"

#include <algorithm>
#include <array>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/abaqus.hpp"
#include "kalfem/formats/nastran.hpp"

namespace kalfem {
namespace {

std::string ending_of(const std::filesystem::path& file) { return lower_case(file.extension().string()); }

}  // namespace

bool is_deck(const std::filesystem::path& file) {
  static constexpr std::array endings = {".inp", ".bdf", ".dat", ".nas", ".blk"};
  return std::ranges::find(endings, ending_of(file)) != endings.end();
}

Deck read_deck(const std::filesystem::path& file, DeckFormat format) {
  if (format == DeckFormat::automatic) format = ending_of(file) == ".inp" ? DeckFormat::abaqus : DeckFormat::nastran;
  return format == DeckFormat::abaqus ? read_abaqus(file) : read_nastran(file);
}

}  // namespace kalfem
