// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran/card_ledger.hpp"

#include <algorithm>
#include <array>
#include <unordered_map>

namespace kalfem::nastran {
namespace {

constexpr auto unused = DeckNoteKind::unused;

/// Fields of a card that kalfem leaves aside; `step` repeats them on the card, 0: not.
struct LeftAside {
  std::string_view card;
  std::size_t first, last, step;
  std::string_view names, consequence;
  DeckNoteKind kind = unused;
};

constexpr std::string_view expansion = "thermal expansion is not used";
constexpr std::string_view limits = "limits of stress have no effect on stiffness and mass";
constexpr std::string_view recovery = "where stresses are asked for has no effect on stiffness and mass";
constexpr std::string_view one_structure = "superelements are ignored; the deck is read as one structure";

constexpr auto all_left_aside = std::to_array<LeftAside>({
    {"GRID", 8, 8, 0, "SEID", one_structure},
    {"GRDSET", 8, 8, 0, "SEID", one_structure},
    {"MAT1", 6, 7, 0, "A, TREF", expansion},
    {"MAT1", 9, 11, 0, "ST, SC, SS", limits},
    {"MAT1", 12, 12, 0, "MCSID", "it concerns output alone"},
    {"MAT2", 9, 12, 0, "A1, A2, A3, TREF", expansion},
    {"MAT2", 14, 16, 0, "ST, SC, SS", limits},
    {"MAT2", 17, 17, 0, "MCSID", "it concerns output alone"},
    {"MAT8", 9, 11, 0, "A1, A2, TREF", expansion},
    {"MAT8", 12, 16, 0, "XT, XC, YT, YC, S", limits},
    {"MAT8", 18, 19, 0, "F12, STRN", limits},
    {"MAT9", 24, 30, 0, "A1 to A6, TREF", expansion},
    {"PSHELL", 9, 10, 0, "Z1, Z2", recovery},
    {"PCOMP", 4, 5, 0, "SB, FT", limits},
    {"PCOMP", 6, 6, 0, "TREF", expansion},
    {"PCOMP", 12, 12, 4, "SOUT", recovery},
    {"PCOMPG", 4, 5, 0, "SB, FT", limits},
    {"PCOMPG", 6, 6, 0, "TREF", expansion},
    {"PCOMPG", 9, 9, 8, "GPLYID", "the number of a ply concerns output alone"},
    {"PCOMPG", 13, 13, 8, "SOUT", recovery},
    {"PSOLID", 5, 5, 0, "STRESS", recovery},
    {"PROD", 5, 5, 0, "C", recovery},
    {"CONROD", 7, 7, 0, "C", recovery},
    {"PBAR", 9, 16, 0, "C1 to F2", recovery},
    {"PBARL", 3, 3, 0, "GROUP", "the group only names the library of sections"},
    {"PBEAML", 3, 3, 0, "GROUP", "the group only names the library of sections"},
    {"CELAS2", 8, 8, 0, "S", recovery},
    {"PELAS", 4, 4, 4, "S", recovery},
    {"PBUSH1D", 6, 7, 0, "SA, SE", recovery},
    {"RBAR", 8, 9, 0, "ALPHA, TREF", expansion},
    {"RROD", 6, 7, 0, "ALPHA, TREF", expansion},
    {"DMIG", 5, 6, 0, "TOUT, POLAR", "they concern output and complex matrices alone"},
    {"DMIG", 8, 8, 0, "NCOL", "the columns are counted"},
});

const LeftAside* left_aside(const Card& card, std::size_t i) {
  for (const auto& entry : all_left_aside) {
    if (entry.card != card.name || i < entry.first) continue;
    const std::size_t within = entry.step == 0 ? i : entry.first + (i - entry.first) % entry.step;
    if (within <= entry.last) return &entry;
  }
  return nullptr;
}

void tell_untouched(const Card& card, const Reading& in, std::size_t i) {
  card.mark(i, FieldUse::told);
  if (const auto* entry = left_aside(card, i))
    return in.note(card, std::string(entry->names) + " of " + card.name, std::string(entry->consequence), entry->kind);
  const auto value = parse_real(card.raw(i));
  const std::string what = place_on_card(i) + " of " + card.name;
  if (value && *value == 0.0)
    in.note(card, what, "kalfem knows no such field; it is 0", unused);
  else
    in.note(card, what, "kalfem knows no such field, or not in this place: it is not used", DeckNoteKind::doubtful);
}

/// Lines of a long list are one entry.
std::string ledger_field(std::size_t i) {
  constexpr std::size_t lines_apart = 4;
  return i <= 8 * lines_apart ? place_on_card(i) : "line 5 and beyond, field " + std::to_string((i - 1) % 8 + 2);
}

}  // namespace

void account_for_fields(const Card& card, const Reading& in, std::string_view shown) {
  for (std::size_t i = 1; i <= card.size(); ++i) {
    if (card.blank(i)) continue;
    if (card.use(i) == FieldUse::untouched) tell_untouched(card, in, i);
    if (in.ledger != nullptr)
      in.ledger->enter(in.files.location(card.place), shown, ledger_field(i),
                       card.use(i) == FieldUse::used ? FieldFate::used : FieldFate::told);
  }
}

}  // namespace kalfem::nastran
