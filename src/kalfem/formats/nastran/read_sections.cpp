// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"
#include "kalfem/formats/nastran/stations.hpp"

namespace kalfem::nastran {
namespace {

void add_section(const Card& card, const Reading& in, SectionCard section, std::vector<Change> changes = {}) {
  section.material = card.id(2, "MID");
  add_property(in.bulk, card.id(1, "PID"), {card.name, std::move(section), card.place, std::move(changes)});
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

/// What a PBEAM has at a station: A, I1, I2, I12, J and NSM.
constexpr std::array section_values = {&SectionCard::area, &SectionCard::i1,      &SectionCard::i2,
                                       &SectionCard::i12,  &SectionCard::torsion, &SectionCard::nonstructural_mass};

bool has_flag(const Card& card, std::size_t line) {
  return card.says(line, "YES") || card.says(line, "YESA") || card.says(line, "NO");
}

/// Points of stress, four pairs.
void tell_points(const Card& card, const Reading& in, std::size_t line) {
  for (std::size_t i = line; i < line + 8; ++i)
    if (!card.blank(i)) {
      static_cast<void>(card.real_or(i, 0.0, "a point of stress"));
      in.tell(card, i, "C1 to F2 of PBEAM", "where stresses are asked for has no effect on stiffness and mass",
              DeckNoteKind::unused);
    }
}

// With a blank in front, a line may be a station whose flag is left out, or the line of K1, which is left out. X/XB
// is 1 at most, and neither points of stress about the centroid nor relief coefficients are all positive.
/// Whether a line that begins with a blank is a station; throws CardError where it cannot be told.
bool lacks_flag(const Card& card, std::size_t line) {
  const auto value = [&](std::size_t i) { return parse_real(card.raw(line + i)).value_or(0.0); };
  if (!card.blank(line) || !(value(1) > 0.0) || value(1) > 1.0) return false;
  bool negative = false;
  for (std::size_t i = 2; i < 8; ++i) negative = negative || value(i) < 0.0;
  if (value(2) > 0.0 && (value(3) > 0.0 || value(4) > 0.0) && !negative) return true;
  if (line > 9 && (value(2) != 0.0 || value(3) != 0.0))
    throw CardError(title(card) + ": line " + std::to_string(line / 8 + 1) + " begins with a blank field",
                    "it may be a station without its flag, or the line of K1 and K2 without K1",
                    "write NO in front of X/XB, or a value for K1");
  return false;
}

/// Stations of a PBEAM from line `line` on, which is set to the one behind them.
std::vector<StationFields> read_stations(const Card& card, const Reading& in, std::size_t& line) {
  std::vector<StationFields> stations;
  line = 9;
  if (!has_flag(card, line) && !lacks_flag(card, line)) {
    tell_points(card, in, line);
    line += 8;
  }
  for (bool unflagged = false; has_flag(card, line) || (unflagged = lacks_flag(card, line)); unflagged = false) {
    if (unflagged)
      in.note(card, "stations of PBEAM without a flag (SO)", "a line that begins with a blank and X/XB is a station",
              DeckNoteKind::doubtful);
    StationFields station{.place = card.real(line + 1, "X/XB"), .values = {}};
    for (std::size_t i = 0; i < section_values.size(); ++i)
      if (!card.blank(line + 2 + i)) station.values[i] = card.real(line + 2 + i, "a value of the section");
    const bool has_points = card.says(line, "YES");
    line += 8;
    if (has_points && !has_flag(card, line)) {
      tell_points(card, in, line);
      line += 8;
    }
    stations.push_back(std::move(station));
  }
  return stations;
}

/// Values that the ends A and B have; B is as A where it is blank.
std::array<double, 2> at_ends(const Card& card, std::size_t a, std::size_t b, const char* what) {
  const double first = card.real_or(a, 0.0, what);
  return {first, card.real_or(b, first, what)};
}

// The section, shear factors, neutral axis and nonstructural mass along the beam are linear between the stations; those
// that only the ends have, linear from end to end.
/// Lines: end A; its points of stress; stations (with points of stress behind YES); factors; centres.
void read_pbeam(const Card& card, const Reading& in) {
  std::vector<double> first(section_values.size());
  for (std::size_t i = 0; i < first.size(); ++i) first[i] = card.real_or(3 + i, 0.0, "a value of the section");
  std::size_t line = 9;
  const auto stations = read_stations(card, in, line);
  for (std::size_t i = line + 16; i <= card.size(); ++i)
    if (!card.blank(i))
      throw CardError(title(card) + ": " + place_on_card(i) + " stands behind the lines of K1 and M1",
                      "stations begin with YES, YESA or NO, and two lines follow them", "correct the card");
  const double k1 = card.real_or(line, 1.0, "K1"), k2 = card.real_or(line + 1, 1.0, "K2");
  std::vector<Change> changes;
  for (const std::size_t i : {2, 3})
    if (card.real_or(line + i, 0.0, "S") != 0.0)
      changes.push_back({"shear relief by taper (S1, S2 of PBEAM)", "shear follows from K1, K2 and the area alone"});
  for (const std::size_t i : {6, 7})
    if (card.real_or(line + i, 0.0, "CW") != 0.0)
      changes.push_back(
          {"warping (CW of PBEAM)", "torsion follows St Venant; the stiffness of restrained warping is ignored"});
  for (const std::size_t i : {2, 3, 6, 7}) card.mark(line + i, FieldUse::told);
  if (changes.size() == 2 && changes[0].what == changes[1].what) changes.pop_back();
  const auto inertia = at_ends(card, line + 4, line + 5, "NSI");
  const auto m1 = at_ends(card, line + 8, line + 10, "M1"), m2 = at_ends(card, line + 9, line + 11, "M2");
  const auto n1 = at_ends(card, line + 12, line + 14, "N1"), n2 = at_ends(card, line + 13, line + 15, "N2");
  std::vector<std::pair<double, SectionCard>> sections;
  for (const auto& [place, values] : filled_stations(first, stations, title(card))) {
    const auto here = [share = place](const std::array<double, 2>& ends) {
      return (1.0 - share) * ends[0] + share * ends[1];
    };
    SectionCard section{.k1 = k1, .k2 = k2};
    for (std::size_t i = 0; i < values.size(); ++i) section.*section_values[i] = values[i];
    section.nonstructural_inertia = here(inertia);
    section.nonstructural_centre = {here(m1), here(m2)};
    section.neutral_axis = {here(n1), here(n2)};
    sections.emplace_back(place, std::move(section));
  }
  add_section(card, in, along(std::move(sections)), std::move(changes));
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

// DIM and NSM of end A stand without a flag and a place in front.
/// DIM(A) NSM(A), then SO X DIM NSM of each further station.
void read_pbeaml(const Card& card, const Reading& in) {
  const std::size_t count = known_shape(card);
  const auto shape = card.text(4);
  std::vector<double> first = dimensions_at(card, 9, count);
  first.push_back(card.real_or(9 + count, 0.0, "NSM"));
  std::vector<StationFields> stations;
  for (std::size_t at = 10 + count; at <= card.size(); at += count + 3) {
    if (!card.blank(at) && !has_flag(card, at))
      throw CardError(title(card) + ": " + place_on_card(at) + " is '" + std::string(card.raw(at)) + "'",
                      "a station begins with YES or NO, or with a blank", "correct the fields of the stations");
    card.mark(at, FieldUse::used);
    StationFields station{.place = card.real_or(at + 1, 1.0, "X/XB"), .values = {}};
    for (std::size_t i = 0; i <= count; ++i)
      if (!card.blank(at + 2 + i)) station.values[i] = card.real(at + 2 + i, "DIM");
    stations.push_back(std::move(station));
  }
  std::vector<std::pair<double, SectionCard>> sections;
  for (const auto& [place, values] : filled_stations(first, stations, title(card))) {
    SectionCard section = section_of_shape(shape, {values.begin(), values.end() - 1}, title(card));
    section.nonstructural_mass = values.back();
    section.nonstructural_centre = section.neutral_axis;  // nonstructural mass lies along the neutral axis
    sections.emplace_back(place, std::move(section));
  }
  add_section(card, in, along(std::move(sections)));
}

constexpr auto section_readers = std::to_array<CardReader>(
    {{"PBAR", read_pbar}, {"PBEAM", read_pbeam}, {"PBARL", read_pbarl}, {"PBEAML", read_pbeaml}});

}  // namespace

std::span<const CardReader> section_cards() { return section_readers; }

}  // namespace kalfem::nastran
