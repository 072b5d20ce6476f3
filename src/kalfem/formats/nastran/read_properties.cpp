#include <array>
#include <numbers>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {
namespace {

template <typename Law>
void add_material(const Card& card, const Reading& in, const Law& law) {
  if (!in.bulk.materials.try_emplace(card.id(1, "MID"), MaterialCard{law, card.place}).second)
    throw CardError("material " + std::to_string(card.id(1, "MID")) + " is defined twice", "",
                    "remove one of the cards");
}

void note_damping(const Card& card, const Reading& in, std::size_t field) {
  if (card.real_or(field, 0.0, "GE") != 0.0)
    in.note(card, "structural damping (GE)", "it is ignored; give modal damping instead");
}

void read_mat1(const Card& card, const Reading& in) {
  Material1 law;
  law.youngs_modulus = card.real_or(2, not_given, "E");
  law.shear_modulus = card.real_or(3, not_given, "G");
  law.poissons_ratio = card.real_or(4, not_given, "NU");
  law.density = card.real_or(5, 0.0, "RHO");
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
  note_damping(card, in, 31);
  add_material(card, in, law);
}

constexpr auto material_readers =
    std::to_array<CardReader>({{"MAT1", read_mat1}, {"MAT2", read_mat2}, {"MAT8", read_mat8}, {"MAT9", read_mat9}});

}  // namespace

std::span<const CardReader> material_cards() { return material_readers; }

