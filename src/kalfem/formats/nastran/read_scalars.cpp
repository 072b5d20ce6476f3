// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {
namespace {

using Kind = ScalarCard::Kind;

void add_scalar(const Card& card, const Reading& in, ScalarCard scalar) {
  if (scalar.nodes[0] == 0 && scalar.nodes[1] == 0)
    throw CardError(title(card) + " connects no nodes", "only one of its ends may be the ground", "name a node");
  scalar.where = card.place;
  in.bulk.add_element(scalar.kind == Kind::mass ? ElementKind::mass : ElementKind::structural, scalar.id, card.place);
  in.bulk.scalars.push_back(scalar);
}

/// CELAS1 and kin: EID PID G1 C1 G2 C2.
template <Kind kind>
void read_with_property(const Card& card, const Reading& in) {
  ScalarCard scalar{.kind = kind, .id = card.id(1, "EID")};
  scalar.property = card.id_or(2, scalar.id, "PID");
  scalar.nodes = {card.id_or(3, 0, "G1"), card.id_or(5, 0, "G2")};
  scalar.components = {card.component(4, "C1"), card.component(6, "C2")};
  add_scalar(card, in, scalar);
}

/// CELAS2 and kin: EID value G1 C1 G2 C2.
template <Kind kind>
void read_with_value(const Card& card, const Reading& in) {
  ScalarCard scalar{.kind = kind, .id = card.id(1, "EID")};
  scalar.value = card.real_or(2, 0.0, "the value");
  scalar.nodes = {card.id_or(3, 0, "G1"), card.id_or(5, 0, "G2")};
  scalar.components = {card.component(4, "C1"), card.component(6, "C2")};
  if constexpr (kind == Kind::spring) tell_structural_damping(card, in, 7);
  add_scalar(card, in, scalar);
}

/// CELAS3 and kin: EID PID S1 S2.
template <Kind kind>
void read_points_with_property(const Card& card, const Reading& in) {
  ScalarCard scalar{.kind = kind, .id = card.id(1, "EID")};
  scalar.property = card.id_or(2, scalar.id, "PID");
  scalar.nodes = {card.id_or(3, 0, "S1"), card.id_or(4, 0, "S2")};
  add_scalar(card, in, scalar);
}

/// CELAS4 and kin: EID value S1 S2.
template <Kind kind>
void read_points_with_value(const Card& card, const Reading& in) {
  ScalarCard scalar{.kind = kind, .id = card.id(1, "EID")};
  scalar.value = card.real_or(2, 0.0, "the value");
  scalar.nodes = {card.id_or(3, 0, "S1"), card.id_or(4, 0, "S2")};
  add_scalar(card, in, scalar);
}

void add_bush(const Card& card, const Reading& in, BushCard bush) {
  bush.where = card.place;
  in.bulk.add_element(ElementKind::structural, bush.id, card.place);
  in.bulk.bushes.push_back(bush);
}

// An orientation is a grid point G0 or a vector X1, X2, X3; an integer alone in the first field is a grid point. CID
// takes precedence over both when the axes are built.
void read_bush(const Card& card, const Reading& in) {
  BushCard bush;
  bush.id = card.id(1, "EID");
  bush.property = card.id_or(2, bush.id, "PID");
  bush.nodes = {card.id(3, "GA"), card.id_or(4, 0, "GB")};
  if (card.is_integer(5) && card.blank(6) && card.blank(7))
    bush.orientation_node = card.id(5, "G0");
  else if (!card.blank(5) || !card.blank(6) || !card.blank(7))
    bush.orientation =
        Eigen::Vector3d(card.real_or(5, 0.0, "X1"), card.real_or(6, 0.0, "X2"), card.real_or(7, 0.0, "X3"));
  bush.axes = card.id_or(8, -1, "CID");
  bush.location = card.real_or(9, 0.5, "S");
  bush.offset_system = card.id_or(10, -1, "OCID");
  for (std::size_t i = 0; i < 3; ++i) bush.offset[static_cast<Eigen::Index>(i)] = card.real_or(11 + i, 0.0, "S1 to S3");
  const auto without_effect = [&](std::size_t i, const char* names, const char* why) {
    if (!card.blank(i)) in.tell(card, i, names, why, DeckNoteKind::unused);
  };
  for (const std::size_t i : {5, 6, 7})
    if (bush.axes >= 0) without_effect(i, "orientation of a CBUSH with CID", "CID takes its place");
  if (bush.offset_system >= 0) without_effect(9, "S of a CBUSH with OCID", "S1, S2, S3 take its place");
  for (const std::size_t i : {11, 12, 13})
    if (bush.offset_system < 0) without_effect(i, "S1, S2, S3 of a CBUSH without OCID", "S gives its point");
  add_bush(card, in, bush);
}

/// Elements that act along the line of their nodes, or along x of a system.
void read_axial(const Card& card, const Reading& in, const char* kind, std::size_t axes) {
  BushCard bush;
  bush.id = card.id(1, "EID");
  bush.kind = kind;
  bush.property = card.id_or(2, bush.id, "PID");
  bush.nodes = {card.id(3, "GA"), card.id_or(4, 0, "GB")};
  if (axes > 0) bush.axes = card.id_or(axes, -1, "CID");
  add_bush(card, in, bush);
}
void read_bush1d(const Card& card, const Reading& in) { read_axial(card, in, "CBUSH1D", 5); }
void read_visc(const Card& card, const Reading& in) { read_axial(card, in, "CVISC", 0); }

// CONM1 gives the lower triangle of a 6 x 6 mass matrix row by row.
void read_conm1(const Card& card, const Reading& in) {
  Conm1Card mass;
  mass.id = card.id(1, "EID");
  mass.node = card.id(2, "G");
  mass.system = card.id_or(3, 0, "CID");
  std::size_t field = 4;
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column <= row; ++column, ++field)
      mass.matrix(row, column) = mass.matrix(column, row) = card.real_or(field, 0.0, "M");
  mass.where = card.place;
  in.bulk.add_element(ElementKind::mass, mass.id, card.place);
  in.bulk.mass_matrices.push_back(mass);
}

