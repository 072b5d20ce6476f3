#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {
namespace {

/// Whether a whole number stands where a node or the first component of a vector may stand.
bool names_node(const Card& card, std::size_t i) {
  return card.is_integer(i) && card.blank(i + 1) && card.blank(i + 2);
}

Eigen::Vector3d vector_at(const Card& card, std::size_t first, const char* what) {
  Eigen::Vector3d vector;
  for (std::size_t i = 0; i < 3; ++i) vector[static_cast<Eigen::Index>(i)] = card.real_or(first + i, 0.0, what);
  return vector;
}

/// Three letters of OFFT; a number there is BIT, which only concerns stress.
std::array<char, 3> offset_axes(const Card& card, std::size_t i, const std::string& otherwise) {
  const auto word = card.blank(i) || card.is_number(i) ? otherwise : card.text(i);
  if (word.size() != 3 || word.find_first_not_of("GBOE") != std::string::npos || word[0] == 'O' || word[0] == 'E')
    throw CardError(title(card) + ": OFFT is '" + word + "'", "it is three letters such as GGG, BGG or GOO",
                    "mend the field");
  return {word[0], word[1], word[2]};
}

BeamDefaults read_defaults(const Card& card) {
  BeamDefaults defaults;
  defaults.property = card.id_or(2, 0, "PID");
  if (names_node(card, 5))
    defaults.orientation_node = card.id(5, "G0");
  else if (!card.blank(5) || !card.blank(6) || !card.blank(7))
    defaults.orientation = vector_at(card, 5, "X");
  const auto axes = offset_axes(card, 8, "GGG");
  defaults.axes.assign(axes.begin(), axes.end());
  return defaults;
}

void read_baror(const Card& card, const Reading& in) { in.bulk.bar_defaults = read_defaults(card); }
void read_beamor(const Card& card, const Reading& in) { in.bulk.beam_defaults = read_defaults(card); }

/// BAROR and BEAMOR may stand behind: what they fill in is marked by 0 and by '?'.
void read_beam(const Card& card, const Reading& in) {
  BeamCard beam;
  beam.id = card.id(1, "EID");
  beam.property = card.id_or(2, 0, "PID");
  beam.nodes = {card.id(3, "GA"), card.id(4, "GB")};
  if (names_node(card, 5))
    beam.orientation_node = card.id(5, "G0");
  else
    beam.orientation = vector_at(card, 5, "X");
  const bool has_axes = !card.blank(8) && !card.is_number(8);
  beam.axes = has_axes ? offset_axes(card, 8, "GGG") : std::array{'?', '?', '?'};
  beam.pins = {card.components(9, "PA"), card.components(10, "PB")};
  beam.offsets.col(0) = vector_at(card, 11, "WA");
  beam.offsets.col(1) = vector_at(card, 14, "WB");
  beam.is_bar = card.name == "CBAR";
  beam.where = card.place;
  if (!card.blank(17) || !card.blank(18))
    in.note(card, "warping (SA, SB of CBEAM)", "torsion is that of St Venant, without the stiffness of held warping");
  in.bulk.element_ids.emplace_back(beam.id, card.place);
  in.bulk.beams.push_back(beam);
}

void add_rod(const Card& card, const Reading& in, const char* kind, Id property, std::size_t nodes) {
  RodCard rod;
  rod.id = card.id(1, "EID");
  rod.kind = kind;
  rod.property = property;
  rod.nodes = {card.id(nodes, "G1"), card.id(nodes + 1, "G2")};
  rod.where = card.place;
  in.bulk.element_ids.emplace_back(rod.id, card.place);
  in.bulk.rods.push_back(rod);
}

void read_rod(const Card& card, const Reading& in) {
  add_rod(card, in, "CROD", card.id_or(2, card.id(1, "EID"), "PID"), 3);
}
void read_tube(const Card& card, const Reading& in) {
  add_rod(card, in, "CTUBE", card.id_or(2, card.id(1, "EID"), "PID"), 3);
}

void read_conrod(const Card& card, const Reading& in) {
  const Id id = card.id(1, "EID");
  RodSection section{card.id(4, "MID"), card.real_or(5, 0.0, "A"), card.real_or(6, 0.0, "J"),
                     card.real_or(8, 0.0, "NSM")};
  add_rod(card, in, "CONROD", 0, 2);
  in.bulk.conrods.try_emplace(id, PropertyCard{"CONROD", section, card.place});
}

constexpr auto beam_readers = std::to_array<CardReader>({{"CBAR", read_beam},
                                                         {"CBEAM", read_beam},
                                                         {"BAROR", read_baror},
                                                         {"BEAMOR", read_beamor},
                                                         {"CROD", read_rod},
                                                         {"CTUBE", read_tube},
                                                         {"CONROD", read_conrod}});

}  // namespace

std::span<const CardReader> beam_cards() { return beam_readers; }

}  // namespace kalfem::nastran
