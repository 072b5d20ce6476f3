// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran.hpp"

#include <algorithm>
#include <cctype>
#include <limits>
#include <map>

#include "kalfem/formats/nastran/card_readers.hpp"
#include "kalfem/formats/nastran/card_stream.hpp"
#include "kalfem/formats/nastran/case_control.hpp"
#include "kalfem/formats/nastran/material_temperatures.hpp"
#include "kalfem/formats/nastran/model_building.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/mesh/split_quadratic_shells.hpp"

namespace kalfem {
namespace nastran {
namespace {

/// Leads each line to the part of the deck that it stands in.
class DeckReader {
public:
  DeckReader(DeckFiles& files, DeckNotes& notes, BulkData& bulk, CaseControl& control,
             std::optional<std::int64_t> subcase, Ledger* ledger)
      : subcase_(subcase),
        files_(files),
        notes_(notes),
        control_(control),
        reading_{bulk, notes, files, ledger},
        cards_(files, [this](const Card& card) { read_card(card, reading_); }) {}

  void read(DeckLines& lines) {
    const bool has_control = has_case_control(lines.main_text());
    has_control ? void(part_ = Part::control) : start_bulk();
    Place last{};
    bool goes_on = true;
    while (goes_on) {
      const auto line = lines.next();
      if (!line) break;
      last = line->place;
      goes_on = read(*line);
    }
    cards_.finish();
    if (goes_on && part_ != Part::control) tell_missing_end(has_control, last);
    for (const auto& place : lines.open_ends())
      notes_.add(files_.location(place), "an included file whose last line has no line end",
                 "if the file is truncated, its last number and all that followed are missing", DeckNoteKind::doubtful);
    if (part_ == Part::control)
      files_.problem({}, "the file has no BEGIN BULK", "it marks the start of the bulk data",
                     "put it before the first card");
  }

private:
  enum class Part { control, bulk, other };

  /// The case control is read: of the bulk data, what it needs.
  void start_bulk() {
    part_ = Part::bulk;
    const bool known = control_.choose(subcase_);
    if (!known)
      files_.problem({}, "the deck has no SUBCASE " + std::to_string(*subcase_), "`subcase` selects one of its own",
                     "correct the number");
    if (control_.preload()) reading_.bulk.with_loads = true;
  }

  /// Whether the deck goes on.
  bool read(const DeckLine& line) {
    if (const auto word = upper_case(trimmed(line.text).substr(0, 7)); word == "ENDDATA")
      return false;
    else if (word.starts_with("BEGIN")) {
      begin(line);
      return true;
    }
    if (part_ == Part::control) {
      control_.read(line.text, line.place);
      const bool selects = !control_.subcases.empty() && (control_.subcases.back().spc || control_.subcases.back().mpc);
      control_.is_present = control_.is_present || upper_case(trimmed(line.text)) == "CEND" || selects;
    } else if (part_ == Part::bulk) {
      cards_.line(line);
    }
    return true;
  }

  /// A deck with a BEGIN BULK has its ENDDATA unless it is cut off. Bulk data alone, as files that are included
  /// elsewhere, may do without.
  void tell_missing_end(bool has_control, const Place& last) {
    if (has_control) files_.set_open_end(last);
    if (has_control)
      notes_.add(files_.location(last), "ENDDATA",
                 "the deck may be truncated: supports, masses or elements may be missing", DeckNoteKind::missing);
    else
      notes_.add(files_.location(last), "bulk data without ENDDATA",
                 "if the file is truncated, supports, masses or elements are missing", DeckNoteKind::doubtful);
  }

  void begin(const DeckLine& line) {
    if (begins_bulk(line.text)) {
      start_bulk();
      const auto chooses_nsm = [](const auto& command) { return command.first == "NSM"; };
      reading_.chooses_nsm = !control_.is_present || std::ranges::any_of(control_.unused, chooses_nsm);
      return;
    }
    part_ = Part::other;
    const std::string part(line.place.file > 0 ? "BEGIN" : trimmed(line.text));
    notes_.add(files_.location(line.place), part,
               "this part of the bulk data is not supported: its stiffness and mass are missing",
               DeckNoteKind::missing);
  }

