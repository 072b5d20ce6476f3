#pragma once

#include <span>
#include <string_view>

#include "kalfem/formats/deck.hpp"
#include "kalfem/formats/nastran/bulk_data.hpp"
#include "kalfem/formats/nastran/card_stream.hpp"

namespace kalfem::nastran {

/// What the reader of a card writes into.
struct Reading {
  BulkData& bulk;
  DeckNotes& notes;
  DeckFiles& files;

  void note(const Card& card, const std::string& what, const std::string& consequence,
            DeckNoteKind kind = DeckNoteKind::unused) const {
    notes.add(files.location(card.place), what, consequence, kind);
  }
};

/// How one kind of card is read; throws CardError.
struct CardReader {
  std::string_view name;
  void (*read)(const Card&, const Reading&);
};

std::span<const CardReader> node_cards();    ///< nodes and coordinate systems
std::span<const CardReader> shell_cards();   ///< shells and solids
std::span<const CardReader> beam_cards();    ///< beams and rods
std::span<const CardReader> scalar_cards();  ///< springs, dashpots, bushings, masses
std::span<const CardReader> material_cards();
std::span<const CardReader> property_cards();  ///< of shells, solids, rods, scalar elements
std::span<const CardReader> section_cards();   ///< of beams
std::span<const CardReader> constraint_cards();
std::span<const CardReader> matrix_cards();  ///< DMIG, PARAM

/// Reads a card of any kind. Cards that are not read become notes, with what that means, or are passed over where they
/// only ask for results or belong to other analyses; see unused_card().
void read_card(const Card& card, const Reading& reading);

/// What a card that is not read means for the model; nothing for one that has no effect on K, M and C. Stiffness, mass
/// and connections are told as missing, a load or table by its class, an unknown card as doubtful, or as missing where
/// its name is that of an element.
void unused_card(const Card& card, const Reading& reading);

}  // namespace kalfem::nastran
