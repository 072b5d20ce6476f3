#include "kalfem/formats/abaqus/temperatures.hpp"

#include <algorithm>

#include "kalfem/base/units.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

/// Constants at one temperature.
struct Row {
  std::vector<double> constants;
  double temperature = 0.0;
};

/// None, and a problem, where a row has too few constants.
std::vector<Row> read_rows(const Block& block, std::size_t least, std::size_t count, PlacedDeck& deck) {
  const std::size_t lines = count / 8 + 1;
  std::vector<Row> rows;
  for (std::size_t first = 0; first < std::max<std::size_t>(block.lines.size(), 1); first += lines) {
    Block row{block.keyword, {}};
    for (std::size_t i = first; i < std::min(first + lines, block.lines.size()); ++i)
      row.lines.push_back(block.lines[i]);
    auto values = all_numbers(row, 0, "a constant of the material", deck.problems);
    if (values.size() < least) {
      deck.problems.add(row.lines.empty() ? block.keyword.where : row.lines.front().where,
                        block.keyword.title + " has " + std::to_string(values.size()) + " constants",
                        "its type has " + std::to_string(count), "correct the data");
      return {};
    }
    values.resize(std::max(values.size(), count + 1), 0.0);
    rows.push_back({{values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count)}, values[count]});
  }
  return rows;
}

void note_beyond(const Keyword& keyword, double temperature, const std::vector<Row>& rows, PlacedDeck& deck) {
  const double first = rows.front().temperature, last = rows.back().temperature;
  if (temperature >= first && temperature <= last) return;
  deck.notes.add(deck.problems.location(keyword.where), keyword.title + " at the temperature " + shortest(temperature),
                 "its values go from " + shortest(first) + " to " + shortest(last) + "; the nearest one is used",
                 DeckNoteKind::doubtful);
}

}  // namespace

double MaterialTemperature::value(const Keyword& keyword) {
  is_used_ = true;
  return stated_ ? *stated_ : initial(keyword);
}

double MaterialTemperature::initial(const Keyword& keyword) {
  std::vector<double> temperatures(static_cast<std::size_t>(deck_.mesh.node_count()), 0.0);
  bool is_given = false;
  for (const auto& at : deck_.blocks("INITIALCONDITIONS"))
    for (const auto& line : at.block->lines)
      for (const Index node : deck_.node_list({line.field(0), line.where}, at.place)) {
        temperatures[static_cast<std::size_t>(node)] = number_or(line, 1, 0.0, "a temperature", deck_.problems);
        is_given = true;
      }
  if (!is_given)
    deck_.notes.add(deck_.problems.location(keyword.where), keyword.title + " with several temperatures",
                    "the deck states no initial temperature, so that it is 0; state `temperature` for another one",
                    DeckNoteKind::doubtful);
  const auto [lowest, highest] = std::ranges::minmax_element(temperatures);
  if (lowest == temperatures.end()) return 0.0;
  if (*lowest != *highest)
    deck_.problems.add(keyword.where,
                       keyword.title + " depends on temperature, and the nodes have initial temperatures from " +
                           shortest(*lowest) + " to " + shortest(*highest),
                       "materials are taken at one temperature", "state this `temperature` beside `deck`");
  return *lowest;
}

std::vector<double> constants_at(MaterialTemperature& temperature, const Block& block, std::size_t least,
                                 std::size_t count, PlacedDeck& deck) {
  if (block.keyword.has("DEPENDENCIES"))
    deck.notes.add(deck.problems.location(block.keyword.where), block.keyword.title + ", DEPENDENCIES",
                   "the dependence on field variables is ignored: of rows at one temperature the first is used",
                   DeckNoteKind::doubtful);
  auto rows = read_rows(block, least, count, deck);
  if (rows.empty()) return {};
  if (rows.size() == 1) return rows.front().constants;
  std::ranges::stable_sort(rows, {}, &Row::temperature);
  const double at = temperature.value(block.keyword);
  note_beyond(block.keyword, at, rows, deck);
  const auto above = std::ranges::lower_bound(rows, at, {}, &Row::temperature);
  if (above == rows.begin()) return rows.front().constants;
  if (above == rows.end())
    return std::ranges::lower_bound(rows, rows.back().temperature, {}, &Row::temperature)->constants;
  const auto below = std::ranges::lower_bound(rows, std::prev(above)->temperature, {}, &Row::temperature);
  const double share = (at - below->temperature) / (above->temperature - below->temperature);
  std::vector<double> constants(count);
  for (std::size_t i = 0; i < count; ++i)
    constants[i] = (1.0 - share) * below->constants[i] + share * above->constants[i];
  return constants;
}

}  // namespace kalfem::abaqus
