// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/formats/deck.hpp"
#include "kalfem/formats/nastran/bulk_data.hpp"
#include "kalfem/formats/nastran/card_stream.hpp"

namespace kalfem::nastran {

/// What the reader of a card writes into.
struct Reading {
  BulkData& bulk;
  DeckNotes& notes;
  DeckFiles& files;
  Ledger* ledger = nullptr;  ///< where it is kept
  bool chooses_nsm = true;   ///< NSM, NSM1, ... add mass: the case control chooses a set, or there is none

  void note(const Card& card, const std::string& what, const std::string& consequence, DeckNoteKind kind) const {
    notes.add(files.location(card.place), what, consequence, kind);
  }
  /// The same of a field that has been read and is not used.
  void tell(const Card& card, std::size_t field, const std::string& what, const std::string& consequence,
            DeckNoteKind kind) const {
    card.mark(field, FieldUse::told);
    note(card, what, consequence, kind);
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
std::span<const CardReader> temperature_cards();  ///< and tables of materials by temperature
std::span<const CardReader> property_cards();     ///< of shells, solids, rods, scalar elements
std::span<const CardReader> section_cards();      ///< of beams
std::span<const CardReader> constraint_cards();
std::span<const CardReader> load_cards();
std::span<const CardReader> matrix_cards();  ///< DMIG, PARAM

/// Adds a property under its number; throws CardError where its kind of element has one of this number.
void add_property(BulkData& bulk, Id id, PropertyCard card);
/// GE of a scalar element or its property, which is not used.
void tell_structural_damping(const Card& card, const Reading& in, std::size_t field);

/// Reads a card of any kind. Cards that are not read become notes, with what that means, or are passed over where they
/// only ask for results or belong to other analyses; see unused_card().
void read_card(const Card& card, const Reading& reading);

/// What a card that is not read means for the model; nothing for one that has no effect on K, M and C. Stiffness, mass
/// and connections are told as missing, a load or table by its class, an unknown card as doubtful, or as missing where
/// its name is that of an element.
void unused_card(const Card& card, const Reading& reading);

/// Number of dimensions of a section shape of PBARL and PBEAML, 0 of an unknown one.
std::size_t dimension_count(const std::string& shape);

/// Cross-section of the shapes ROD, TUBE, TUBE2, BAR, BOX, BOX1, I, I1, H, T, T1, T2, CHAN, CHAN1, CHAN2, CROSS, L, Z
/// and HAT, with the plane 1 (y) upright in the manual's figures and z to the left in them.
///
/// Area and moments of inertia are those of the rectangles that make up the section. Torsion: exact for circles and
/// rectangles [TG70], box_torsion() for boxes, sum of l t^3 / 3 for open walls. Shear centre of open walls by
/// sectorial areas [Vla61]: with omega from the centroid, I_wy - a_y I_yz + a_z I_yy = 0 and
/// I_wz - a_y I_zz + a_z I_yz = 0. Shear factors: [Cow66] for circles, tubes and boxes, 5/6 for rectangles; of open
/// walls the share of the walls along the force, of those along z times 5/6.
/// Throws CardError for an unknown shape and for lengths that do not fit together.
SectionCard section_of_shape(const std::string& shape, const std::vector<double>& dimensions, const std::string& title);

}  // namespace kalfem::nastran
