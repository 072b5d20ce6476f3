// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/deck_reader.hpp"

#include <algorithm>
#include <set>

#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

/// Keywords that CalculiX does not have, in most decks that were written for Abaqus.
bool is_of_abaqus(const Keyword& keyword) {
  static const std::set<std::string, std::less<>> names = {"PREPRINT", "PART", "ASSEMBLY", "INSTANCE"};
  return names.contains(keyword.name) || (keyword.name == "OUTPUT" && (keyword.has("FIELD") || keyword.has("HISTORY")));
}

/// Keywords that end with their class: only a note is left of them.
bool is_passed_over(KeywordUse use) {
  return use == KeywordUse::silent || use == KeywordUse::noted || use == KeywordUse::doubtful ||
         use == KeywordUse::changed || use == KeywordUse::lacking;
}

/// Follows the structure of a deck: parts, instances, materials and steps, and hands out the data.
class DeckReader {
public:
  DeckReader(DeckLines& lines, bool load_cases, DeckNotes& notes, Problems& problems)
      : lines_(lines), notes_(notes), problems_(problems), mesh_(deck_, lines, problems) {
    deck_.load_cases = load_cases;
  }

  RawDeck read() {
    Keyword keyword;
    warn_of_leading_data();
    while (lines_.next_keyword(keyword)) {
      deck_.from_abaqus = deck_.from_abaqus || is_of_abaqus(keyword);
      if (step_open_)
        read_in_step(keyword);
      else if (!read_structure(keyword) && !read_mesh(keyword))
        read_other(keyword);
    }
    check_ends();
    return std::move(deck_);
  }

private:
  void warn_of_leading_data();
  bool read_structure(const Keyword& keyword);
  bool read_mesh(const Keyword& keyword);
  void read_other(const Keyword& keyword);
  void read_in_step(const Keyword& keyword);
  void read_procedure(const Keyword& keyword);
  void begin_step(const Keyword& keyword);
  void begin_assembly(const Keyword& keyword);
  void begin_part(const Keyword& keyword);
  void begin_instance(const Keyword& keyword);
  void begin_material(const Keyword& keyword);
  void read_material_option(const Keyword& keyword);
  void read_matrix(const Keyword& keyword);
  Block read_block(const Keyword& keyword);
  void end(bool open, const Keyword& keyword);
  void check_last_lines();
  void check_ends();
  void note(const Keyword& keyword, const std::string& consequence, DeckNoteKind kind = DeckNoteKind::unused) {
    notes_.add(problems_.location(keyword.where), keyword.title, consequence, kind);
  }

  DeckLines& lines_;
  DeckNotes& notes_;
  Problems& problems_;
  RawDeck deck_;
  MeshReader mesh_;
  Scope* scope_ = &deck_.root;
  Where scope_start_;
  RawDeck::Material* material_ = nullptr;
  bool in_part_ = false, in_instance_ = false, in_assembly_ = false, step_open_ = false;
  int steps_ = 0;
};

// Data lines in front of the first keyword belong to nothing. Such a file is mostly no deck at all, so reading stops.
void DeckReader::warn_of_leading_data() {
  std::string_view line;
  if (lines_.next_data(line))
    problems_.fail(lines_.where(), "the deck begins with '" + to_string(line) + "'",
                   "a deck begins with a keyword (*NODE, ...)", "check that this is an Abaqus or CalculiX deck");
}

// Keywords that open or close a scope. *PART opens a scope of its own, *INSTANCE one that can hold further nodes and
// sets, *STEP starts the history. All closing keywords lead back to the deck's root and end the axes of *SYSTEM.
bool DeckReader::read_structure(const Keyword& given) {
  const std::string name = given.name;
  const bool is_named = name == "PART" || name == "INSTANCE" || name == "ASSEMBLY" || name == "MATERIAL";
  const Keyword& keyword = is_named ? deck_.keywords.emplace_back(given) : given;
  if (name == "PART") return begin_part(keyword), true;
  if (name == "INSTANCE") return begin_instance(keyword), true;
  if (name == "ASSEMBLY") return begin_assembly(keyword), true;
  if (name == "STEP") return begin_step(keyword), true;
  if (name == "MATERIAL") return begin_material(keyword), true;
  if (name == "ENDPART") {
    end(in_part_, keyword);
    in_part_ = false;
  } else if (name == "ENDINSTANCE") {
    end(in_instance_, keyword);
    in_instance_ = false;
  } else if (name == "ENDASSEMBLY") {
    end(in_assembly_, keyword);
    in_assembly_ = false;
  } else {
    return false;
  }
  scope_ = &deck_.root;
  mesh_.forget_system();
  return true;
}

