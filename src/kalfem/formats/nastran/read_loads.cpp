// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {
namespace {

void tell_all(const Card& card) {
  for (std::size_t i = 1; i <= card.size(); ++i) card.mark(i, FieldUse::told);
}

/// Readers of loads do their work only where load cases are wanted, and for a preload; otherwise the card has no
/// effect.
template <void (*read)(const Card&, const Reading&)>
void if_wanted(const Card& card, const Reading& in) {
  if (in.bulk.with_loads) return read(card, in);
  tell_all(card);
  in.note(card, card.name, "loads are ignored; a case reads them with `deck_cases: true` of `static`",
          DeckNoteKind::unused);
}

Eigen::Vector3d vector_at(const Card& card, std::size_t first) {
  Eigen::Vector3d vector;
  for (std::size_t i = 0; i < 3; ++i) vector[static_cast<Eigen::Index>(i)] = card.real_or(first + i, 0.0, "N");
  return vector;
}

/// A load, or a form of one, that is not read is refused where a load case holds its set.
void keep_unread(const Card& card, const Reading& in, const std::string& what) {
  in.bulk.unread_loads.push_back({.set = card.id(1, "SID"), .what = what, .where = card.place});
  tell_all(card);
}

void read_unread(const Card& card, const Reading& in) {
  if (in.bulk.with_loads) return keep_unread(card, in, card.name);
  tell_all(card);
  in.note(card, card.name, "kalfem does not read this load; it refuses the load cases of `static` that hold it",
          DeckNoteKind::unused);
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

/// FORCE1, MOMENT1: SID G F G1 G2. FORCE2, MOMENT2: SID G F G1 G2 G3 G4.
void read_directed_force(const Card& card, const Reading& in) {
  ForceCard load{.set = card.id(1, "SID"),
                 .node = card.id(2, "G"),
                 .is_moment = card.name.starts_with("MOMENT"),
                 .size = card.real(3, "F"),
                 .where = card.place};
  const std::size_t last = card.name.ends_with('1') ? 5 : 7;
  for (std::size_t i = 4; i <= last; ++i) load.along.push_back(card.id(i, "G1, G2, ..."));
  in.bulk.forces.push_back(std::move(load));
}

/// SLOAD: SID S1 F1 S2 F2 S3 F3, forces at scalar points.
void read_sload(const Card& card, const Reading& in) {
  for (const std::size_t i : {2, 4, 6})
    if (!card.blank(i))
      in.bulk.forces.push_back({.set = card.id(1, "SID"),
                                .node = card.id(i, "S"),
                                .vector = {card.real(i + 1, "F"), 0.0, 0.0},
                                .where = card.place});
}

/// PLOAD: SID P G1 G2 G3 G4.
void read_pload(const Card& card, const Reading& in) {
  FacePressureCard load{.set = card.id(1, "SID"), .corners = {}, .pressure = card.real(2, "P"), .where = card.place};
  for (std::size_t i = 3; i <= 6; ++i)
    if (i < 6 || !card.blank(i)) load.corners.push_back(card.id(i, "G"));
  in.bulk.face_pressures.push_back(std::move(load));
}

/// PLOAD1: SID EID TYPE SCALE X1 P1 X2 P2, TYPE being FX .. MZ in basic axes or FXE .. MZE in those of the element.
void read_pload1(const Card& card, const Reading& in) {
  static constexpr std::array<std::string_view, 6> types = {"FX", "FY", "FZ", "MX", "MY", "MZ"};
  const std::string type = card.text(3), scale = card.text(4);
  const auto found = std::ranges::find(types, std::string_view(type).substr(0, 2));
  const bool element_axes = type.size() == 3 && type[2] == 'E';
  if (found == types.end() || (type.size() != 2 && !element_axes))
    throw CardError(title(card) + ": TYPE is '" + type + "'", "it names a force or moment and its axes",
                    "write FX to MZ, or FXE to MZE");
  if (scale == "LEPR" || scale == "FRPR")
    return keep_unread(card, in, "PLOAD1 with SCALE " + scale + ", a load by the projected length,");
  if (scale != "LE" && scale != "FR")
    throw CardError(title(card) + ": SCALE is '" + scale + "'", "it tells lengths from shares of the length",
                    "write LE or FR");
  BeamLoadCard load{.set = card.id(1, "SID"),
                    .element = card.id(2, "EID"),
                    .direction = static_cast<int>(found - types.begin()),
                    .element_axes = element_axes,
                    .fractions = scale == "FR",
                    .where = card.place};
  load.places[0] = load.places[1] = card.real(5, "X1");
  load.values[0] = card.real(6, "P1");
  if (!card.blank(7)) load.places[1] = card.real(7, "X2");
  load.values[1] = card.real_or(8, load.values[0], "P2");
  load.concentrated = load.places[0] == load.places[1];
  for (const std::size_t read : {3, 4}) card.mark(read, FieldUse::used);
  in.bulk.beam_loads.push_back(load);
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
  if (vector_at(card, 10) != Eigen::Vector3d::Zero())
    return keep_unread(card, in, "PLOAD4 with a traction along N1, N2, N3");
  if (card.says(13, "LINE")) return keep_unread(card, in, "PLOAD4 with a load of lines (SORL LINE)");
  for (const auto& [field, word] : {std::pair<std::size_t, const char*>{13, "SURF"}, {14, "NORM"}})
    static_cast<void>(card.says(field, word));  // as without them
  PressureCard load{.set = card.id(1, "SID"), .elements = {}, .pressure = card.real(3, "P1"), .where = card.place};
  const Id first = card.id(2, "EID");
  load.elements.push_back({first, first, 1, true});
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 3; i <= 6; ++i)
    if (!card.blank(i)) sum += card.real(i, "P"), ++count;
  if (std::abs(sum / count - load.pressure) > 1e-9 * std::abs(load.pressure))
    in.note(card, "PLOAD4 with different pressures at the corners", "their mean acts on the whole face",
            DeckNoteKind::changed);
  load.pressure = sum / count;
  if (card.says(7, "THRU")) {
    load.elements.front() = {first, card.id(8, "EID2"), 1, false};
  } else {
    load.first_corner = card.id_or(7, 0, "G1");
    load.other_corner = card.id_or(8, 0, "G3");
  }
  in.bulk.pressures.push_back(std::move(load));
}

/// GRAV: SID CID A N1 N2 N3.
void read_grav(const Card& card, const Reading& in) {
  in.bulk.gravities.push_back({.set = card.id(1, "SID"),
                               .system = card.id_or(2, 0, "CID"),
                               .vector = card.real_or(3, 0.0, "A") * vector_at(card, 4),
                               .where = card.place});
  if (!card.blank(7)) in.tell(card, 7, "MB of GRAV", "the axes are those of this deck", DeckNoteKind::unused);
}

/// RFORCE: SID G CID A R1 R2 R3 METHOD, RACC.
void read_rforce(const Card& card, const Reading& in) {
  if (card.real_or(9, 0.0, "RACC") != 0.0) return keep_unread(card, in, "RFORCE with an angular acceleration RACC");
  for (const std::size_t field : {8, 10, 11})  // METHOD, MB, IDRF
    if (!card.blank(field))
      in.tell(card, field, "METHOD, MB and IDRF of RFORCE", "centrifugal forces are those of the mass matrix",
              DeckNoteKind::unused);
  in.bulk.rotations.push_back({.set = card.id(1, "SID"),
                               .node = card.id_or(2, 0, "G"),
                               .system = card.id_or(3, 0, "CID"),
                               .revolutions = card.real_or(4, 0.0, "A") * vector_at(card, 5),
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
                                                         {"FORCE1", if_wanted<read_directed_force>},
                                                         {"MOMENT1", if_wanted<read_directed_force>},
                                                         {"FORCE2", if_wanted<read_directed_force>},
                                                         {"MOMENT2", if_wanted<read_directed_force>},
                                                         {"SLOAD", if_wanted<read_sload>},
                                                         {"PLOAD", if_wanted<read_pload>},
                                                         {"PLOAD1", if_wanted<read_pload1>},
                                                         {"PLOAD2", if_wanted<read_pload2>},
                                                         {"PLOAD4", if_wanted<read_pload4>},
                                                         {"GRAV", if_wanted<read_grav>},
                                                         {"RFORCE", if_wanted<read_rforce>},
                                                         {"LOAD", if_wanted<read_load>},
                                                         {"SPCD", if_wanted<read_spcd>},
                                                         {"ACCEL", read_unread},
                                                         {"ACCEL1", read_unread},
                                                         {"ACCEL2", read_unread},
                                                         {"BOLTFOR", read_unread},
                                                         {"CLOAD", read_unread},
                                                         {"FORCEAX", read_unread},
                                                         {"LOADCYH", read_unread},
                                                         {"LOADCYN", read_unread},
                                                         {"LOADCYT", read_unread},
                                                         {"MOMAX", read_unread},
                                                         {"PLOADB3", read_unread},
                                                         {"PLOADE1", read_unread},
                                                         {"PLOADX", read_unread},
                                                         {"PLOADX1", read_unread},
                                                         {"PRESAX", read_unread},
                                                         {"QVOL", read_unread},
                                                         {"RFORCE1", read_unread},
                                                         {"RFORCE2", read_unread}});

}  // namespace

std::span<const CardReader> load_cards() { return load_readers; }

}  // namespace kalfem::nastran
