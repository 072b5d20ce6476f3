// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/ledger_sweep.hpp"

#include "kalfem/formats/abaqus/deck_reader.hpp"
#include "kalfem/formats/abaqus/steps.hpp"

#include <algorithm>
#include <set>

namespace kalfem::abaqus {

namespace {

using Names = std::set<std::string, std::less<>>;

/// Parameters without effect on natural modes and linear statics, by keyword; those of "" belong to every keyword.
const std::map<std::string, Names, std::less<>>& idle_parameters() {
  static const std::map<std::string, Names, std::less<>> table = {
      {"", {"INTERNAL", "REGIONTYPE", "ORPHANNODES", "UNSORTED", "RTOL"}},
      {"SHELLSECTION", {"SECTIONINTEGRATION", "CONTROLS", "LAYUP", "TEMPERATURE", "POISSON", "ORIENTATION"}},
      {"SHELLGENERALSECTION", {"CONTROLS", "LAYUP", "POISSON", "ORIENTATION", "ZERO"}},
      {"SOLIDSECTION", {"CONTROLS", "LAYUP", "ORIENTATION"}},
      {"MEMBRANESECTION", {"CONTROLS", "ORIENTATION"}},
      {"BEAMSECTION", {"CONTROLS", "POISSON", "TEMPERATURE", "ORIENTATION"}},
      {"BEAMGENERALSECTION", {"POISSON", "ZERO"}},
      {"SURFACE", {"NOTHICK", "NOOFFSET", "TRIM", "MAXRATIO", "FILLETRADIUS", "PROPERTY"}},
      {"BOUNDARY", {"AMPLITUDE", "TYPE", "LOADCASE", "USER", "OP", "FIXED", "STEP", "INC", "TIMEDELAY", "SUBMODEL"}},
      {"CLOAD", {"FOLLOWER"}},
      {"DLOAD", {"FOLLOWER", "CONSTANTRESULTANT"}},
      {"DSLOAD", {"FOLLOWER", "CONSTANTRESULTANT"}},
      {"RIGIDBODY", {"ISOTHERMAL"}},
      {"COUPLING", {"ADJUST"}},
      {"TIE", {"NOROTATION", "ADJUST", "TYPE", "CONSTRAINTRATIO", "NOTHICKNESS"}},
      {"MASS", {"ALPHA", "COMPOSITE"}},
      {"ROTARYINERTIA", {"ALPHA", "COMPOSITE"}},
      {"INITIALCONDITIONS", {"TYPE", "STEP", "INC"}},
      {"TEMPERATURE", {"OP", "AMPLITUDE", "FILE", "USER", "BSTEP", "BINC", "ESTEP", "EINC"}},
      {"AMPLITUDE", {"SMOOTH"}},
      {"MATERIAL", {"SRATEFACTOR", "SRATETYPE", "STRAINRATEREGULARIZATION"}},
      {"STATIC",
       {"DIRECT", "STABILIZE", "ALLSDTOL", "CONTINUE", "FACTOR", "ADIABATIC", "LONGTERM", "SOLVER", "EXPLICIT"}},
      {"FREQUENCY",
       {"EIGENSOLVER", "SOLVER", "NORMALIZATION", "STORAGE", "GLOBAL", "RESIDUALMODES", "DAMPINGPROJECTION", "SIM",
        "PROPERTYEVALUATION", "CYCMPC", "ACOUSTICCOUPLING"}},
      {"STEP",
       {"NAME", "INC", "EXTRAPOLATION", "UNSYMM", "CONVERTSDI", "INCF", "AMPLITUDE", "NLGEOM", "PERTURBATION",
        "SOLVER"}}};
  return table;
}

/// Fields without effect from a position on, by keyword: points of integration of a section, what solids do not need,
/// the temperature or frequency of a single row.
const std::map<std::string, std::size_t, std::less<>>& idle_fields() {
  static const std::map<std::string, std::size_t, std::less<>> table = {{"SHELLSECTION", 1}, {"SHELLGENERALSECTION", 1},
                                                                        {"SOLIDSECTION", 0}, {"BEAMSECTION", 0},
                                                                        {"ELASTIC", 0},      {"DENSITY", 0},
                                                                        {"SPRING", 1},       {"DASHPOT", 1}};
  return table;
}

/// Keywords of which a field that is not read changes stiffness or mass; of a general beam section only the rows by
/// temperature do, from the fourth line on.
bool is_whole(const std::string& keyword, std::size_t line) {
  static const Names names = {"MASS", "ROTARYINERTIA", "NONSTRUCTURALMASS", "DISTRIBUTING"};
  return names.contains(keyword) || (keyword == "BEAMGENERALSECTION" && line > 2);
}

/// Parameters that name a keyword or its elements: being asked for them does not mean that it is used.
bool is_name(std::string_view parameter) {
  return parameter == "NAME" || parameter == "ELSET" || parameter == "NSET" || parameter == "INPUT";
}

class Sweep {
public:
  Sweep(DeckNotes& notes, const Problems& problems, Ledger* ledger)
      : notes_(notes), problems_(problems), ledger_(ledger) {}

