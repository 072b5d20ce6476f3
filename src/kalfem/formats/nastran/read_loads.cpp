#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {
namespace {

/// Readers of loads do their work only where load cases are wanted; otherwise the card is one that is not used.
template <void (*read)(const Card&, const Reading&)>
void if_wanted(const Card& card, const Reading& in) {
  in.bulk.with_loads ? read(card, in) : unused_card(card, in);
}

Eigen::Vector3d vector_at(const Card& card, std::size_t first) {
  Eigen::Vector3d vector;
  for (std::size_t i = 0; i < 3; ++i) vector[static_cast<Eigen::Index>(i)] = card.real_or(first + i, 0.0, "N");
  return vector;
}

/// FORCE, MOMENT: SID G CID F N1 N2 N3.
void read_force(const Card& card, const Reading& in) {
  in.bulk.forces.push_back({.set = card.id(1, "SID"),
                            .node = card.id(2, "G"),
                            .system = card.id_or(3, 0, "CID"),
                            .vector = card.real_or(4, 0.0, "F") * vector_at(card, 5),
                            .is_moment = card.name == "MOMENT",
                            .where = card.place});
}

/// PLOAD2: SID P EID1 EID2 ... or EID1 THRU EID2.
void read_pload2(const Card& card, const Reading& in) {
  in.bulk.pressures.push_back({.set = card.id(1, "SID"),
                               .elements = card.id_list(3, "EID"),
                               .pressure = card.real(2, "P"),
                               .where = card.place});
}

/// PLOAD4: SID EID P1 P2 P3 P4 G1 G3, or THRU EID2 in the place of G1 G3; then CID N1 N2 N3 of a traction.
void read_pload4(const Card& card, const Reading& in) {
  PressureCard load{.set = card.id(1, "SID"), .elements = {}, .pressure = card.real(3, "P1"), .where = card.place};
  const Id first = card.id(2, "EID");
  load.elements.push_back({first, first, 1, true});
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 3; i <= 6; ++i)
    if (!card.blank(i)) sum += card.real(i, "P"), ++count;
  if (std::abs(sum / count - load.pressure) > 1e-9 * std::abs(load.pressure))
    in.note(card, "PLOAD4 with different pressures at the corners", "their mean acts on the whole face",
            DeckNoteKind::doubtful);
  load.pressure = sum / count;
  if (card.text(7) == "THRU") {
    load.elements.front() = {first, card.id(8, "EID2"), 1, false};
  } else {
    load.first_corner = card.id_or(7, 0, "G1");
    load.other_corner = card.id_or(8, 0, "G3");
  }
  if (vector_at(card, 10) != Eigen::Vector3d::Zero())
    throw CardError(title(card) + ": a traction along N1, N2, N3 is not read", "pressure acts normal to the face",
                    "describe this load in the case");
  in.bulk.pressures.push_back(std::move(load));
}

/// GRAV: SID CID A N1 N2 N3.
void read_grav(const Card& card, const Reading& in) {
  in.bulk.gravities.push_back({.set = card.id(1, "SID"),
                               .system = card.id_or(2, 0, "CID"),
                               .vector = card.real_or(3, 0.0, "A") * vector_at(card, 4),
                               .where = card.place});
}

/// LOAD: SID S S1 L1 S2 L2 ...
void read_load(const Card& card, const Reading& in) {
  auto& sum = in.bulk.load_sums[card.id(1, "SID")];
  const double all = card.real(2, "S");
  for (std::size_t i = 3; i + 1 <= card.size(); i += 2)
    if (!card.blank(i)) sum.emplace_back(card.id(i + 1, "L"), all * card.real(i, "S"));
}

/// SPCD: SID G C D, two of them.
void read_spcd(const Card& card, const Reading& in) {
  for (const std::size_t first : {2, 5})
    if (!card.blank(first))
      in.bulk.imposed.push_back({.set = card.id(1, "SID"),
                                 .node = card.id(first, "G"),
                                 .components = card.components(first + 1, "C"),
                                 .value = card.real_or(first + 2, 0.0, "D"),
                                 .where = card.place});
}

constexpr auto load_readers = std::to_array<CardReader>({{"FORCE", if_wanted<read_force>},
                                                         {"MOMENT", if_wanted<read_force>},
                                                         {"PLOAD2", if_wanted<read_pload2>},
                                                         {"PLOAD4", if_wanted<read_pload4>},
                                                         {"GRAV", if_wanted<read_grav>},
                                                         {"LOAD", if_wanted<read_load>},
                                                         {"SPCD", if_wanted<read_spcd>}});

}  // namespace

std::span<const CardReader> load_cards() { return load_readers; }

}  // namespace kalfem::nastran
