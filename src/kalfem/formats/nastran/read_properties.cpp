// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <numbers>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {

// Cards of one kind of element share a range of numbers; those of another kind have their own.
void add_property(BulkData& bulk, Id id, PropertyCard card) {
  const auto kind_of = [](const PropertyCard& property) -> std::string {
    if (std::holds_alternative<PcompCard>(property.law)) return "PSHELL";
    if (property.kind.starts_with("PBAR")) return "PBAR";
    if (property.kind.starts_with("PBEAM")) return "PBEAM";
    return property.kind;
  };
  const auto [first, last] = bulk.properties.equal_range(id);
  for (auto other = first; other != last; ++other)
    if (kind_of(other->second) == kind_of(card))
      throw CardError(card.kind + " " + std::to_string(id) + " is defined twice",
                      "first in line " + std::to_string(other->second.where.line), "remove one of the cards");
  bulk.properties.emplace(id, std::move(card));
}

void tell_structural_damping(const Card& card, const Reading& in, std::size_t field) {
  if (card.blank(field)) return;
  const bool is_zero = card.real(field, "GE") == 0.0;
  in.tell(card, field, "structural damping (GE)", is_zero ? "it is 0" : "it is ignored; give modal damping instead",
          is_zero ? DeckNoteKind::unused : DeckNoteKind::changed);
}

namespace {

template <typename Law>
void add_material(const Card& card, const Reading& in, const Law& law) {
  if (!in.bulk.materials.try_emplace(card.id(1, "MID"), MaterialCard{law, card.place}).second)
    throw CardError("material " + std::to_string(card.id(1, "MID")) + " is defined twice", "",
                    "remove one of the cards");
}

/// GE of a material is told for each element that has it, see note_damped_elements().
void note_damping(const Card& card, const Reading& in, std::size_t field) {
  if (card.blank(field)) return;
  if (card.real(field, "GE") != 0.0)
    in.bulk.damped_materials.emplace(card.id(1, "MID"), card.place);
  else
    in.note(card, "structural damping (GE)", "it is 0", DeckNoteKind::unused);
  card.mark(field, FieldUse::told);
}

/// Coefficients of thermal expansion, from field `first` to `last`: they only tell that a temperature is a load.
void note_expansion(const Card& card, const Reading& in, std::size_t first, std::size_t last) {
  for (std::size_t field = first; field <= last; ++field)
    if (parse_real(card.raw(field)).value_or(0.0) != 0.0) in.bulk.expands = true;
}

void read_mat1(const Card& card, const Reading& in) {
  Material1 law;
  law.youngs_modulus = card.real_or(2, not_given, "E");
  law.shear_modulus = card.real_or(3, not_given, "G");
  law.poissons_ratio = card.real_or(4, not_given, "NU");
  law.density = card.real_or(5, 0.0, "RHO");
  note_expansion(card, in, 6, 6);
  note_damping(card, in, 8);
  add_material(card, in, law);
}

// The upper triangle G11, G12, G13, G22, G23, G33 of plane stress, row by row; MAT9 has the same order in space.
void read_mat2(const Card& card, const Reading& in) {
  Material2 law;
  std::size_t field = 2;
  for (int row = 0; row < 3; ++row)
    for (int column = row; column < 3; ++column, ++field)
      law.stiffness(row, column) = law.stiffness(column, row) = card.real_or(field, 0.0, "G");
  law.density = card.real_or(8, 0.0, "RHO");
  note_expansion(card, in, 9, 11);
  note_damping(card, in, 13);
  add_material(card, in, law);
}

void read_mat8(const Card& card, const Reading& in) {
  Material8 law;
  law.e1 = card.real(2, "E1");
  law.e2 = card.real(3, "E2");
  law.nu12 = card.real_or(4, 0.0, "NU12");
  law.g12 = card.real_or(5, 0.0, "G12");
  law.g13 = card.real_or(6, 0.0, "G1Z");
  law.g23 = card.real_or(7, 0.0, "G2Z");
  law.density = card.real_or(8, 0.0, "RHO");
  note_expansion(card, in, 9, 10);
  note_damping(card, in, 17);
  add_material(card, in, law);
}

void read_mat9(const Card& card, const Reading& in) {
  Material9 law;
  std::size_t field = 2;
  for (int row = 0; row < 6; ++row)
    for (int column = row; column < 6; ++column, ++field)
      law.stiffness(row, column) = law.stiffness(column, row) = card.real_or(field, 0.0, "G");
  law.density = card.real_or(23, 0.0, "RHO");
  note_expansion(card, in, 24, 29);
  note_damping(card, in, 31);
  add_material(card, in, law);
}

constexpr auto material_readers =
    std::to_array<CardReader>({{"MAT1", read_mat1}, {"MAT2", read_mat2}, {"MAT8", read_mat8}, {"MAT9", read_mat9}});

}  // namespace