  std::optional<std::int64_t> subcase_;
  DeckFiles& files_;
  DeckNotes& notes_;
  CaseControl& control_;
  Reading reading_;
  CardStream cards_;
  Part part_ = Part::control;
};

/// Defaults of GRDSET for the fields that were blank.
void fill_grid_defaults(BulkData& bulk) {
  for (auto& grid : bulk.grids) {
    if (grid.motion_system == scalar_point) continue;
    if (grid.position_system == -2) grid.position_system = bulk.grid_defaults.position_system;
    if (grid.motion_system == -2) grid.motion_system = bulk.grid_defaults.motion_system;
    if (grid.held == ~0u) grid.held = bulk.grid_defaults.held;
  }
}

/// A grid point may stand twice with the same content; the second is dropped.
void drop_repeated_grids(BulkData& bulk, DeckFiles& files) {
  std::vector<std::int64_t> ids(bulk.grids.size());
  std::ranges::transform(bulk.grids, ids.begin(), [](const Grid& grid) { return grid.id; });
  const NumberLookup lookup(ids);
  std::vector<bool> drop(bulk.grids.size(), false);
  for (const auto& [later, earlier] : lookup.repeated()) {
    const auto& one = bulk.grids[static_cast<std::size_t>(earlier)];
    const auto& two = bulk.grids[static_cast<std::size_t>(later)];
    drop[static_cast<std::size_t>(later)] = true;
    if (one.place != two.place || one.position_system != two.position_system ||
        one.motion_system != two.motion_system || one.held != two.held)
      files.problem(two.where, "grid point " + std::to_string(two.id) + " is defined twice",
                    "first in line " + std::to_string(one.where.line), "remove one of them");
  }
  std::size_t index = 0;
  std::erase_if(bulk.grids, [&](const Grid&) { return drop[index++]; });
}

// Numbers of elements with stiffness are unique, and so are those of masses and of rigid elements among themselves.
void check_element_numbers(BulkData& bulk, DeckFiles& files) {
  auto& numbers = bulk.element_numbers;
  const auto key = [](const BulkData::ElementNumber& item) { return std::pair(item.kind, item.id); };
  std::ranges::stable_sort(numbers, {}, key);
  for (std::size_t i = 1; i < numbers.size(); ++i)
    if (key(numbers[i]) == key(numbers[i - 1]))
      files.problem(numbers[i].where, "element " + std::to_string(numbers[i].id) + " is defined twice",
                    "first in line " + std::to_string(numbers[i - 1].where.line), "renumber one of them");
  numbers = {};
}

void build_nodes(const BulkData& bulk, FiniteElementModel& model) {
  model.mesh.nodes.resize(3, static_cast<Eigen::Index>(bulk.grids.size()));
  for (std::size_t i = 0; i < bulk.grids.size(); ++i) {
    model.mesh.nodes.col(static_cast<Eigen::Index>(i)) = bulk.grids[i].place;
    if (bulk.grids[i].motion_system == scalar_point)
      model.mesh.node_sets[scalar_points].push_back(static_cast<Eigen::Index>(i));
  }
}

void check_extent(const FiniteElementModel& model, DeckFiles& files) {
  if (!model.mesh.nodes.allFinite())
    files.problem({}, "a grid point has a position that is not finite", "its coordinates are too large",
                  "correct them");
}

// Elements first, then masses on their nodes, then constraints. AUTOSPC and K6ROT need the whole model and come last;
// quadratic shells are split between them.
void build_model(Building& building, const DeckOptions& options, Deck& deck) {
  Materials materials(building);
  build_shells(building, materials);
  build_shear_panels(building, materials);
  build_solids(building, materials);
  build_beams(building, materials);
  build_rods(building, materials);
  build_scalars(building);
  build_bushes(building);
  build_masses(building);
  build_direct_matrices(building);
  note_damped_elements(building);
  build_constraints(building);
  if (options.load_cases) deck.load_cases = build_load_cases(building);
  deck.preload = build_preload(building);
  const int solution = building.control.solution_number();
  deck.is_static_analysis = solution == 101 || solution == 1;
  building.files.raise();
  OtherSupports others;
  for (auto& load_case : deck.load_cases)
    if (load_case.supports) others.push_back(&*load_case.supports);
  if (deck.preload && deck.preload->supports) others.push_back(&*deck.preload->supports);
  apply_autospc(building, others);
  keep_free_twist(building);
  replace_quadratic(building.model);
  apply_k6rot(building, others);
}

/// Commands in which a subcase means another structure than the chosen one: "SPC and MPC". Subcases without METHOD
/// mean none beside one that has it.
std::string differences(const Subcase& each, const Subcase& chosen) {
  std::vector<std::string> names;
  if (each.combines || (chosen.method && !each.method)) return "";
  if (each.spc != chosen.spc) names.emplace_back("SPC");
  if (each.mpc != chosen.mpc) names.emplace_back("MPC");
  if (each.stiffness != chosen.stiffness) names.emplace_back("K2GG");
  if (each.mass != chosen.mass) names.emplace_back("M2GG");
  if (each.damping != chosen.damping) names.emplace_back("B2GG");
  if (each.method && each.preload != chosen.preload) names.emplace_back("STATSUB");
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

/// Subcases that differ in what makes the structure: one of them must be chosen. Load cases have their own supports.
void note_other_structures(const CaseControl& control, const DeckOptions& options, DeckNotes& notes,
                           const DeckFiles& files) {
  const std::string chosen = "SUBCASE " + std::to_string(control.chosen.number);
  for (const auto& each : control.subcases) {
    const std::string number = std::to_string(each.number);
    if (const auto names = differences(each, control.chosen); !names.empty())
      notes.add(files.location(each.where), "the " + names + " of SUBCASE " + number,
                "the model has the structure of " + chosen + (options.load_cases ? " in its natural modes" : "") +
                    "; `subcase: " + number + "` beside `deck`, or --subcase " + number +
                    " of a deck alone, chooses this one",
                options.load_cases ? DeckNoteKind::doubtful : DeckNoteKind::missing);
  }
}

void note_solution(const CaseControl& control, DeckNotes& notes, const DeckFiles& files) {
  static const std::map<int, const char*> analyses = {{101, "statics"},
                                                      {105, "buckling"},
                                                      {106, "nonlinear statics"},
                                                      {107, "complex eigenvalues"},
                                                      {108, "frequency response"},
                                                      {109, "transient response"},
                                                      {110, "complex eigenvalues"},
                                                      {111, "frequency response"},
                                                      {112, "transient response"},
                                                      {129, "nonlinear transient response"},
                                                      {144, "static aeroelasticity"},
                                                      {145, "flutter"},
                                                      {146, "aeroelastic response"},
                                                      {153, "heat transfer"},
                                                      {159, "transient heat transfer"},
                                                      {200, "optimisation"},
                                                      {400, "nonlinear analysis"},
                                                      {600, "nonlinear analysis"},
                                                      {1, "statics"},
                                                      {5, "buckling"}};
  const int number = control.solution_number();
  if (control.solution.empty() || number == 103 || number == 3) return;
  const auto known = analyses.find(number);
  notes.add(files.location(control.solution_where),
            "SOL " + control.solution + (known == analyses.end() ? "" : std::string(" (") + known->second + ")"),
            number == 101 || number == 1
                ? "the structure is read, and its load cases where a case has `static` with `deck_cases: true`"
                : "this analysis is not run: the structure is read, and static load cases where a case has `static` "
                  "with `deck_cases: true`",
            DeckNoteKind::unused);
}

void note_case_control(const CaseControl& control, const DeckOptions& options, DeckNotes& notes,
                       const DeckFiles& files) {
  const bool is_static = control.solution_number() == 101 || control.solution_number() == 1;
  if (!(options.load_cases && is_static)) note_solution(control, notes, files);
  if (!options.subcase) note_other_structures(control, options, notes, files);
  for (const auto& [command, place] : control.unused) {
    if (command == "NSM") continue;  // its cards tell what is missing
    notes.add(files.location(place), command, "what this case control command adds is missing", DeckNoteKind::missing);
  }
}

}  // namespace
}  // namespace nastran

// Steps: read all cards, since defaults and coordinate systems may stand behind the cards that need them; fill in
// defaults; check numbers; resolve coordinate systems and with them the places; build the model.
Deck parse_nastran(std::string content, const std::string& source, const NastranIncludes& includes,
                   const DeckOptions& options) {
  using namespace nastran;
  Deck deck;
  DeckNotes notes;
  DeckFiles files;
  BulkData bulk;
  bulk.temperature = options.temperature;
  bulk.with_loads = options.load_cases;
  CaseControl control;
  Ledger ledger;
  {
    DeckLines lines(std::move(content), source, includes, files);
    DeckReader(files, notes, bulk, control, options.subcase, options.ledger ? &ledger : nullptr).read(lines);
  }
  note_case_control(control, options, notes, files);
  apply_temperature(bulk, control, files, notes);
  fill_grid_defaults(bulk);
  drop_repeated_grids(bulk, files);
  check_element_numbers(bulk, files);

  auto& mesh = deck.model.mesh;
  deck.model.name = std::filesystem::path(source).stem().string();
  deck.model.mass_kind = bulk.coupled_mass ? MassKind::consistent : MassKind::lumped;
  mesh.source = source;
  mesh.node_ids.resize(bulk.grids.size());
  std::ranges::transform(bulk.grids, mesh.node_ids.begin(), [](const Grid& grid) { return grid.id; });
  const NumberLookup nodes(mesh.node_ids);
  const Frames frames(bulk, nodes, files);
  build_nodes(bulk, deck.model);
  check_extent(deck.model, files);
  if (bulk.grids.empty() && files.sound())
    files.problem({}, "the deck has no grid points", "it contains no structure", "check that it is a bulk data deck");
  files.raise();
  Building building{bulk, control, nodes, frames, files, notes, deck.model, options.subcase};
  build_model(building, options, deck);
  deck.notes = notes.take();
  deck.ledger = ledger.take();
  return deck;
}

Deck read_nastran(const std::filesystem::path& file, const DeckOptions& options) {
  return parse_nastran(
      read_text(file), file.string(), [](const std::filesystem::path& path) { return read_text(path); }, options);
}

}  // namespace kalfem