namespace {

void add_property(const Card& card, const Reading& in, PropertyLaw law) {
  const Id id = card.id(1, "PID");
  if (!in.bulk.properties.try_emplace(id, PropertyCard{card.name, std::move(law), card.place}).second)
    throw CardError("property " + std::to_string(id) + " is defined twice", "", "remove one of the cards");
}

// MID1 is the membrane, MID2 bending, MID3 transverse shear. Bending is scaled by 12 I / T^3 (1 for a homogeneous
// plate), shear by TS/T (5/6).
void read_pshell(const Card& card, const Reading& in) {
  PshellCard shell;
  shell.membrane = card.id_or(2, 0, "MID1");
  shell.thickness = card.real_or(3, not_given, "T");
  const Id bending = card.id_or(4, 0, "MID2");
  shell.bending = bending == -1 ? shell.membrane : bending;
  if (bending == -1) in.note(card, "plane strain (MID2 = -1 of PSHELL)", "the shell is read as plane stress");
  shell.bending_ratio = card.real_or(5, 1.0, "12I/T**3");
  shell.shear = card.id_or(6, 0, "MID3");
  shell.shear_ratio = card.real_or(7, 5.0 / 6.0, "TS/T");
  shell.nonstructural_mass = card.real_or(8, 0.0, "NSM");
  shell.coupling = card.id_or(11, 0, "MID4");
  if (shell.coupling > 0)
    in.note(card, "coupling of stretching and bending (MID4 of PSHELL)",
            "it is ignored; give an eccentric layup as PCOMP");
  add_property(card, in, shell);
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
  if (laminate.layout == "SYM" || laminate.layout == "SYMEM") {
    const auto half = laminate.plies;
    laminate.plies.insert(laminate.plies.end(), half.rbegin(), half.rend());
  }
  if (!laminate.layout.empty() && laminate.layout != "SYM")
    in.note(card, "LAM " + laminate.layout + " of " + card.name,
            "this option is ignored: the laminate keeps its full stiffness");
  add_property(card, in, std::move(laminate));
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
    if (!card.blank(i)) add_ply(card, i + 1, laminate);
  finish_laminate(card, in, std::move(laminate));
}

void read_psolid(const Card& card, const Reading& in) {
  if (card.text(7) == "PFLUID")
    throw CardError(title(card) + " is a fluid", "fluids are not supported", "remove the fluid from the deck");
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
  if (first != last) in.note(card, "taper of PTUBE", "the rod takes the mean of both diameters");
  const double outer = (first + last) / 2.0, inner = wall == 0.0 ? 0.0 : outer - 2.0 * wall;
  if (!(outer > 0.0) || inner < 0.0)
    throw CardError(title(card) + ": its diameter and wall do not form a tube", "", "correct OD and T");
  const auto power = [](double base, int exponent) { return std::pow(base, exponent); };
  add_property(card, in,
               RodSection{card.id(2, "MID"), std::numbers::pi / 4.0 * (power(outer, 2) - power(inner, 2)),
                          std::numbers::pi / 32.0 * (power(outer, 4) - power(inner, 4)), card.real_or(5, 0.0, "NSM")});
}

/// Groups of eight: "K" and six stiffnesses, "B" and six dampings, "M" and a mass; others have no effect here.
void read_pbush(const Card& card, const Reading& in) {
  BushProperty bush;
  for (std::size_t flag = 2; flag <= card.size(); flag += 8) {
    const auto word = card.text(flag);
    for (std::size_t i = 0; i < 6; ++i) {
      if (word == "K") bush.stiffness[i] = card.real_or(flag + 1 + i, 0.0, "K");
      if (word == "B") bush.damping[i] = card.real_or(flag + 1 + i, 0.0, "B");
    }
    if (word == "M") bush.mass = card.real_or(flag + 1, 0.0, "M");
    if (word == "GE") in.note(card, "structural damping (GE)", "it is ignored; give modal damping instead");
  }
  add_property(card, in, bush);
}

void read_pbush1d(const Card& card, const Reading& in) {
  BushProperty bush;
  bush.stiffness[0] = card.real_or(2, 0.0, "K");
  bush.damping[0] = card.real_or(3, 0.0, "C");
  bush.mass = card.real_or(4, 0.0, "M");
  add_property(card, in, bush);
}

// PVISC, PELAS, PDAMP and PMASS hold several properties on one card, each behind its own number.
void read_pvisc(const Card& card, const Reading& in) {
  for (const std::size_t first : {1, 5}) {
    if (card.blank(first)) continue;
    BushProperty bush;
    bush.damping[0] = card.real_or(first + 1, 0.0, "CE");
    bush.damping[3] = card.real_or(first + 2, 0.0, "CR");
    if (!in.bulk.properties.try_emplace(card.id(first, "PID"), PropertyCard{card.name, bush, card.place}).second)
      throw CardError(card.name + " " + std::string(card.raw(first)) + " is defined twice", "",
                      "remove one of the cards");
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
      if (card.real_or(first + 2, 0.0, "GE") != 0.0)
        in.note(card, "structural damping (GE)", "it is ignored; give modal damping instead");
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

namespace {

void add_section(const Card& card, const Reading& in, SectionCard section) {
  const Id id = card.id(1, "PID");
  section.material = card.id(2, "MID");
  if (!in.bulk.properties.try_emplace(id, PropertyCard{card.name, section, card.place}).second)
    throw CardError("property " + std::to_string(id) + " is defined twice", "", "remove one of the cards");
}

void read_pbar(const Card& card, const Reading& in) {
  SectionCard section;
  section.area = card.real_or(3, 0.0, "A");
  section.i1 = card.real_or(4, 0.0, "I1");
  section.i2 = card.real_or(5, 0.0, "I2");
  section.torsion = card.real_or(6, 0.0, "J");
  section.nonstructural_mass = card.real_or(7, 0.0, "NSM");
  section.k1 = card.real_or(17, 0.0, "K1");
  section.k2 = card.real_or(18, 0.0, "K2");
  section.i12 = card.real_or(19, 0.0, "I12");
  add_section(card, in, section);
}

/// A, I1, I2, I12, J and NSM of one station.
using Station = std::array<double, 6>;

// A blank value of a station is that of end A.
Station station_at(const Card& card, std::size_t first, const Station& otherwise) {
  Station station;
  for (std::size_t i = 0; i < station.size(); ++i)
    station[i] = card.real_or(first + i, otherwise[i], "a value of the section");
  return station;
}

bool is_station(const Card& card, std::size_t i) {
  const auto word = card.text(i);
  return word == "YES" || word == "YESA" || word == "NO";
}

SectionCard section_between(const Station& a, const Station& b) {
  const auto mean = [&](std::size_t i) { return 0.5 * (a[i] + b[i]); };
  SectionCard section;
  section.area = mean(0), section.i1 = mean(1), section.i2 = mean(2), section.i12 = mean(3);
  section.torsion = mean(4), section.nonstructural_mass = mean(5);
  return section;
}

void note_taper(const Card& card, const Reading& in) {
  in.note(card, "taper of " + card.name, "beams take the mean of the sections at both ends");
}

/// Mean of the values at ends A and B; B is as A where it is blank.
Eigen::Vector2d mean_point(const Card& card, std::size_t first, const char* what) {
  const Eigen::Vector2d a(card.real_or(first, 0.0, what), card.real_or(first + 1, 0.0, what));
  const Eigen::Vector2d b(card.real_or(first + 2, a[0], what), card.real_or(first + 3, a[1], what));
  return 0.5 * (a + b);
}

// Walks the lines by their flags: a station with YES is followed by a line of stress points, with YESA or NO it is
// not. Of the stations only that at X/XB = 1 counts, end B: kalfem's beams are prismatic with the mean section.
/// Lines: end A; its points of stress; stations (with points of stress behind YES); factors; centres.
void read_pbeam(const Card& card, const Reading& in) {
  const Station a = station_at(card, 3, {});
  Station b = a;
  std::size_t line = is_station(card, 9) ? 9 : 17;
  for (; is_station(card, line); line += card.text(line) == "YES" ? 16 : 8)
    if (card.real_or(line + 1, 1.0, "X/XB") == 1.0) b = station_at(card, line + 2, a);
  if (a != b) note_taper(card, in);
  SectionCard section = section_between(a, b);
  section.k1 = card.real_or(line, 1.0, "K1");
  section.k2 = card.real_or(line + 1, 1.0, "K2");
  for (const std::size_t i : {4, 5})
    if (card.real_or(line + i, 0.0, "NSI") != 0.0)
      in.note(card, "moment of inertia of nonstructural mass (NSI of PBEAM)", "this rotary inertia is missing");
  for (const std::size_t i : {6, 7})
    if (card.real_or(line + i, 0.0, "CW") != 0.0)
      in.note(card, "warping (CW of PBEAM)",
              "torsion follows St Venant; the stiffness of restrained warping is ignored");
  section.nonstructural_centre = mean_point(card, line + 8, "M1, M2");
  section.neutral_axis = mean_point(card, line + 12, "N1, N2");
  add_section(card, in, section);
}

std::vector<double> dimensions_at(const Card& card, std::size_t first, std::size_t count) {
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(card.real(first + i, "DIM"));
  return values;
}

std::size_t known_shape(const Card& card) {
  const std::size_t count = dimension_count(card.text(4));
  if (count == 0)
    throw CardError(title(card) + ": the section TYPE '" + card.text(4) + "' is not known",
                    "its area and moments of inertia cannot be computed", "give them on a PBAR or PBEAM card");
  return count;
}

void read_pbarl(const Card& card, const Reading& in) {
  const std::size_t count = known_shape(card);
  SectionCard section = section_of_shape(card.text(4), dimensions_at(card, 9, count), title(card));
  section.nonstructural_mass = card.real_or(9 + count, 0.0, "NSM");
  section.neutral_axis.setZero();  // PBARL has none
  add_section(card, in, section);
}

// DIM and NSM of end A stand without a flag and a place in front. Only the station at X/XB = 1 counts besides.
/// DIM(A) NSM(A), then SO X DIM NSM of each further station.
void read_pbeaml(const Card& card, const Reading& in) {
  const std::size_t count = known_shape(card);
  const auto shape = card.text(4);
  const auto first = dimensions_at(card, 9, count);
  const double first_mass = card.real_or(9 + count, 0.0, "NSM");
  SectionCard section = section_of_shape(shape, first, title(card));
  section.nonstructural_mass = first_mass;
  for (std::size_t at = 10 + count; at <= card.size(); at += count + 3) {
    if (card.real_or(at + 1, 1.0, "X/XB") != 1.0) continue;
    auto last = first;
    for (std::size_t i = 0; i < count; ++i) last[i] = card.real_or(at + 2 + i, first[i], "DIM");
    const double last_mass = card.real_or(at + 2 + count, first_mass, "NSM");
    if (last == first && last_mass == first_mass) continue;
    note_taper(card, in);
    const SectionCard other = section_of_shape(shape, last, title(card));
    const Station a{section.area, section.i1, section.i2, section.i12, section.torsion, first_mass};
    SectionCard mean = section_between(a, {other.area, other.i1, other.i2, other.i12, other.torsion, last_mass});
    mean.k1 = 0.5 * (section.k1 + other.k1), mean.k2 = 0.5 * (section.k2 + other.k2);
    mean.neutral_axis = 0.5 * (section.neutral_axis + other.neutral_axis);
    section = mean;
  }
  // Nonstructural mass lies along the neutral axis.
  section.nonstructural_centre = section.neutral_axis;
  add_section(card, in, section);
}

constexpr auto section_readers = std::to_array<CardReader>(
    {{"PBAR", read_pbar}, {"PBEAM", read_pbeam}, {"PBARL", read_pbarl}, {"PBEAML", read_pbeaml}});

}  // namespace

std::span<const CardReader> section_cards() { return section_readers; }

}  // namespace kalfem::nastran