std::span<const CardReader> material_cards() { return material_readers; }

namespace {

void add_property(const Card& card, const Reading& in, PropertyLaw law, std::vector<Change> changes = {}) {
  add_property(in.bulk, card.id(1, "PID"), {card.name, std::move(law), card.place, std::move(changes)});
}

/// The change of every element that has a property with structural damping.
void add_structural_damping(const Card& card, std::size_t field, std::vector<Change>& changes) {
  if (card.real_or(field, 0.0, "GE") != 0.0)
    changes.push_back({"structural damping (GE of " + card.name + ")", "it is ignored; give modal damping instead"});
  card.mark(field, FieldUse::told);
}

// MID1 is the membrane, MID2 bending, MID3 transverse shear. Bending is scaled by 12 I / T^3 (1 for a homogeneous
// plate), shear by TS/T (5/6).
void read_pshell(const Card& card, const Reading& in) {
  PshellCard shell;
  std::vector<Change> changes;
  shell.membrane = card.id_or(2, 0, "MID1");
  shell.thickness = card.real_or(3, not_given, "T");
  const Id bending = card.id_or(4, 0, "MID2");
  shell.bending = bending == -1 ? shell.membrane : bending;
  if (bending == -1) changes.push_back({"plane strain (MID2 = -1 of PSHELL)", "the shell is read as plane stress"});
  shell.bending_ratio = card.real_or(5, 1.0, "12I/T**3");
  shell.shear = card.id_or(6, 0, "MID3");
  shell.shear_ratio = card.real_or(7, 5.0 / 6.0, "TS/T");
  shell.nonstructural_mass = card.real_or(8, 0.0, "NSM");
  shell.coupling = card.id_or(11, 0, "MID4");
  if (shell.coupling > 0) {
    changes.push_back(
        {"coupling of stretching and bending (MID4 of PSHELL)", "it is ignored; give an eccentric layup as PCOMP"});
    card.mark(11, FieldUse::told);
  }
  const auto without = [&](std::size_t ratio, Id material, const char* what) {
    if (material <= 0 && !card.blank(ratio))
      in.tell(card, ratio, what, "it has no effect without that material", DeckNoteKind::unused);
  };
  without(5, shell.bending, "12I/T**3 of a PSHELL without MID2");
  without(7, shell.shear, "TS/T of a PSHELL without MID3");
  add_property(card, in, shell, std::move(changes));
}

void read_pshear(const Card& card, const Reading& in) {
  const PshearCard panel{.material = card.id(2, "MID"),
                         .thickness = card.real(3, "T"),
                         .nonstructural_mass = card.real_or(4, 0.0, "NSM"),
                         .effectiveness = {card.real_or(5, 0.0, "F1"), card.real_or(6, 0.0, "F2")}};
  if (!(panel.thickness > 0.0) || panel.effectiveness[0] < 0.0 || panel.effectiveness[1] < 0.0)
    throw CardError(title(card) + ": T is not positive, or F1 or F2 is negative", "", "correct them");
  add_property(card, in, panel);
}

/// The stack as it lies: a symmetric layout is given by its lower half.
void finish_laminate(const Card& card, const Reading& in, PcompCard laminate) {
  if (laminate.plies.empty()) throw CardError(title(card) + " has no plies", "", "give material and thickness of each");
  constexpr std::array layouts = {"", "SYM", "MEM", "BEND", "SMEAR", "SMCORE", "SYMEM", "SYBEND", "SYSMEAR"};
  if (std::ranges::find(layouts, laminate.layout) == layouts.end())
    throw CardError(title(card) + ": LAM is '" + laminate.layout + "'", "it says how the plies make up the laminate",
                    "correct the field, or leave it blank");
  if (laminate.layout.starts_with("SY")) {
    const auto half = laminate.plies;
    laminate.plies.insert(laminate.plies.end(), half.rbegin(), half.rend());
  }
  std::vector<Change> changes;
  if (!laminate.layout.empty() && laminate.layout != "SYM")
    changes.push_back({"LAM " + laminate.layout + " of " + card.name,
                       "this option is ignored: the laminate keeps its full stiffness"});
  add_structural_damping(card, 7, changes);
  add_property(card, in, std::move(laminate), std::move(changes));
}

PcompCard laminate_head(const Card& card) {
  PcompCard laminate;
  laminate.bottom = card.real_or(2, not_given, "Z0");
  laminate.nonstructural_mass = card.real_or(3, 0.0, "NSM");
  laminate.layout = card.text(8);
  return laminate;
}

/// Blank materials and thicknesses are those of the ply below.
void add_ply(const Card& card, std::size_t material, PcompCard& laminate) {
  const bool is_first = laminate.plies.empty();
  PlyCard ply = is_first ? PlyCard{} : laminate.plies.back();
  if (is_first || !card.blank(material)) ply.material = card.id(material, "MID");
  if (is_first || !card.blank(material + 1)) ply.thickness = card.real(material + 1, "T");
  ply.angle = card.real_or(material + 2, 0.0, "THETA");
  laminate.plies.push_back(ply);
}

// Plies follow from field 9 on, MID, T, THETA and SOUT, two on a line. A group of blank fields is no ply.
void read_pcomp(const Card& card, const Reading& in) {
  PcompCard laminate = laminate_head(card);
  for (std::size_t i = 9; i <= card.size(); i += 4)
    if (!card.blank(i) || !card.blank(i + 1) || !card.blank(i + 2) || !card.blank(i + 3)) add_ply(card, i, laminate);
  finish_laminate(card, in, std::move(laminate));
}

// PCOMPG has one ply on a line, with its global number in front.
void read_pcompg(const Card& card, const Reading& in) {
  PcompCard laminate = laminate_head(card);
  for (std::size_t i = 9; i <= card.size(); i += 8)
    if (!card.blank(i) || !card.blank(i + 1) || !card.blank(i + 2) || !card.blank(i + 3))
      add_ply(card, i + 1, laminate);
  finish_laminate(card, in, std::move(laminate));
}

void read_psolid(const Card& card, const Reading& in) {
  if (card.says(7, "PFLUID"))
    throw CardError(title(card) + " is a fluid", "fluids are not supported", "remove the fluid from the deck");
  if (!card.blank(7)) {
    if (!card.says(7, "SMECH"))
      throw CardError(title(card) + ": FCTN is '" + card.text(7) + "'", "solids of structures are read", "write SMECH");
  }
  for (const auto& [field, what] : {std::pair{4u, "IN of PSOLID"}, {6u, "ISOP of PSOLID"}})
    if (!card.blank(field))
      in.tell(card, field, what, "kalfem integrates its solids by rules of its own, which do not lock",
              DeckNoteKind::doubtful);
  add_property(card, in, PsolidCard{card.id(2, "MID"), card.id_or(3, 0, "CORDM")});
}

void read_prod(const Card& card, const Reading& in) {
  add_property(
      card, in,
      RodSection{card.id(2, "MID"), card.real_or(3, 0.0, "A"), card.real_or(4, 0.0, "J"), card.real_or(6, 0.0, "NSM")});
}

// Area pi/4 (do^2 - di^2) and torsion constant pi/32 (do^4 - di^4). A wall of 0 stands for a solid rod.
void read_ptube(const Card& card, const Reading& in) {
  const double first = card.real(3, "OD"), last = card.real_or(6, first, "OD2"), wall = card.real_or(4, 0.0, "T");
  std::vector<Change> changes;
  if (first != last) changes.push_back({"taper of PTUBE", "the rod takes the mean of both diameters"});
  const double outer = (first + last) / 2.0, inner = wall == 0.0 ? 0.0 : outer - 2.0 * wall;
  if (!(outer > 0.0) || inner < 0.0)
    throw CardError(title(card) + ": its diameter and wall do not form a tube", "", "correct OD and T");
  const auto power = [](double base, int exponent) { return std::pow(base, exponent); };
  add_property(card, in,
               RodSection{card.id(2, "MID"), std::numbers::pi / 4.0 * (power(outer, 2) - power(inner, 2)),
                          std::numbers::pi / 32.0 * (power(outer, 4) - power(inner, 4)), card.real_or(5, 0.0, "NSM")},
               std::move(changes));
}

/// Groups of eight: "K" and six stiffnesses, "B" and six dampings, "M" and a mass; those of damping, stress recovery
/// and thermal expansion have no effect here.
void read_pbush(const Card& card, const Reading& in) {
  BushProperty bush;
  std::vector<Change> changes;
  for (std::size_t flag = 2; flag <= card.size(); flag += 8) {
    const bool is_stiffness = card.says(flag, "K"), is_damping = card.says(flag, "B");
    for (std::size_t i = 0; i < 6; ++i) {
      if (is_stiffness) bush.stiffness[i] = card.real_or(flag + 1 + i, 0.0, "K");
      if (is_damping) bush.damping[i] = card.real_or(flag + 1 + i, 0.0, "B");
    }
    if (card.says(flag, "M"))
      bush.mass = card.real_or(flag + 1, 0.0, "M");
    else if (card.says(flag, "GE"))
      for (std::size_t i = 0; i < 6; ++i) add_structural_damping(card, flag + 1 + i, changes);
    else if (card.says(flag, "RCV") || card.says(flag, "T") || card.says(flag, "D"))
      for (std::size_t i = 0; i <= 6; ++i)
        if (!card.blank(flag + i))
          in.tell(card, flag + i, "RCV, T and D of PBUSH", "they concern stresses and thermal expansion",
                  DeckNoteKind::unused);
    const bool is_known = is_stiffness || is_damping || card.use(flag) != FieldUse::untouched;
    if (!is_known && !card.blank(flag))
      throw CardError(title(card) + ": a line begins with '" + std::string(card.raw(flag)) + "'",
                      "K, B, GE, M and RCV are known", "correct the field");
  }
  if (changes.size() > 1) changes.resize(1);
  add_property(card, in, bush, std::move(changes));
}

void read_pbush1d(const Card& card, const Reading& in) {
  BushProperty bush;
  bush.stiffness[0] = card.real_or(2, 0.0, "K");
  bush.damping[0] = card.real_or(3, 0.0, "C");
  bush.mass = card.real_or(4, 0.0, "M");
  for (std::size_t i = 9; i <= card.size(); ++i)
    if (!card.blank(i))
      in.tell(card, i, "SHOCKA, SPRING, DAMPER and GENER of PBUSH1D", "the bushing is linear with K, C and M",
              DeckNoteKind::doubtful);
  add_property(card, in, bush);
}

// PVISC, PELAS, PDAMP and PMASS hold several properties on one card, each behind its own number.
void read_pvisc(const Card& card, const Reading& in) {
  for (const std::size_t first : {1, 5}) {
    if (card.blank(first)) continue;
    BushProperty bush;
    bush.damping[0] = card.real_or(first + 1, 0.0, "CE");
    bush.damping[3] = card.real_or(first + 2, 0.0, "CR");
    add_property(in.bulk, card.id(first, "PID"), {card.name, bush, card.place});
  }
}

void add_value(std::map<Id, double>& values, const Card& card, std::size_t id, const char* what) {
  if (!values.try_emplace(card.id(id, "PID"), card.real_or(id + 1, 0.0, what)).second)
    throw CardError(card.name + " " + std::string(card.raw(id)) + " is defined twice", "", "remove one of the cards");
}

void read_pelas(const Card& card, const Reading& in) {
  for (const std::size_t first : {1, 5})
    if (!card.blank(first)) {
      add_value(in.bulk.spring_stiffness, card, first, "K");
      tell_structural_damping(card, in, first + 2);
    }
}
void read_pdamp(const Card& card, const Reading& in) {
  for (const std::size_t first : {1, 3, 5, 7})
    if (!card.blank(first)) add_value(in.bulk.dashpot_damping, card, first, "B");
}
void read_pmass(const Card& card, const Reading& in) {
  for (const std::size_t first : {1, 3, 5, 7})
    if (!card.blank(first)) add_value(in.bulk.scalar_mass, card, first, "M");
}

constexpr auto property_readers = std::to_array<CardReader>({{"PSHELL", read_pshell},
                                                             {"PSHEAR", read_pshear},
                                                             {"PCOMP", read_pcomp},
                                                             {"PCOMPG", read_pcompg},
                                                             {"PSOLID", read_psolid},
                                                             {"PROD", read_prod},
                                                             {"PTUBE", read_ptube},
                                                             {"PBUSH", read_pbush},
                                                             {"PBUSH1D", read_pbush1d},
                                                             {"PVISC", read_pvisc},
                                                             {"PELAS", read_pelas},
                                                             {"PDAMP", read_pdamp},
                                                             {"PMASS", read_pmass}});

}  // namespace

std::span<const CardReader> property_cards() { return property_readers; }

}  // namespace kalfem::nastran