/// The card's I21, I31 and I32 are integrals of products; they enter the inertia tensor with a minus.
void read_conm2(const Card& card, const Reading& in) {
  Conm2Card mass;
  mass.id = card.id(1, "EID");
  mass.node = card.id(2, "G");
  mass.system = card.id_or(3, 0, "CID");
  mass.mass = card.real_or(4, 0.0, "M");
  for (std::size_t i = 0; i < 3; ++i) mass.offset[static_cast<Eigen::Index>(i)] = card.real_or(5 + i, 0.0, "X");
  std::size_t field = 9;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column <= row; ++column, ++field)
      mass.inertia(row, column) = mass.inertia(column, row) =
          (row == column ? 1.0 : -1.0) * card.real_or(field, 0.0, "I");
  mass.where = card.place;
  in.bulk.add_element(ElementKind::mass, mass.id, card.place);
  in.bulk.masses.push_back(mass);
}

constexpr auto scalar_readers = std::to_array<CardReader>({{"CELAS1", read_with_property<Kind::spring>},
                                                           {"CELAS2", read_with_value<Kind::spring>},
                                                           {"CELAS3", read_points_with_property<Kind::spring>},
                                                           {"CELAS4", read_points_with_value<Kind::spring>},
                                                           {"CDAMP1", read_with_property<Kind::dashpot>},
                                                           {"CDAMP2", read_with_value<Kind::dashpot>},
                                                           {"CDAMP3", read_points_with_property<Kind::dashpot>},
                                                           {"CDAMP4", read_points_with_value<Kind::dashpot>},
                                                           {"CMASS1", read_with_property<Kind::mass>},
                                                           {"CMASS2", read_with_value<Kind::mass>},
                                                           {"CMASS3", read_points_with_property<Kind::mass>},
                                                           {"CMASS4", read_points_with_value<Kind::mass>},
                                                           {"CBUSH", read_bush},
                                                           {"CBUSH1D", read_bush1d},
                                                           {"CVISC", read_visc},
                                                           {"CONM1", read_conm1},
                                                           {"CONM2", read_conm2}});

}  // namespace

std::span<const CardReader> scalar_cards() { return scalar_readers; }

