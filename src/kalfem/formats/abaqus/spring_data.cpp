// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/spring_data.hpp"

#include "kalfem/formats/abaqus/ledger_sweep.hpp"

#include <algorithm>
#include <set>

namespace kalfem::abaqus {

namespace {

/// Reads one *SPRING or *DASHPOT.
class SpringReader {
public:
  SpringReader(PlacedDeck& deck, const Block& block, Family family, MaterialTemperature& temperature)
      : deck_(deck), block_(block), family_(family), temperature_(temperature) {}

  std::optional<SpringData> read() {
    SpringData data;
    if (!read_directions(data)) return {};
    if (block_.keyword.has("COMPLEXSTIFFNESS")) return refuse("has COMPLEX STIFFNESS", "stiffnesses are real");
    const bool nonlinear = block_.keyword.has("NONLINEAR");
    const auto rows = nonlinear ? slopes_at_rest() : constants();
    if (rows.empty()) return {};
    if (rows.size() > 1 && !temperature_.is_known())
      return refuse("has values at several temperatures", "the deck does not state its temperature");
    if (nonlinear)
      deck_.notes.add(deck_.problems.location(block_.keyword.where), block_.keyword.title + ", NONLINEAR",
                      "only the slope at rest is used", DeckNoteKind::changed);
    data.value = constants_at(temperature_, rows, block_.keyword, deck_).front();
    return data;
  }

private:
  std::nullopt_t refuse(const std::string& what, const std::string& why) {
    deck_.problems.add(block_.keyword.where, block_.keyword.title + " " + what, why,
                       "give one value, or state `temperature` beside `deck` where it is by temperature alone");
    return std::nullopt;
  }

  /// The first line; rows begin behind it.
  bool read_directions(SpringData& data) {
    const auto& lines = block_.lines;
    const auto& line = line_of(block_, 0);
    if (is_axial(family_)) {
      const bool left_out = !line.field(0).empty() &&
                            (lines.size() == 1 || line_of(block_, 1).field(0).empty() || !to_integer(line.field(0)));
      first_row_ = left_out ? 0 : 1;
      if (!left_out) line.forget(0);
      return true;
    }
    for (std::size_t end = 0; end < (is_grounded(family_) ? 1u : 2u); ++end) {
      const auto direction =
          end == 1 && line.field(1).empty() ? to_integer(line.field(0)) : to_integer(line.field(end));
      if (!direction || *direction < 1 || *direction > 6) {
        deck_.problems.add(lines.empty() ? block_.keyword.where : line.where,
                           block_.keyword.title + " has no direction",
                           "the direction (1 to 6) states the axis along or about which it acts",
                           "write the direction on the first data line");
        return false;
      }
      data.directions[end] = static_cast<int>(*direction) - 1;
    }
    return true;
  }

  /// value, frequency, temperature.
  std::vector<TemperatureRow> constants() {
    std::vector<TemperatureRow> rows;
    std::set<double> frequencies;
    for (std::size_t i = first_row_; i < block_.lines.size(); ++i) {
      const auto& line = block_.lines[i];
      if (line.fields.empty()) continue;
      const auto value = number_at(line, 0, "a stiffness or damping", deck_.problems);
      if (!value) return {};
      frequencies.insert(number_or(line, 1, 0.0, "a frequency", deck_.problems));
      rows.push_back({{*value}, number_or(line, 2, 0.0, "a temperature", deck_.problems)});
    }
    if (rows.size() == 1)  // without effect
      for (const auto& line : block_.lines)
        if (&line - block_.lines.data() >= static_cast<std::ptrdiff_t>(first_row_)) forget_from(line, 1);
    if (rows.empty())
      deck_.problems.add(block_.keyword.where, block_.keyword.title + " has no value", "",
                         "write it on the second data line");
    if (frequencies.size() > 1) return refused("has values at several frequencies", "a model has one stiffness");
    if (!has_own_temperatures(rows))
      return refused("has several values at one temperature", "a dependence on field variables is not read");
    return rows;
  }

  std::vector<TemperatureRow> refused(const std::string& what, const std::string& why) {
    refuse(what, why);
    return {};
  }

  static bool has_own_temperatures(std::vector<TemperatureRow> rows) {
    std::ranges::sort(rows, {}, &TemperatureRow::temperature);
    return std::ranges::adjacent_find(rows, {}, &TemperatureRow::temperature) == rows.end();
  }

  // The table of a temperature is sorted by deflection; the piece that holds zero, or the last one before it, gives the
  // slope.
  std::vector<TemperatureRow> slopes_at_rest() {
    std::map<double, std::vector<std::pair<double, double>>> tables;  // deflections and forces by temperature
    for (std::size_t i = first_row_; i < block_.lines.size(); ++i) {
      const auto& line = block_.lines[i];
      if (line.fields.size() > 1)
        tables[number_or(line, 2, 0.0, "a temperature", deck_.problems)].emplace_back(
            number_or(line, 1, 0.0, "a deflection", deck_.problems),
            number_or(line, 0, 0.0, "a force", deck_.problems));
    }
    std::vector<TemperatureRow> rows;
    for (auto& [temperature, points] : tables) rows.push_back({{slope_at_rest(points)}, temperature});
    if (rows.empty()) rows.push_back({{0.0}, 0.0});
    return rows;
  }

  static double slope_at_rest(std::vector<std::pair<double, double>>& points) {
    std::ranges::sort(points);
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
      if (points[i + 1].first > 0.0 || i + 2 == points.size())
        if (const double step = points[i + 1].first - points[i].first; step > 0.0)
          return (points[i + 1].second - points[i].second) / step;
    return 0.0;
  }

  PlacedDeck& deck_;
  const Block& block_;
  Family family_;
  MaterialTemperature& temperature_;
  std::size_t first_row_ = 1;
};

}  // namespace

std::optional<SpringData> spring_data(PlacedDeck& deck, const Block& block, Family family,
                                      MaterialTemperature& temperature) {
  return SpringReader(deck, block, family, temperature).read();
}

}  // namespace kalfem::abaqus
