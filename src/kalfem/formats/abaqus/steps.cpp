// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/steps.hpp"

#include <algorithm>

namespace kalfem::abaqus {

namespace {

bool has_load(const Block& block) {
  const std::string& name = block.keyword.name;
  if (name != "BOUNDARY") return name == "CLOAD" || name == "DLOAD" || name == "DSLOAD" || name == "PRE-TENSIONSECTION";
  return std::ranges::any_of(block.lines,
                             [](const auto& line) { return to_number(line.field(3)).value_or(0.0) != 0.0; });
}

/// Whether something loads a static step; *TEMPERATURE loads what expands. Loads of earlier steps go on, but for those
/// that a perturbation leaves behind, see LoadReader.
bool is_loaded(const RawDeck& raw, const RawDeck::Step& last) {
  const auto goes_on = [&](const RawDeck::Step& step, const Block& block) {
    if (step.number == last.number || !last.is_perturbation()) return step.number <= last.number;
    const std::string& name = block.keyword.name;
    return step.number < last.number && !raw.from_abaqus && (name == "DLOAD" || name == "DSLOAD");
  };
  return std::ranges::any_of(raw.steps, [&](const auto& step) {
    return step.is_static() && std::ranges::any_of(step.blocks, [&](const auto& block) {
             return goes_on(step, block) && (has_load(block) || (raw.expands && block.keyword.name == "TEMPERATURE"));
           });
  });
}

bool finds_modes(const RawDeck::Step& step) { return step.procedure == "FREQUENCY"; }

}  // namespace

const RawDeck::Step* model_step(const RawDeck& raw) {
  const auto first = [&](auto wanted) {
    const auto found = std::ranges::find_if(raw.steps, wanted);
    return found == raw.steps.end() ? nullptr : &*found;
  };
  if (const auto* step = first(finds_modes)) return step;
  if (const auto* step = first([](const auto& each) { return !each.is_static() && !each.procedure.empty(); }))
    return step;
  return raw.steps.empty() ? nullptr : &raw.steps.front();
}

const RawDeck::Step* base_step(const RawDeck& raw, const RawDeck::Step& step) {
  const bool is_perturbation = step.is_perturbation() || (raw.from_abaqus && !step.is_static());
  if (!is_perturbation) return nullptr;
  const RawDeck::Step* last = nullptr;
  bool is_nonlinear = false;
  for (const auto& each : raw.steps) {
    if (each.number >= step.number || !each.is_static() || (raw.from_abaqus && each.is_perturbation())) continue;
    last = &each;
    is_nonlinear = is_nonlinear || each.is_nonlinear();
  }
  if (!last || !is_loaded(raw, *last) || (raw.from_abaqus && !is_nonlinear)) return nullptr;
  return last;
}

const RawDeck::Step* preload_step(const RawDeck& raw) {
  const auto* modes = model_step(raw);
  return !modes || modes->is_static() || modes->procedure.empty() ? nullptr : base_step(raw, *modes);
}

bool wants_case(const RawDeck& raw, const RawDeck::Step& step) {
  if (!step.is_static() || raw.load_cases) return step.is_static();
  for (const auto* base = preload_step(raw); base; base = base_step(raw, *base))
    if (base == &step) return true;
  return false;
}

namespace {

/// A loaded static step before the modes whose stress the deck's program leaves out.
void note_left_out_stress(const RawDeck& raw, DeckNotes& notes, const Problems& problems) {
  const auto* modes = model_step(raw);
  if (!modes || modes->is_static() || preload_step(raw)) return;
  for (const auto& step : raw.steps) {
    if (step.number >= modes->number || !step.is_static() || !is_loaded(raw, step)) continue;
    if (!step.is_nonlinear() && !modes->is_perturbation()) continue;
    notes.add(problems.location(modes->keyword.where), "modes behind a loaded static step",
              std::string("as in ") +
                  (raw.from_abaqus ? "Abaqus, its stress is left out without NLGEOM"
                                   : "CalculiX, its stress is left out without PERTURBATION") +
                  "; state `preload: " + step.name() + "` with `static: {deck_cases: true}` to have it",
              DeckNoteKind::doubtful);
    return;
  }
}

/// A static perturbation in Abaqus behind a loaded step with small displacements.
void note_perturbations_without_stress(const RawDeck& raw, DeckNotes& notes, const Problems& problems) {
  if (!raw.load_cases || !raw.from_abaqus) return;
  const auto loads_before = [&](const RawDeck::Step& step) {
    return std::ranges::any_of(raw.steps, [&](const auto& each) {
      return each.number < step.number && each.is_static() && !each.is_perturbation() && is_loaded(raw, each);
    });
  };
  for (const auto& step : raw.steps)
    if (step.is_static() && step.is_perturbation() && !base_step(raw, step) && loads_before(step))
      notes.add(problems.location(step.keyword.where), "*STEP, PERTURBATION of a static step",
                "as in Abaqus, the stress of the steps before is left out, since NLGEOM is not on in them",
                DeckNoteKind::doubtful);
}

}  // namespace

void note_steps(const RawDeck& raw, DeckNotes& notes, const Problems& problems) {
  note_left_out_stress(raw, notes, problems);
  note_perturbations_without_stress(raw, notes, problems);
  const auto* preload = preload_step(raw);
  for (const auto& step : raw.steps) {
    if (step.is_nonlinear())
      notes.add(problems.location(step.keyword.where), "*STEP, NLGEOM", "displacements are taken as small",
                DeckNoteKind::doubtful);
    if (raw.load_cases || (preload && step.number <= preload->number)) continue;
    for (const auto& block : step.blocks)
      if (block.keyword.name != "BOUNDARY" && block.keyword.name != "TEMPERATURE")
        notes.add(problems.location(block.keyword.where), block.keyword.title,
                  "loads do not change the modes; `static: {deck_cases: true}` reads those of static steps",
                  DeckNoteKind::unused);
  }
}

bool removes_earlier(PlacedDeck& deck, const Keyword& keyword) {
  const std::string op = keyword.word("OP");
  if (!op.empty() && op != "NEW" && op != "MOD")
    deck.problems.add(keyword.where, keyword.title + " has OP=" + to_string(op), "it must be MOD or NEW", "correct it");
  return op == "NEW";
}

double amplitude_at_end(PlacedDeck& deck, const Keyword& keyword, const RawDeck& raw, const RawDeck::Step& step) {
  const std::string name = keyword.get("AMPLITUDE");
  if (name.empty()) return 1.0;
  const auto fail = [&](const std::string& why) {
    deck.problems.add(keyword.where, keyword.title + " has AMPLITUDE=" + to_string(name), why,
                      "write the load's value at the end of the step, without AMPLITUDE");
    return 1.0;
  };
  const Block* amplitude = deck.find_block("AMPLITUDE", name, 0).block;
  if (!amplitude) return fail("there is no *AMPLITUDE of that name");
  const Keyword& given = amplitude->keyword;
  if (const auto kind = given.word("DEFINITION"); !kind.empty() && kind != "TABULAR")
    return fail("the amplitude is not a table of times and values");
  if (const auto value = given.word("VALUE"); (!value.empty() && value != "RELATIVE") || given.has("USER"))
    return fail("the amplitude is not a relative one");
  const std::string axis = given.word("TIME");
  if (!axis.empty() && axis != "STEPTIME" && axis != "TOTALTIME")
    return fail("its TIME is neither STEP nor TOTAL TIME");
  const auto values = all_numbers(amplitude->lines, "a time or value", deck.problems);
  if (values.size() < 2 || values.size() % 2 != 0) return fail("the amplitude has no pairs of times and values");
  const auto period_of = [](const RawDeck::Step& each) {
    (void)line_of(each.procedure_data, 0).field(1);  // it counts from here on
    return each.period;
  };
  double time = period_of(step);
  if (axis == "TOTALTIME")
    for (const auto& earlier : raw.steps)
      if (earlier.number < step.number) time += period_of(earlier);
  time -= number_parameter(given, "SHIFTX", deck.problems).value_or(0.0);
  const double raised = number_parameter(given, "SHIFTY", deck.problems).value_or(0.0);
  const std::size_t count = values.size() / 2;
  std::size_t above = 0;
  while (above < count && values[2 * above] < time) ++above;
  if (above == 0) return values[1] + raised;
  if (above == count) return values[2 * count - 1] + raised;
  const double low = values[2 * above - 2], high = values[2 * above];
  const double share = (time - low) / (high - low);
  return (1.0 - share) * values[2 * above - 1] + share * values[2 * above + 1] + raised;
}

}  // namespace kalfem::abaqus