  void settle(const Block& block) {
    const bool used = is_used(block);
    const bool has_data = !block.lines.empty() || block.keyword.parameters.size() > 1;
    if (!used && has_data && !is_load(block.keyword.name))
      tell(block.keyword.where, block.keyword.title, "nothing uses it", DeckNoteKind::unused);
    settle(block.keyword, used);
    for (std::size_t i = 0; i < block.lines.size(); ++i) settle(block.keyword, block.lines[i], i, used);
    for (const auto& option : block.options) settle_option(option, used);
  }

  void settle(const Keyword& keyword, bool used = true) {
    for (const auto& parameter : keyword.parameters) {
      if (parameter.asked) {
        enter(keyword.where, keyword.title, "parameter " + parameter.name, used ? FieldFate::used : FieldFate::told);
        continue;
      }
      const bool idle = !used || is_idle(keyword.name, parameter.name);
      enter(keyword.where, keyword.title, "parameter " + parameter.name, idle ? FieldFate::told : FieldFate::refused);
      if (!used) continue;
      tell(keyword.where, "parameter " + parameter.name + " of " + keyword.title,
           idle ? "without effect on natural modes and linear statics" : "it is not read, and may change the model",
           idle ? DeckNoteKind::unused : DeckNoteKind::missing);
    }
  }

  /// How a step is solved: increments, how many modes and in which range, solvers. kalfem's own options say that, so
  /// all of it is entered alone; a parameter that is not known may mean another analysis. A step that is not solved has
  /// no effect.
  void settle_procedure(const Block& block, bool is_solved) {
    for (const auto& parameter : block.keyword.parameters) {
      const bool idle = !is_solved || is_idle(block.keyword.name, parameter.name);
      const std::string field = "parameter " + parameter.name;
      enter(block.keyword.where, block.keyword.title, field, idle ? FieldFate::told : FieldFate::refused);
      if (!idle)
        tell(block.keyword.where, field + " of " + block.keyword.title, "it is not read, and may change the analysis",
             DeckNoteKind::missing);
    }
    for (const auto& line : block.lines)
      for (std::size_t i = 0; i < line.fields.size(); ++i)
        if (!line.fields[i].empty())
          enter(line.where, block.keyword.title, field_name(i),
                is_solved && line.is_asked(i) ? FieldFate::used : FieldFate::told);
  }

  void enter(const Where& where, const std::string& card, const std::string& field, FieldFate fate,
             std::size_t count = 1) {
    if (ledger_ && count > 0) ledger_->enter(problems_.location(where), card, field, fate, count);
  }

private:
  /// Loads that no load case needs have a note of their own, see note_steps().
  static bool is_load(const std::string& keyword) {
    return keyword != "TEMPERATURE" && classify(keyword).use == KeywordUse::load;
  }

  static bool is_used(const Block& block) {
    const auto& parameters = block.keyword.parameters;
    if (std::ranges::any_of(parameters, [](const auto& each) { return each.asked && !is_name(each.name); }))
      return true;
    if (std::ranges::any_of(block.lines, [](const auto& line) { return line.asked != 0; })) return true;
    return std::ranges::any_of(block.options, [](const auto& option) { return is_used(option); });
  }

  static bool is_idle(const std::string& keyword, const std::string& parameter) {
    const auto& table = idle_parameters();
    if (table.at("").contains(parameter)) return true;
    const auto own = table.find(keyword);
    return own != table.end() && own->second.contains(parameter);
  }

  /// An option that the reader did not look at, of a keyword that it used.
  void settle_option(const Block& option, bool used) {
    if (used && !option.lines.empty() && !is_used(option)) {
      tell(option.keyword.where, option.keyword.title, "it is not read for this keyword, and may change the model",
           DeckNoteKind::missing);
      for (const auto& line : option.lines)
        for (std::size_t i = 0; i < line.fields.size(); ++i)
          enter(line.where, option.keyword.title, field_name(i), FieldFate::refused);
      return;
    }
    settle(option);
  }