void DeckReader::end(bool open, const Keyword& keyword) {
  if (!open)
    problems_.add(keyword.where, keyword.title + " ends a block that was not started", "",
                  "remove it or start the block");
}

void DeckReader::begin_assembly(const Keyword& keyword) {
  static_cast<void>(keyword.has("NAME"));  // nothing refers to it
  in_assembly_ = true;
  scope_start_ = keyword.where;
}

void DeckReader::begin_part(const Keyword& keyword) {
  const std::string name = keyword.get("NAME");
  if (in_part_ || in_instance_)
    problems_.fail(keyword.where, "*PART stands inside another part or instance", "the previous one is not closed",
                   "end it by *END PART");
  if (name.empty()) problems_.fail(keyword.where, "*PART has no NAME", "instances refer to it", "give it a name");
  const auto [place, is_new] = deck_.parts.try_emplace(upper_case(name));
  if (!is_new) problems_.fail(keyword.where, "there are two parts named '" + to_string(name) + "'", "", "rename one");
  place->second.name = name;
  scope_ = &place->second;
  scope_start_ = keyword.where;
  in_part_ = true;
  material_ = nullptr;
  mesh_.forget_system();
}

// The data lines of *INSTANCE place it: a translation, then a rotation. LIBRARY= refers to nodes of another analysis,
// which this deck does not contain.
void DeckReader::begin_instance(const Keyword& keyword) {
  if (in_part_ || in_instance_)
    problems_.fail(keyword.where, "*INSTANCE stands inside another part or instance", "the previous one is not closed",
                   "end it by *END INSTANCE");
  const std::string name = keyword.get("NAME");
  if (name.empty()) problems_.fail(keyword.where, "*INSTANCE has no NAME", "sets refer to it", "give it a name");
  for (const auto& other : deck_.instances)
    if (upper_case(other.name) == upper_case(name))
      problems_.fail(keyword.where, "there are two instances named '" + to_string(name) + "'", "", "rename one");
  if (keyword.has("LIBRARY"))
    problems_.fail(keyword.where, "the instance '" + to_string(name) + "' is imported from another analysis",
                   "its nodes and elements are not in the deck", "write the model into one deck");
  deck_.instances.push_back({name, keyword.get("PART"), keyword.where, {}, {}});
  auto& instance = deck_.instances.back();
  instance.own.name = name;
  for (std::string_view line; lines_.next_data(line);)
    instance.placement.push_back({lines_.where(), split_fields(line)});
  scope_ = nullptr;  // found anew below, since the list of instances grows
  in_instance_ = true;
  scope_start_ = keyword.where;
  material_ = nullptr;
  mesh_.forget_system();
}

void DeckReader::begin_material(const Keyword& keyword) {
  const std::string name = keyword.get("NAME");
  if (name.empty()) {
    problems_.add(keyword.where, "*MATERIAL has no NAME", "sections refer to it", "give it a name");
    return;
  }
  auto& material = deck_.materials[upper_case(name)];
  if (!material.name.empty())
    problems_.add(keyword.where, "there are two materials named '" + to_string(name) + "'", "", "rename one");
  material.name = name;
  material.where = keyword.where;
  material_ = &material;
}

void DeckReader::begin_step(const Keyword& keyword) {
  ++steps_;
  step_open_ = true;
  deck_.steps.push_back({.number = steps_, .keyword = keyword});
  scope_start_ = keyword.where;
}

bool DeckReader::read_mesh(const Keyword& given) {
  Scope& scope = in_instance_ ? deck_.instances.back().own : *scope_;
  const bool is_mesh = given.name == "NODE" || given.name == "ELEMENT" || given.name == "NSET" ||
                       given.name == "ELSET" || given.name == "SYSTEM";
  if (!is_mesh) return false;
  const Keyword& keyword = deck_.keywords.emplace_back(given);
  if (keyword.name == "NODE")
    mesh_.read_nodes(scope, keyword);
  else if (keyword.name == "ELEMENT")
    mesh_.read_elements(scope, keyword);
  else if (keyword.name == "NSET" || keyword.name == "ELSET")
    mesh_.read_set(scope, keyword, keyword.name == "NSET");
  else
    mesh_.read_system();
  return true;
}

