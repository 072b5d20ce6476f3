#include "kalfem/formats/nastran.hpp"

#include <algorithm>
#include <cctype>
#include <limits>

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

/// Whether a line of the text, apart from blanks before it, begins with this word in any case.
bool has_line_with(std::string_view text, std::string_view word) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const auto line = trimmed(text.substr(at, end - at));
    if (line.size() >= word.size() && upper_case(line.substr(0, word.size())) == word) return true;
    at = end + 1;
  }
  return false;
}

/// Leads each line to the part of the deck that it stands in.
class DeckReader {
public:
  DeckReader(DeckFiles& files, DeckNotes& notes, BulkData& bulk, CaseControl& control)
      : files_(files),
        notes_(notes),
        control_(control),
        reading_{bulk, notes, files},
        cards_(files, [this](const Card& card) { read_card(card, reading_); }) {}

  void read(DeckLines& lines) {
    const bool has_control = has_line_with(lines.main_text(), "CEND") || has_line_with(lines.main_text(), "BEGIN");
    part_ = has_control ? Part::control : Part::bulk;
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
      control_.is_present =
          control_.is_present || upper_case(trimmed(line.text)) == "CEND" || control_.spc || control_.mpc;
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
      part_ = Part::bulk;
      return;
    }
    part_ = Part::other;
    const std::string part(line.place.file > 0 ? "BEGIN" : trimmed(line.text));
    notes_.add(files_.location(line.place), part,
               "this part of the bulk data is not supported: its stiffness and mass are missing",
               DeckNoteKind::missing);
  }

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

// Element numbers are unique over all kinds of elements, as regions and messages name elements by them.
void check_element_ids(BulkData& bulk, DeckFiles& files) {
  auto& ids = bulk.element_ids;
  std::ranges::stable_sort(ids, {}, [](const auto& item) { return item.first; });
  for (std::size_t i = 1; i < ids.size(); ++i)
    if (ids[i].first == ids[i - 1].first)
      files.problem(ids[i].second, "element " + std::to_string(ids[i].first) + " is defined twice",
                    "first in line " + std::to_string(ids[i - 1].second.line), "renumber one of them");
  ids = {};
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
void build_model(Building& building, std::vector<LoadCase>& load_cases) {
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
  build_constraints(building);
  if (building.bulk.with_loads) load_cases = build_load_cases(building);
  building.files.raise();
  apply_autospc(building);
  replace_quadratic(building.model);
  apply_k6rot(building);
}

void note_case_control(const CaseControl& control, DeckNotes& notes, const DeckFiles& files) {
  if (control.more_subcases)
    notes.add(files.location(control.second_subcase), "further SUBCASEs", "the first one selects SPC and MPC",
              DeckNoteKind::doubtful);
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
  {
    DeckLines lines(std::move(content), source, includes, files);
    DeckReader(files, notes, bulk, control).read(lines);
  }
  note_case_control(control, notes, files);
  apply_temperature(bulk, control, files, notes);
  fill_grid_defaults(bulk);
  drop_repeated_grids(bulk, files);
  check_element_ids(bulk, files);

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
  Building building{bulk, control, nodes, frames, files, notes, deck.model};
  build_model(building, deck.load_cases);
  deck.notes = notes.take();
  return deck;
}

Deck read_nastran(const std::filesystem::path& file, const DeckOptions& options) {
  return parse_nastran(
      read_text(file), file.string(), [](const std::filesystem::path& path) { return read_text(path); }, options);
}

}  // namespace kalfem
