// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {
namespace {

/// Pairs x, y from the second line on, up to ENDT; a pair of SKIP is left out.
std::vector<std::pair<double, double>> read_points(const Card& card) {
  std::vector<std::pair<double, double>> points;
  for (std::size_t i = 9; i + 1 <= card.size() && card.text(i) != "ENDT"; i += 2)
    if (card.text(i) != "SKIP" && card.text(i + 1) != "SKIP")
      points.emplace_back(card.real(i, "x"), card.real(i + 1, "y"));
  if (points.size() > 1 && points.front().first > points.back().first) std::ranges::reverse(points);
  if (points.size() < 2)
    throw CardError(title(card) + " has " + std::to_string(points.size()) + " points", "a table needs at least two",
                    "add points up to ENDT");
  if (!std::ranges::is_sorted(points, {}, &std::pair<double, double>::first))
    throw CardError(title(card) + ": its points are not in order", "x must ascend or descend", "sort them");
  return points;
}

void add_table(const Card& card, const Reading& in, MaterialTable table) {
  table.where = card.place;
  if (!in.bulk.material_tables.try_emplace(card.id(1, "TID"), std::move(table)).second)
    throw CardError(title(card) + " is defined twice", "", "remove one of the tables");
}

void read_tablem1(const Card& card, const Reading& in) {
  for (const std::size_t axis : {2, 3})
    if (!card.says(axis, "LINEAR") && card.says(axis, "LOG"))
      throw CardError(title(card) + " has a logarithmic axis", "linear ones are read", "write its points linearly");
  add_table(card, in, {.form = MaterialTable::Form::value, .points = read_points(card)});
}

void read_tablem2(const Card& card, const Reading& in) {
  add_table(card, in, {.points = read_points(card), .shift = card.real_or(2, 0.0, "X1")});
}

void read_tablem3(const Card& card, const Reading& in) {
  const double scale = card.real(3, "X2");
  if (scale == 0.0) throw CardError(title(card) + ": X2 is 0", "it divides the temperature", "correct it");
  add_table(card, in, {.points = read_points(card), .shift = card.real_or(2, 0.0, "X1"), .scale = scale});
}

void read_tablem4(const Card& card, const Reading& in) {
  MaterialTable table{.form = MaterialTable::Form::polynomial,
                      .shift = card.real_or(2, 0.0, "X1"),
                      .scale = card.real(3, "X2"),
                      .range = {card.real(4, "X3"), card.real(5, "X4")}};
  if (table.scale == 0.0 || table.range[0] > table.range[1])
    throw CardError(title(card) + ": X2 is 0, or X3 is above X4", "they scale and limit the temperature",
                    "correct them");
  for (std::size_t i = 9; i <= card.size() && card.text(i) != "ENDT"; ++i)
    table.coefficients.push_back(card.real_or(i, 0.0, "A"));
  add_table(card, in, std::move(table));
}

/// The tables stand at the places that the values have on the card of the material: 2 to `last`.
template <std::size_t last>
void read_matt(const Card& card, const Reading& in) {
  MaterialTemperatureCard dependence{.kind = "MAT" + card.name.substr(4), .tables = {}, .where = card.place};
  for (std::size_t field = 2; field <= last; ++field)
    if (!card.blank(field)) dependence.tables.emplace_back(field, card.id(field, "a table"));
  if (!in.bulk.material_temperatures.try_emplace(card.id(1, "MID"), std::move(dependence)).second)
    throw CardError(title(card) + " is defined twice", "", "remove one of the cards");
}

void read_tempd(const Card& card, const Reading& in) {
  for (std::size_t i = 1; i + 1 <= card.size(); i += 2)
    if (!card.blank(i)) in.bulk.temperatures.push_back({card.id(i, "SID"), 0, card.real(i + 1, "T"), card.place});
}

void read_temp(const Card& card, const Reading& in) {
  for (const std::size_t i : {2, 4, 6})
    if (!card.blank(i))
      in.bulk.temperatures.push_back({card.id(1, "SID"), card.id(i, "G"), card.real(i + 1, "T"), card.place});
}

constexpr auto temperature_readers = std::to_array<CardReader>({{"TABLEM1", read_tablem1},
                                                                {"TABLEM2", read_tablem2},
                                                                {"TABLEM3", read_tablem3},
                                                                {"TABLEM4", read_tablem4},
                                                                {"MATT1", read_matt<5>},
                                                                {"MATT2", read_matt<8>},
                                                                {"MATT8", read_matt<8>},
                                                                {"MATT9", read_matt<23>},
                                                                {"TEMPD", read_tempd},
                                                                {"TEMP", read_temp}});

}  // namespace

std::span<const CardReader> temperature_cards() { return temperature_readers; }

}  // namespace kalfem::nastran
