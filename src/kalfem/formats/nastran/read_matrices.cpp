#include <algorithm>
#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {
namespace {

/// Header: DMIG NAME 0 IFO TIN TOUT; column: DMIG NAME GJ CJ - then G C A B of each entry.
void read_dmig(const Card& card, const Reading& in) {
  DmigMatrix& matrix = in.bulk.matrices[card.text(1)];
  const bool is_header = card.integer_or(2, 0, "GJ") == 0;
  if (matrix.where.line == 0 || is_header) matrix.where = card.place;
  if (is_header) {
    matrix.form = static_cast<int>(card.integer_or(3, 6, "IFO"));
    matrix.complex = card.integer_or(4, 1, "TIN") > 2;
    return;
  }
  DmigEntry entry;
  entry.column = card.id(2, "GJ");
  entry.column_direction = static_cast<std::int8_t>(card.component(3, "CJ"));
  entry.where = card.place;
  for (std::size_t i = 5; i <= card.size(); i += 4) {
    if (card.blank(i)) continue;
    entry.row = card.id(i, "G");
    entry.row_direction = static_cast<std::int8_t>(card.component(i + 1, "C"));
    entry.value = card.real_or(i + 2, 0.0, "A");
    matrix.entries.push_back(entry);
  }
}

void read_param(const Card& card, const Reading& in) {
  const auto name = card.text(1);
  if (name == "WTMASS") {
    in.bulk.mass_factor = card.real(2, "WTMASS");
    if (!(in.bulk.mass_factor > 0.0))
      throw CardError("PARAM WTMASS is " + std::string(card.raw(2)), "it multiplies all mass",
                      "give a positive factor");
  } else if (name == "COUPMASS") {
    in.bulk.coupled_mass = card.text(2) == "YES" || (card.is_number(2) && card.real(2, "COUPMASS") > 0.0);
  } else if (name == "AUTOSPC") {
    in.bulk.hold_singular = card.text(2) != "NO";
  } else if (name == "G" || name == "W3" || name == "W4" || name == "GFL") {
    in.note(card, "PARAM " + name, "structural damping is not read; give modal damping instead");
  } else if (name == "K6ROT") {
    in.bulk.drilling = std::max(0.0, card.real_or(2, 100.0, "K6ROT"));
  } else if (name == "CM2" || name == "CK2" || name == "CB2" || name == "CM1" || name == "CK1") {
    in.note(card, "PARAM " + name, "direct input matrices are not scaled by it");
  }
}

constexpr auto matrix_readers = std::to_array<CardReader>({{"DMIG", read_dmig}, {"PARAM", read_param}});

}  // namespace

std::span<const CardReader> matrix_cards() { return matrix_readers; }

}  // namespace kalfem::nastran
