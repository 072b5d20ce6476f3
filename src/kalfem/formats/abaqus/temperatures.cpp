// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/temperatures.hpp"

#include <algorithm>

#include "kalfem/base/units.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"
#include "kalfem/formats/abaqus/steps.hpp"

namespace kalfem::abaqus {

namespace {

using Row = TemperatureRow;

/// None, and a problem, where a row has too few constants.
std::vector<Row> read_rows(const Block& block, std::size_t least, std::size_t count, PlacedDeck& deck) {
  const std::size_t lines = count / 8 + 1;
  std::vector<Row> rows;
  for (std::size_t first = 0; first < std::max<std::size_t>(block.lines.size(), 1); first += lines) {
    const std::span<const DataLine> all(block.lines);
    const auto row = all.subspan(first, std::min(lines, all.size() - std::min(first, all.size())));
    auto values = all_numbers(row, "a constant of the material", deck.problems);
    if (values.size() < least) {
      deck.problems.add(row.empty() ? block.keyword.where : row.front().where,
                        block.keyword.title + " has " + std::to_string(values.size()) + " constants",
                        "its type has " + std::to_string(count), "correct the data");
      return {};
    }
    std::size_t place = 0;  // fields behind the temperature do not count, nor that of a single row
    for (const auto& line : row)
      for (std::size_t field = 0; field < line.fields.size(); ++field)
        if (place++ >= (block.lines.size() > lines ? count + 1 : count)) line.forget(field);
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
  return stated_ ? *stated_ : of_deck(keyword);
}

bool MaterialTemperature::is_known() const {
  return stated_ || !deck_.blocks("INITIALCONDITIONS").empty() || std::ranges::any_of(raw_.steps, [](const auto& step) {
           return std::ranges::any_of(step.blocks,
                                      [](const auto& block) { return block.keyword.name == "TEMPERATURE"; });
         });
}

bool MaterialTemperature::set(const Block& block, int place, double factor, std::vector<double>& temperatures) {
  const Keyword& keyword = block.keyword;
  if (keyword.has("FILE") || keyword.has("USER")) {
    deck_.problems.add(keyword.where, keyword.title + " takes temperatures from a results file or a user routine",
                       "a material depends on them, and they are not in the deck",
                       "state one `temperature` beside `deck`");
    return false;
  }
  for (const auto& line : block.lines)
    for (const Index node : deck_.node_list({line.field(0), line.where}, place))
      temperatures[static_cast<std::size_t>(node)] = factor * number_or(line, 1, 0.0, "a temperature", deck_.problems);
  return !block.lines.empty();
}

// The initial temperatures, then those of the steps up to the one that the model is for. The static steps have the same
// model, so that none may have other temperatures.
double MaterialTemperature::of_deck(const Keyword& keyword) {
  std::vector<double> initial(static_cast<std::size_t>(deck_.mesh.node_count()), 0.0);
  bool is_given = false;
  for (const auto& at : deck_.blocks("INITIALCONDITIONS"))
    is_given = set(*at.block, at.place, 1.0, initial) || is_given;
  std::vector<double> present = initial, of_model = initial;
  const auto* last = model_step(raw_);
  std::vector<std::pair<const RawDeck::Step*, std::vector<double>>> of_static;
  for (const auto& step : raw_.steps) {
    for (const auto& block : step.blocks) {
      if (block.keyword.name != "TEMPERATURE") continue;
      if (removes_earlier(deck_, block.keyword)) present = initial;
      is_given = set(block, 0, amplitude_at_end(deck_, block.keyword, raw_, step), present) || is_given;
    }
    if (&step == last) of_model = present;
    if (raw_.load_cases && step.is_static()) of_static.emplace_back(&step, present);
  }
  if (!is_given)
    deck_.notes.add(deck_.problems.location(keyword.where), keyword.title + " with several temperatures",
                    "the deck states no initial temperature, so that it is 0; state `temperature` for another one",
                    DeckNoteKind::doubtful);
  const std::string from = last ? ", with those of step " + std::to_string(last->number) : std::string();
  const auto [lowest, highest] = std::ranges::minmax_element(of_model);
  if (lowest == of_model.end()) return 0.0;
  if (*lowest != *highest)
    deck_.problems.add(keyword.where,
                       keyword.title + " depends on temperature, and the nodes have initial temperatures" + from +
                           " from " + shortest(*lowest) + " to " + shortest(*highest),
                       "materials are taken at one temperature", "state this `temperature` beside `deck`");
  for (const auto& [step, temperatures] : of_static)
    if (temperatures != of_model)
      deck_.problems.add(step->keyword.where,
                         "step " + std::to_string(step->number) + " has other temperatures than the model",
                         "a material depends on temperature, and one model serves all steps",
                         "state this `temperature` beside `deck`");
  return *lowest;
}

std::vector<double> constants_at(MaterialTemperature& temperature, std::vector<Row> rows, const Keyword& keyword,
                                 PlacedDeck& deck) {
  if (rows.empty()) return {};
  if (rows.size() == 1) return rows.front().constants;
  std::ranges::stable_sort(rows, {}, &Row::temperature);
  const double at = temperature.value(keyword);
  note_beyond(keyword, at, rows, deck);
  const auto above = std::ranges::lower_bound(rows, at, {}, &Row::temperature);
  if (above == rows.begin()) return rows.front().constants;
  if (above == rows.end())
    return std::ranges::lower_bound(rows, rows.back().temperature, {}, &Row::temperature)->constants;
  const auto below = std::ranges::lower_bound(rows, std::prev(above)->temperature, {}, &Row::temperature);
  const double share = (at - below->temperature) / (above->temperature - below->temperature);
  std::vector<double> constants(below->constants.size());
  for (std::size_t i = 0; i < constants.size(); ++i)
    constants[i] = (1.0 - share) * below->constants[i] + share * above->constants[i];
  return constants;
}

std::vector<double> constants_at(MaterialTemperature& temperature, const Block& block, std::size_t least,
                                 std::size_t count, PlacedDeck& deck) {
  if (block.keyword.has("DEPENDENCIES"))
    deck.notes.add(deck.problems.location(block.keyword.where), block.keyword.title + ", DEPENDENCIES",
                   "the dependence on field variables is ignored: of rows at one temperature the first is used",
                   DeckNoteKind::doubtful);
  return constants_at(temperature, read_rows(block, least, count, deck), block.keyword, deck);
}

}  // namespace kalfem::abaqus