  void settle(const Keyword& keyword, const DataLine& line, std::size_t number, bool used) {
    for (std::size_t i = 0; i < line.fields.size(); ++i) {
      if (line.fields[i].empty()) continue;
      if (line.is_asked(i) || !used) {
        enter(line.where, keyword.title, field_name(i), used ? FieldFate::used : FieldFate::told);
        continue;
      }
      const auto idle = idle_fields().find(keyword.name);
      const bool is_idle_field = idle != idle_fields().end() && i >= idle->second;
      const bool refused = !is_idle_field && is_whole(keyword.name, number);
      enter(line.where, keyword.title, field_name(i), refused ? FieldFate::refused : FieldFate::told);
      tell(line.where, field_name(i) + " of " + keyword.title,
           is_idle_field ? "without effect on natural modes and linear statics"
           : refused     ? "it is not read, and may change the model"
                         : "the line has more fields than are read: this one is ignored",
           is_idle_field ? DeckNoteKind::unused
           : refused     ? DeckNoteKind::missing
                         : DeckNoteKind::doubtful);
    }
  }

  static std::string field_name(std::size_t index) { return "field " + std::to_string(index + 1); }

  void tell(const Where& where, const std::string& what, const std::string& consequence, DeckNoteKind kind) {
    notes_.add(problems_.location(where), what, consequence, kind);
  }

  DeckNotes& notes_;
  const Problems& problems_;
  Ledger* ledger_;
};

void settle_mesh(const Scope& scope, Sweep& sweep) {
  const auto enter = [&](const char* card, const char* field, std::size_t count, const Where& where) {
    sweep.enter(where, card, field, FieldFate::used, count);
  };
  if (!scope.nodes.labels.empty()) {
    enter("*NODE", "number", scope.nodes.labels.size(), scope.nodes.places.front());
    enter("*NODE", "coordinates", scope.nodes.coordinates.size(), scope.nodes.places.front());
  }
  if (!scope.elements.empty()) {
    enter("*ELEMENT", "number", scope.elements.size(), scope.elements.front().where);
    enter("*ELEMENT", "nodes", scope.connectivity.size(), scope.elements.front().where);
  }
}

}  // namespace

void forget_from(const DataLine& line, std::size_t first) {
  for (std::size_t i = first; i < line.fields.size(); ++i) line.forget(i);
}

void settle_ledger(const RawDeck& raw, DeckNotes& notes, const Problems& problems, Ledger* ledger) {
  Sweep sweep(notes, problems, ledger);
  const auto settle_scope = [&](const Scope& scope) {
    settle_mesh(scope, sweep);
    for (const auto& block : scope.blocks) sweep.settle(block);
  };
  settle_scope(raw.root);
  for (const auto& [name, part] : raw.parts) settle_scope(part);
  for (const auto& instance : raw.instances) settle_scope(instance.own);
  for (const auto& [name, material] : raw.materials)
    for (const auto& block : material.blocks) sweep.settle(block);
  for (const auto& step : raw.steps) {
    sweep.settle(step.keyword);
    sweep.settle_procedure(step.procedure_data, step.is_static() ? wants_case(raw, step) : true);
    for (const auto& block : step.blocks) sweep.settle(block);
  }
  for (const auto& keyword : raw.keywords) sweep.settle(keyword);
  for (const auto& matrix : raw.matrices)
    for (const auto& [field, text] : {std::pair{"stiffness file", &matrix.stiffness}, {"mass file", &matrix.mass}})
      sweep.enter(matrix.where, "*MATRIX ASSEMBLE", std::string("lines of the ") + field, FieldFate::used,
                  static_cast<std::size_t>(std::ranges::count(*text, '\n')));
  for (const auto& [title, where, is_lacking] : raw.passed_over)
    sweep.enter(where, title, "whole keyword", is_lacking ? FieldFate::refused : FieldFate::told);
  for (const auto& extra : raw.extra_fields) {
    sweep.enter(extra.where, extra.card, extra.field, FieldFate::told, extra.count);
    for (std::size_t i = 0; i < extra.count; ++i)
      notes.add(problems.location(extra.where), extra.field + " of " + extra.card, extra.consequence,
                DeckNoteKind::doubtful);
  }
}

}  // namespace kalfem::abaqus
