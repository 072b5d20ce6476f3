#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"
#include "kalfem/formats/nastran/section_shapes.hpp"

namespace kalfem::nastran {
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