namespace {

/// Header: DMIG NAME 0 IFO TIN TOUT; column: DMIG NAME GJ CJ - then G C A B of each entry.
void read_dmig(const Card& card, const Reading& in) {
  DmigMatrix& matrix = in.bulk.matrices[card.text(1)];
  const bool is_header = card.integer_or(2, 0, "GJ") == 0;
  if (matrix.where.line == 0 || is_header) matrix.where = card.place;
  if (is_header) {
    if (matrix.form)
      throw CardError("DMIG " + card.text(1) + " has two headers", "it is not clear which one applies",
                      "remove one of them");
    matrix.form = static_cast<int>(card.integer_or(3, 6, "IFO"));
    matrix.complex = card.integer_or(4, 1, "TIN") > 2;
    return;
  }
  DmigEntry entry;
  entry.column = card.id(2, "GJ");
  entry.column_direction = static_cast<std::int8_t>(card.component(3, "CJ"));
  entry.where = card.place;
  for (std::size_t i = 5; i <= card.size(); i += 4) {
    if (card.blank(i) && card.blank(i + 1) && card.blank(i + 2) && card.blank(i + 3)) continue;
    if (card.real_or(i + 3, 0.0, "B") != 0.0)
      throw CardError("DMIG " + card.text(1) + ": an entry has an imaginary part",
                      "stiffness, mass and damping must be real", "write its real part alone");
    entry.row = card.id(i, "G");
    entry.row_direction = static_cast<std::int8_t>(card.component(i + 1, "C"));
    entry.value = card.real(i + 2, "A");
    matrix.entries.push_back(entry);
  }
}

void tell_damping(const Card& card, const Reading& in, const std::string& name, const char* consequence) {
  const bool is_zero = card.is_number(2) && card.real(2, "damping") == 0.0;
  in.tell(card, 2, "PARAM " + name, is_zero ? "it is 0" : consequence,
          is_zero ? DeckNoteKind::unused : DeckNoteKind::changed);
}

// PARAMs that change stiffness, mass or constraints are read: WTMASS, COUPMASS, AUTOSPC, K6ROT, CK2, CM2 and CB2.
void read_param(const Card& card, const Reading& in) {
  const auto name = card.text(1);
  if (name == "WTMASS") {
    in.bulk.mass_factor = card.real(2, "WTMASS");
    if (!(in.bulk.mass_factor > 0.0))
      throw CardError("PARAM WTMASS is " + std::string(card.raw(2)), "this factor multiplies all mass",
                      "give a positive factor");
  } else if (name == "COUPMASS") {
    const bool is_word = card.says(2, "YES") || card.says(2, "NO");
    in.bulk.coupled_mass = is_word ? card.text(2) == "YES" : card.real(2, "COUPMASS") > 0.0;
  } else if (name == "AUTOSPC") {
    constexpr std::array<std::string_view, 5> words = {"YES", "NO", "PRINT", "NOPRINT", "PUNCH"};
    if (std::ranges::find(words, card.text(2)) == words.end())
      throw CardError("PARAM AUTOSPC is '" + std::string(card.raw(2)) + "'",
                      "it says whether motions without stiffness are held", "write YES or NO");
    in.bulk.autospc = card.text(2) != "NO";
  } else if (name == "G" || name == "W3" || name == "W4" || name == "GFL") {
    tell_damping(card, in, name, "structural damping is ignored; give modal damping instead");
  } else if (name == "K6ROT") {
    in.bulk.drilling = std::max(0.0, card.real_or(2, 100.0, "K6ROT"));
  } else if (name == "CK2" || name == "CM2" || name == "CB2") {
    in.bulk.direct_factors[name == "CK2" ? 0 : name == "CM2" ? 1 : 2] = card.real(2, "the factor");
  } else if (name == "CK1" || name == "CM1" || name == "CB1") {
    if (card.real(2, "the factor") != 1.0)
      throw CardError("PARAM " + name + " is " + std::string(card.raw(2)),
                      "it scales the matrices of all elements, which kalfem does not",
                      "change the materials, or write 1.0");
  } else if (name == "ALPHA1" || name == "ALPHA2") {
    tell_damping(card, in, name, "this damping is ignored; give modal damping instead");
  } else {
    for (std::size_t i = 2; i <= card.size(); ++i)
      if (!card.blank(i))
        in.tell(card, i, "PARAM " + name, "kalfem does not follow it; mostly it concerns output or the solution",
                DeckNoteKind::unused);
  }
}

constexpr auto matrix_readers = std::to_array<CardReader>({{"DMIG", read_dmig}, {"PARAM", read_param}});

}  // namespace

std::span<const CardReader> matrix_cards() { return matrix_readers; }

}  // namespace kalfem::nastran