// Takes the data lines up to the next keyword. INPUT= names a file whose lines are read in their place. A blank line
// is skipped, except in keywords whose lines are told apart by position: the first line of *SPRING is blank for
// SPRINGA, and that of the direction of *BEAM SECTION where the default holds.
Block DeckReader::read_block(const Keyword& keyword) {
  if (!keyword.get("INPUT").empty()) lines_.insert(keyword.get("INPUT"), keyword.where);
  static const std::set<std::string, std::less<>> with_blanks = {"SPRING", "DASHPOT", "BEAMSECTION",
                                                                 "BEAMGENERALSECTION"};
  const bool keep_blank = with_blanks.contains(keyword.name);
  Block block{keyword, {}};
  for (std::string_view line; keep_blank ? lines_.next_data_or_blank(line) : lines_.next_data(line);)
    block.lines.push_back({lines_.where(), split_fields(line)});
  return block;
}

// Sorts all other keywords by their class. Stored ones are kept as blocks and interpreted once the mesh is complete,
// since they may name sets that come later. An option, such as *KINEMATIC, completes the block before it. A stored
// keyword ends the present material. Ignored keywords leave a note whose weight follows from their effect; keywords
// without which the model would be wrong are problems.
void DeckReader::read_other(const Keyword& keyword) {
  auto [use, consequence] = classify(keyword.name);
  if (keyword.name == "INITIALCONDITIONS") {
    if (keyword.word("TYPE").starts_with("TEMP")) use = KeywordUse::stored;
    if (keyword.word("TYPE") == "STRESS") {
      deck_.initial_stress = keyword.where;
      return note(keyword, "initial stresses, which may stiffen the model, are not read", DeckNoteKind::doubtful);
    }
  }
  Scope& scope = in_instance_ ? deck_.instances.back().own : *scope_;
  if (keyword.name == "MATRIXASSEMBLE") return read_matrix(keyword);
  if (is_passed_over(use)) deck_.passed_over.push_back({keyword.title, keyword.where, use == KeywordUse::lacking});
  switch (use) {
    case KeywordUse::stored: {
      material_ = nullptr;
      scope.blocks.push_back(read_block(keyword));
      break;
    }
    case KeywordUse::option: {
      if (scope.blocks.empty())
        problems_.add(keyword.where, keyword.title + " has no keyword to belong to",
                      "it must follow the keyword that it completes");
      else
        scope.blocks.back().options.push_back(read_block(keyword));
      break;
    }
    case KeywordUse::material_option:
      read_material_option(keyword);
      break;
    case KeywordUse::silent:
      break;
    case KeywordUse::noted:
      if (keyword.name == "EXPANSION") deck_.expands = true;
      note(keyword, consequence);
      break;
    case KeywordUse::doubtful:
      note(keyword, consequence, DeckNoteKind::doubtful);
      break;
    case KeywordUse::changed:
      note(keyword, consequence, DeckNoteKind::changed);
      break;
    case KeywordUse::procedure:
    case KeywordUse::load:
      problems_.add(keyword.where, keyword.title + " stands outside of a step", "it belongs to one",
                    "put *STEP before it");
      break;
    case KeywordUse::lacking:
      note(keyword, consequence, DeckNoteKind::missing);
      break;
    case KeywordUse::missing:
      problems_.add(keyword.where, keyword.title + " is not read", consequence,
                    "write the model without it or remove the keyword");
      break;
  }
}

void DeckReader::read_material_option(const Keyword& keyword) {
  if (!material_)
    problems_.add(keyword.where, keyword.title + " stands outside of a material", "",
                  "put *MATERIAL, NAME=... before it");
  else
    material_->blocks.push_back(read_block(keyword));
}

void DeckReader::read_matrix(const Keyword& given) {
  const Keyword& keyword = deck_.keywords.emplace_back(given);
  RawDeck::Matrix matrix{keyword.get("NAME"), keyword.where, {}, {}};
  if (keyword.get("STIFFNESSFILE").empty() && keyword.get("MASSFILE").empty())
    problems_.fail(keyword.where, "*MATRIX ASSEMBLE names no file", "", "give STIFFNESSFILE= and MASSFILE=");
  if (!keyword.get("STIFFNESSFILE").empty())
    matrix.stiffness = lines_.load(keyword.get("STIFFNESSFILE"), keyword.where);
  if (!keyword.get("MASSFILE").empty()) matrix.mass = lines_.load(keyword.get("MASSFILE"), keyword.where);
  deck_.matrices.push_back(std::move(matrix));
}

