// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kalfem/formats/abaqus/kinematics.hpp"
#include "kalfem/formats/abaqus/steps.hpp"

namespace kalfem::abaqus {

namespace {

using Directions = Kinematics::Directions;

// Named conditions of *BOUNDARY: XSYMM holds u1, ur2 and ur3, XASYMM its complement u2, u3 and ur1, and so on for y
// and z.
const std::map<std::string, Directions, std::less<>>& named_supports() {
  static const std::map<std::string, Directions, std::less<>> supports = {
      {"ENCASTRE", {true, true, true, true, true, true}},  {"PINNED", {true, true, true, false, false, false}},
      {"XSYMM", {true, false, false, false, true, true}},  {"YSYMM", {false, true, false, true, false, true}},
      {"ZSYMM", {false, false, true, true, true, false}},  {"XASYMM", {false, true, true, true, false, false}},
      {"YASYMM", {true, false, true, false, true, false}}, {"ZASYMM", {true, true, false, false, false, true}}};
  return supports;
}

std::optional<Directions> read_directions(PlacedDeck& deck, const DataLine& line) {
  if (const auto named = named_supports().find(upper_case(line.field(1))); named != named_supports().end())
    return named->second;
  const auto first = to_integer(line.field(1));
  const auto last = line.field(2).empty() ? first : to_integer(line.field(2));
  if (!first || !last || *first < 1 || *last < *first) {
    deck.problems.add(
        line.where,
        "the directions '" + to_string(line.field(1)) + "', '" + to_string(line.field(2)) + "' cannot be read",
        "*BOUNDARY expects a node or set, then the first and the last direction (1 to 6), or ENCASTRE, "
        "PINNED, XSYMM ...",
        "correct the line");
    return {};
  }
  if (*last > 6)
    deck.notes.add(deck.problems.location(line.where), "*BOUNDARY of directions above 6",
                   "pressures, temperatures and warping are not modelled", DeckNoteKind::unused);
  Directions directions{};
  for (std::int64_t d = *first; d <= std::min<std::int64_t>(6, *last); ++d)
    directions[static_cast<std::size_t>(d - 1)] = true;
  return directions;
}

/// Whether the values of a *BOUNDARY are displacements that a static step imposes; a problem where they are others.
bool imposes_displacements(PlacedDeck& deck, const Keyword& keyword) {
  const std::string type = keyword.word("TYPE");
  if ((type.empty() || type == "DISPLACEMENT") && !keyword.has("USER") &&
      (keyword.word("LOADCASE").empty() || keyword.word("LOADCASE") == "1"))
    return true;
  deck.problems.add(keyword.where, keyword.title + " prescribes values that are no displacements of a static step",
                    "velocities, accelerations, imaginary parts and values of user routines are not read",
                    "write displacements");
  return false;
}

bool moves(const Holds& holds, const NodalDof& dof) {
  const auto found = holds.find(dof);
  return found != holds.end() && (found->second.value != 0.0 || found->second.frozen);
}

bool hold_the_same(const Holds& a, const Holds& b) {
  return std::ranges::equal(a, b, {}, &Holds::value_type::first, &Holds::value_type::first);
}

}  // namespace

SupportHistory::SupportHistory(const RawDeck& raw, PlacedDeck& deck)
    : deck_(deck),
      load_cases_(std::ranges::any_of(raw.steps, [&](const auto& step) { return wants_case(raw, step); })) {
  Holds first;
  for (const auto& at : deck.blocks("BOUNDARY")) read_lines(*at.block, at.place, first);
  Shared present = std::make_shared<const Holds>(std::move(first));
  model_ = present;
  const auto* step_of_model = model_step(raw);
  for (const auto& step : raw.steps) {
    const Shared before = present;
    bool is_first = true;
    Holds holds = *present;
    if (step.is_perturbation())
      for (auto& [dof, hold] : holds) hold.value = 0.0;
    for (const auto& block : step.blocks) {
      if (block.keyword.name != "BOUNDARY") continue;
      if (removes_earlier(deck, block.keyword) && is_first) holds.clear();
      is_first = false;
      Holds lines;
      read_lines(block, 0, lines);
      const double factor = wants_case(raw, step) ? amplitude_at_end(deck, block.keyword, raw, step) : 1.0;
      for (auto& [dof, hold] : lines) {
        const auto earlier = holds.find(dof);
        hold.value *= factor;
        if (block.keyword.has("FIXED") && earlier != holds.end()) continue;  // it stays where it is held
        hold.frozen = block.keyword.has("FIXED");
        if (earlier != holds.end()) hold.name = earlier->second.name;
        holds[dof] = hold;
      }
    }
    if (!is_first || step.is_perturbation()) present = std::make_shared<const Holds>(std::move(holds));
    steps_.push_back(present);
    if (&step == step_of_model) model_ = present;
    if (step.is_perturbation() && raw.from_abaqus) present = before;
  }
  for (const auto& step : raw.steps)
    if (step.procedure == "FREQUENCY" && !hold_the_same(of_step(step.number), *model_))
      deck.notes.add(deck.problems.location(step.keyword.where), "supports that change between steps of modes",
                     "those of step " + std::to_string(step_of_model->number) + " hold", DeckNoteKind::doubtful);
  find_varying(raw);
}

/// node or set, first and last direction, value.
void SupportHistory::read_lines(const Block& block, int place, Holds& holds) {
  const Keyword& keyword = block.keyword;
  if (keyword.has("SUBMODEL"))
    deck_.notes.add(deck_.problems.location(keyword.where), "*BOUNDARY, SUBMODEL",
                    "the driven nodes are fixed: their motion is that of another model", DeckNoteKind::changed);
  for (const auto& line : block.lines) {
    const bool all_displacements = keyword.has("SUBMODEL") && line.fields.size() < 2;
    const auto directions = all_displacements ? std::optional(Directions{true, true, true, false, false, false})
                                              : read_directions(deck_, line);
    if (!directions) continue;
    double value = number_or(line, 3, 0.0, "a displacement", deck_.problems);
    if (value != 0.0 && load_cases_ && !imposes_displacements(deck_, keyword)) continue;
    if (value != 0.0 && !load_cases_)
      deck_.notes.add(deck_.problems.location(line.where), "*BOUNDARY with a value",
                      "a prescribed motion is read as fixed; `static: {deck_cases: true}` imposes it",
                      DeckNoteKind::unused);
    const bool by_name = deck_.is_node_set(line.field(0), place);
    const std::string name = by_name ? deck_.spelled_set(line.field(0), place, true) : "boundary";
    for (const Index node : deck_.node_list({line.field(0), line.where}, place))
      for (int d = 0; d < 6; ++d)
        if ((*directions)[static_cast<std::size_t>(d)]) {
          auto& hold = holds.try_emplace({node, d}, Hold{name, 0.0, false, line.where}).first->second;
          hold.value = value;
          hold.where = line.where;
        }
  }
}

void SupportHistory::find_varying(const RawDeck& raw) {
  if (!load_cases_) return;
  for (const auto& step : raw.steps) {
    if (!wants_case(raw, step)) continue;
    const Holds& holds = of_step(step.number);
    for (const auto& [dof, hold] : holds)
      if (moves(holds, dof) || !model_->contains(dof)) varying_.insert(dof);
    for (const auto& [dof, hold] : *model_)
      if (!holds.contains(dof)) varying_.insert(dof);
  }
}

}  // namespace kalfem::abaqus