// A step is kept as its procedure and what it holds and loads; SupportHistory, MaterialTemperature and LoadReader give
// these their meaning. A keyword that would change the model from here on is a problem: one model serves all steps.
void DeckReader::read_in_step(const Keyword& keyword) {
  auto& step = deck_.steps.back();
  const auto [use, consequence] = classify(keyword.name);
  if (is_passed_over(use)) deck_.passed_over.push_back({keyword.title, keyword.where, use == KeywordUse::lacking});
  if (keyword.name == "ENDSTEP") {
    step_open_ = false;
  } else if (keyword.name == "STEP") {
    problems_.add(keyword.where, "*STEP stands inside another step", "the previous one is not closed",
                  "end it by *END STEP");
  } else if (keyword.name == "NSET" || keyword.name == "ELSET") {
    mesh_.read_set(deck_.root, deck_.keywords.emplace_back(keyword), keyword.name == "NSET");
  } else if (use == KeywordUse::procedure) {
    read_procedure(keyword);
  } else if (keyword.name == "BOUNDARY" || use == KeywordUse::load) {
    step.blocks.push_back(read_block(keyword));
  } else if (use == KeywordUse::silent || keyword.name == "AMPLITUDE") {
    if (keyword.name == "AMPLITUDE") deck_.root.blocks.push_back(read_block(keyword));
  } else if (use == KeywordUse::noted) {
    note(keyword, consequence);
  } else if (use == KeywordUse::doubtful) {
    note(keyword, consequence, DeckNoteKind::doubtful);
  } else if (use == KeywordUse::changed) {
    note(keyword, consequence, DeckNoteKind::changed);
  } else if (use == KeywordUse::lacking) {
    note(keyword, consequence, DeckNoteKind::missing);
  } else {
    problems_.add(keyword.where, keyword.title + " stands in step " + std::to_string(steps_),
                  "one model serves all steps, and this keyword would change it from here on",
                  "write what it means into the model, before the first step");
  }
}

// The first line of *STATIC: the first increment and the time of the step. *DYNAMIC, EXPLICIT of CalculiX scales masses
// up to the time increment that its third field states.
void DeckReader::read_procedure(const Keyword& keyword) {
  auto& step = deck_.steps.back();
  const Block block = read_block(keyword);
  if (!step.procedure.empty()) {
    deck_.passed_over.push_back({keyword.title, keyword.where});
    return note(keyword, "the step has a procedure already: this one is not run", DeckNoteKind::doubtful);
  }
  step.procedure = keyword.name;
  if (step.is_static() || keyword.name == "FREQUENCY") {
    step.procedure_data = block;
    if (!step.is_static()) return;
    const DataLine& line = line_of(step.procedure_data, 0);
    step.period = number_or(line, 1, 1.0, "the time of the step", problems_);
    line.forget(1);  // amplitudes alone use it
    return;
  }
  deck_.passed_over.push_back({keyword.title, keyword.where});
  note(keyword, "steps of this kind are not run; kalfem finds natural modes and solves static steps");
  if (keyword.name == "DYNAMIC" && keyword.has("EXPLICIT") && !line_of(block, 0).field(2).empty())
    notes_.add(problems_.location(keyword.where), "*DYNAMIC, EXPLICIT with a least time increment",
               "masses are those of the densities, not scaled up for the increment", DeckNoteKind::changed);
}

/// A data line without a line end is the last of a file that may be cut off inside a number.
void DeckReader::check_last_lines() {
  for (const auto& [where, in_deck_itself] : lines_.open_ends())
    if (in_deck_itself)
      problems_.add(where, "the last data line of the deck has no line end",
                    "the file may be truncated: the last number may lack digits",
                    "export the deck again, or add a line end if the line is complete");
    else
      notes_.add(problems_.location(where), "an included file whose last line has no line end",
                 "if the file is truncated, its last number lacks digits", DeckNoteKind::doubtful);
}

// A block that is still open at the end is the most certain sign of a truncated deck.
void DeckReader::check_ends() {
  check_last_lines();
  const auto open = [&](bool is_open, const char* begin, const char* finish) {
    if (is_open)
      problems_.add(scope_start_, std::string(begin) + " is not closed", "the deck may be truncated",
                    std::string("end it by ") + finish);
  };
  open(in_part_, "*PART", "*END PART");
  open(in_instance_, "*INSTANCE", "*END INSTANCE");
  open(in_assembly_, "*ASSEMBLY", "*END ASSEMBLY");
  open(step_open_, "*STEP", "*END STEP");
}

}  // namespace

RawDeck read_deck(DeckLines& lines, bool load_cases, DeckNotes& notes, Problems& problems) {
  return DeckReader(lines, load_cases, notes, problems).read();
}

}  // namespace kalfem::abaqus
