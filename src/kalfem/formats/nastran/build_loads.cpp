// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <set>

#include "kalfem/formats/nastran/model_building.hpp"
#include "kalfem/model/elements/beam_loads.hpp"
#include "kalfem/model/statics/loaded_faces.hpp"

namespace kalfem::nastran {
namespace {

/// Sets of loads with their factors: LOAD cards spelled out.
using LoadSets = std::map<Id, double>;

/// Makes load cases out of the cards of their sets. Cells are those of the cards, quadratic ones not yet replaced.
class LoadBuilder {
public:
  explicit LoadBuilder(Building& building) : building_(building), bulk_(building.bulk) {
    const auto& mesh = building.model.mesh;
    for (std::size_t i = 0; i < mesh.cells.size(); ++i) cells_[mesh.cells[i].id] = i;
  }

  /// `load`: number of a LOAD card or of a set of loads. The enforced motions of supports, SPC cards of `spcs`, act
  /// too. `supports`: instead of the model's. `asker`: "SUBCASE 2", which is told what cannot be read, and `otherwise`
  /// what to do without it.
  LoadCase build(const std::string& name, std::optional<Id> load, const std::set<Id>& spcs,
                 std::optional<std::vector<FixedNodes>> supports, const std::string& asker,
                 const std::string& otherwise) {
    LoadCase result{.name = name, .supports = std::move(supports), .of_deck = true};
    held_ = directions_of(result.supports ? *result.supports : building_.model.fixed);
    const LoadSets sets = load ? sets_of(*load) : LoadSets{};
    refuse_unread(sets, asker, otherwise);
    if (load) require_cards(*load, sets, asker);
    const auto factor_of = [&](Id set) {
      const auto found = sets.find(set);
      return found == sets.end() ? 0.0 : found->second;
    };
    for (const auto& card : bulk_.forces)
      if (const double factor = factor_of(card.set); factor != 0.0) add(card, factor, result);
    for (const auto& card : bulk_.pressures)
      if (const double factor = factor_of(card.set); factor != 0.0) add(card, factor, result);
    for (const auto& card : bulk_.face_pressures)
      if (const double factor = factor_of(card.set); factor != 0.0) add(card, factor, result);
    for (const auto& card : bulk_.beam_loads)
      if (const double factor = factor_of(card.set); factor != 0.0) add(card, factor, result);
    for (const auto& card : bulk_.rotations)
      if (const double factor = factor_of(card.set); factor != 0.0) add(card, factor, result);
    for (const auto& card : bulk_.gravities)
      if (const double factor = factor_of(card.set); factor != 0.0)
        result.gravity += factor * in_basic_axes(card.system, card.vector, Eigen::Vector3d::Zero(), card.where);
    for (const auto& card : bulk_.spcs)
      if (spcs.contains(card.set) && card.value != 0.0)
        impose(
            {.node = card.nodes.front().first, .components = card.components, .value = card.value, .where = card.where},
            1.0, result);
    for (const auto& card : bulk_.imposed)
      if (const double factor = factor_of(card.set); factor != 0.0) impose(card, factor, result);
    return result;
  }

  /// Sets that no LOAD card sums up, and the LOAD cards.
  [[nodiscard]] std::set<Id> top_sets() const {
    std::set<Id> sets = sets_with_cards();
    for (const auto& [sum, parts] : bulk_.load_sums)
      for (const auto& [part, factor] : parts) sets.erase(part);
    for (const auto& [sum, parts] : bulk_.load_sums) sets.insert(sum);
    return sets;
  }

private:
  [[nodiscard]] std::set<Id> sets_with_cards() const {
    std::set<Id> sets;
    const auto add_all = [&](const auto& cards) {
      for (const auto& card : cards) sets.insert(card.set);
    };
    add_all(bulk_.forces), add_all(bulk_.pressures), add_all(bulk_.face_pressures), add_all(bulk_.beam_loads);
    add_all(bulk_.rotations), add_all(bulk_.gravities), add_all(bulk_.imposed), add_all(bulk_.unread_loads);
    return sets;
  }

  static std::set<NodalDof> directions_of(const std::vector<FixedNodes>& supports) {
    std::set<NodalDof> held;
    for (const auto& support : supports)
      for (const auto node : support.nodes)
        for (int d = 0; d < 6; ++d)
          if (support.directions[static_cast<std::size_t>(d)]) held.insert({node, d});
    return held;
  }

  void refuse_unread(const LoadSets& sets, const std::string& asker, const std::string& otherwise) {
    for (const auto& card : bulk_.unread_loads)
      if (sets.contains(card.set))
        building_.files.problem(card.where, asker + " holds " + card.what + " of set " + std::to_string(card.set),
                                "kalfem does not read this load, and without it the load case would be another one",
                                otherwise);
  }

  /// A load case without its cards would be solved as one without load.
  void require_cards(Id load, const LoadSets& sets, const std::string& asker) {
    const auto present = sets_with_cards();
    if (std::ranges::none_of(sets, [&](const auto& set) { return present.contains(set.first); }))
      building_.files.problem(
          {}, asker + ": LOAD = " + std::to_string(load) + " selects a set without cards that are read",
          "read are FORCE, MOMENT, PLOAD, GRAV, RFORCE, SPCD and their kin", "add the set or correct the number");
  }

  [[nodiscard]] LoadSets sets_of(Id load) const {
    LoadSets sets;
    if (const auto sum = bulk_.load_sums.find(load); sum != bulk_.load_sums.end())
      for (const auto& [set, factor] : sum->second) sets[set] += factor;
    else
      sets[load] = 1.0;
    return sets;
  }

  [[nodiscard]] Eigen::Vector3d in_basic_axes(Id system, const Eigen::Vector3d& vector, const Eigen::Vector3d& at,
                                              const Place& where) const {
    const Frame* frame = building_.frames.find(system, where);
    return frame ? Eigen::Vector3d(frame->directions(at) * vector) : vector;
  }

  void add(const ForceCard& card, double factor, LoadCase& result) {
    const auto node = building_.node(card.node, card.is_moment ? "MOMENT" : "FORCE", card.where);
    if (node < 0) return;
    NodeLoad load{.node = node};
    (card.is_moment ? load.moment : load.force) =
        factor * (card.along.empty() ? in_basic_axes(card.system, card.vector, building_.place(node), card.where)
                                     : card.size * direction_of(card));
    result.loads.push_back(load);
  }

  /// Of FORCE1, FORCE2 and the moments; zero, with the problem noted, where their grid points give none.
  Eigen::Vector3d direction_of(const ForceCard& card) {
    std::vector<Eigen::Vector3d> sides;
    for (std::size_t i = 0; i + 1 < card.along.size(); i += 2) {
      const auto from = building_.node(card.along[i], "the direction of a load", card.where),
                 to = building_.node(card.along[i + 1], "the direction of a load", card.where);
      if (from < 0 || to < 0) return Eigen::Vector3d::Zero();
      sides.push_back(building_.place(to) - building_.place(from));
    }
    const Eigen::Vector3d direction = sides.size() == 1 ? sides[0] : Eigen::Vector3d(sides[0].cross(sides[1]));
    const double size = sides.size() == 1 ? 0.0 : sides[0].norm() * sides[1].norm();
    if (direction.norm() > 1e-9 * size) return direction.normalized();
    building_.files.problem(card.where, "the grid points of a load give no direction",
                            sides.size() == 1 ? "they are at one place" : "their two lines are parallel",
                            "name other grid points");
    return Eigen::Vector3d::Zero();
  }

  /// PLOAD acts along the normal by the right-hand rule, which is outward for a loaded face.
  void add(const FacePressureCard& card, double factor, LoadCase& result) {
    LoadedFace face{.shape = card.corners.size() == 3 ? CellShape::triangle3 : CellShape::quadrilateral4};
    for (std::size_t i = 0; i < card.corners.size(); ++i)
      if ((face.nodes[i] = building_.node(card.corners[i], "PLOAD", card.where)) < 0) return;
    result.pressures.push_back({{face}, -factor * card.pressure});
  }

  /// W = 2 pi A |R|, about the axis R through the grid point. The forces grow with W^2, so a factor of LOAD counts by
  /// its root.
  void add(const RotationCard& card, double factor, LoadCase& result) {
    const auto node = card.node == 0 ? -1 : building_.node(card.node, "RFORCE", card.where);
    if (card.node != 0 && node < 0) return;
    const Eigen::Vector3d about = node < 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(building_.place(node));
    const Eigen::Vector3d axis = in_basic_axes(card.system, card.revolutions, about, card.where);
    if (axis.isZero(0.0)) return;
    if (factor < 0.0 || result.rotation)
      return building_.files.problem(
          card.where,
          factor < 0.0 ? "RFORCE with a negative factor of a LOAD card" : "a second RFORCE in one load case",
          "a load case has one steady rotation", "describe the rotation under static.cases");
    result.rotation = Rotation{axis.normalized(), about, 2.0 * std::numbers::pi * axis.norm() * std::sqrt(factor)};
  }

  /// A beam by its cell: its region's property and its place in that.
  struct FoundBeam {
    const BeamProperty* property = nullptr;
    std::size_t place = 0;
  };
  [[nodiscard]] FoundBeam find_beam(Eigen::Index cell) const {
    for (const auto& [region, property] : building_.model.properties)
      if (const auto* beam = std::get_if<BeamProperty>(&property)) {
        const auto& own = building_.model.mesh.regions.at(region);
        if (const auto found = std::ranges::find(own, cell); found != own.end())
          return {beam, static_cast<std::size_t>(found - own.begin())};
      }
    return {};
  }

  /// PLOAD1: forces of the beam's own shapes, see beam_loads.hpp.
  void add(const BeamLoadCard& card, double factor, LoadCase& result) {
    const auto found = cells_.find(card.element);
    const auto cell = found == cells_.end() ? Eigen::Index(-1) : static_cast<Eigen::Index>(found->second);
    const auto [property, place] = cell < 0 ? FoundBeam{} : find_beam(cell);
    const std::string title = "PLOAD1 of element " + std::to_string(card.element);
    if (property == nullptr)
      return building_.files.problem(card.where, title + ": there is no CBAR or CBEAM of this number",
                                     "it acts on beams", "correct the number");
    const auto& mesh = building_.model.mesh;
    const Eigen::Matrix<double, 3, 2> ends =
        mesh.nodes(Eigen::all, mesh.nodes_of(mesh.cells[static_cast<std::size_t>(cell)]));
    const auto& placement = property->placement(place);
    const double length = (ends.col(1) + placement.offsets.col(1) - ends.col(0) - placement.offsets.col(0)).norm();
    LineLoad load{.places = card.places};
    for (double& at : load.places) {
      if (!card.fractions) at /= length;
      if (at < -1e-6 || at > 1.0 + 1e-6)
        return building_.files.problem(card.where, title + " acts beyond the element",
                                       "X1 and X2 go from 0 to its length, or to 1 with SCALE FR", "correct X1 and X2");
      at = std::clamp(at, 0.0, 1.0);
    }
    const Eigen::Matrix3d axes = beam_axes(ends, placement);
    const int of_three = card.direction % 3;
    const Eigen::Vector3d direction =
        card.element_axes ? Eigen::Vector3d(axes.row(of_three)) : Eigen::Vector3d(Eigen::Vector3d::Unit(of_three));
    for (Eigen::Index i = 0; i < 2; ++i)
      load.values.block<3, 1>(card.direction < 3 ? 0 : 3, i) =
          factor * card.values[static_cast<std::size_t>(i)] * direction;
    const double nu = building_.model.materials.at(property->material).poissons_ratio;
    result.beam_loads.push_back(
        {cell, card.concentrated
                   ? nodal_forces_of_point_load(ends, *property, placement, nu, load.places[0], load.values.col(0))
                   : nodal_forces_of_line_load(ends, *property, placement, nu, load)});
  }

  /// Pushes into solids, and along the normal of shells.
  void add(const PressureCard& card, double factor, LoadCase& result) {
    SurfacePressure into{{}, factor * card.pressure}, along{{}, -factor * card.pressure};
    for (const auto& range : card.elements) {
      if (range.single && !cells_.contains(range.first))
        building_.files.problem(
            card.where, "a pressure names element " + std::to_string(range.first) + ", which is no shell or solid",
            "it needs a face to act on", "correct its elements");
      for (auto cell = cells_.lower_bound(range.first); cell != cells_.end() && cell->first <= range.last; ++cell) {
        const bool is_shell = dimension(building_.model.mesh.cells[cell->second].shape) == 2;
        if (const auto face = loaded_face(card, cell->second)) (is_shell ? along : into).faces.push_back(*face);
      }
    }
    for (auto& pressure : {into, along})
      if (!pressure.faces.empty()) result.pressures.push_back(pressure);
    if (into.faces.empty() && along.faces.empty())
      building_.files.problem(card.where, "a pressure acts on no face",
                              "it needs a shell, or the corners of a solid's face", "correct its elements and G1, G3");
  }

  std::optional<LoadedFace> loaded_face(const PressureCard& card, std::size_t index) {
    const auto& mesh = building_.model.mesh;
    const auto& cell = mesh.cells[index];
    const auto faces = faces_of_cell(mesh, cell);
    if (dimension(cell.shape) == 2) return faces.front();
    if (card.first_corner == 0) return {};
    const auto first = building_.node(card.first_corner, "PLOAD4", card.where);
    const auto other = card.other_corner == 0 ? -1 : building_.node(card.other_corner, "PLOAD4", card.where);
    const bool is_tetrahedron = corner_count(cell.shape) == 4;
    for (const auto& face : faces) {
      const auto corners = face.nodes.begin() + corner_count(face.shape);
      const auto at = std::find(face.nodes.begin(), corners, first);
      if (at == corners) continue;
      const auto opposite =
          face.nodes[static_cast<std::size_t>((at - face.nodes.begin() + 2) % corner_count(face.shape))];
      const bool is_triangle = corner_count(face.shape) == 3;
      if (is_tetrahedron ? std::find(face.nodes.begin(), corners, other) == corners
          : is_triangle  ? other < 0 || std::find(face.nodes.begin(), corners, other) != corners
                         : opposite == other)
        return face;
    }
    return {};
  }

  void impose(const EnforcedCard& card, double factor, LoadCase& result) {
    const auto node = building_.node(card.node, "an enforced motion", card.where);
    if (node < 0) return;
    const auto local = building_.local_nodes.find(node);
    for (int d = 0; d < 6; ++d) {
      if (((card.components >> d) & 1u) == 0) continue;
      const NodalDof dof{local == building_.local_nodes.end() ? node : local->second, d};
      const auto same = std::ranges::find(result.imposed, dof, &ImposedMotion::dof);
      if (same == result.imposed.end())
        result.imposed.push_back({dof, factor * card.value, held_.contains(dof)});
      else
        same->value = factor * card.value;  // SPCD overrides the value of SPC
    }
  }

  Building& building_;
  BulkData& bulk_;
  std::map<std::int64_t, std::size_t> cells_;  ///< by the number of the element
  std::set<NodalDof> held_;                    ///< by supports
};

}  // namespace

namespace {

/// What a user does instead of a load case, or a preload, that kalfem cannot read.
constexpr const char* describe_instead =
    "choose another SUBCASE by `subcase` beside `deck`, or describe its loads under static.cases";
constexpr const char* state_preload =
    "in a case, choose a SUBCASE without STATSUB by `subcase` beside `deck`, and state the load case of `static` that "
    "is the `preload` of the substructure";

std::string title_of(const Subcase& subcase) { return "SUBCASE " + std::to_string(subcase.number); }

/// Refuses what a subcase asks for beside loads that kalfem reads: a structure other than the model's, or loads by
/// temperature and length. `otherwise`: the key that does without it.
bool can_solve(Building& building, const Subcase& subcase, const std::string& otherwise) {
  const auto& chosen = building.control.chosen;
  const auto refuse = [&](const std::string& what, const std::string& why, const std::string& fix) {
    building.files.problem(subcase.where, title_of(subcase) + ": " + what, why, fix);
    return false;
  };
  const std::string own =
      "state `subcase: " + std::to_string(subcase.number) + "` beside `deck` to solve this one, or " + otherwise;
  if (subcase.thermal_load && building.bulk.expands)
    return refuse("TEMPERATURE(LOAD) = " + std::to_string(*subcase.thermal_load), "thermal loads are not read",
                  otherwise);
  if (subcase.deform)
    return refuse("DEFORM = " + std::to_string(*subcase.deform), "initial deformations are not read", otherwise);
  if (subcase.mpc != chosen.mpc)
    return refuse("its MPC is another one than that of " + title_of(chosen),
                  "the load cases of one model share their constraints", own);
  if (subcase.stiffness != chosen.stiffness)
    return refuse("its K2GG is another one than that of " + title_of(chosen), "the load cases share one stiffness",
                  own);
  const auto temperature = subcase.material_temperature ? subcase.material_temperature : subcase.initial_temperature;
  if (!building.bulk.material_temperatures.empty() && !building.bulk.temperature &&
      temperature != building.control.material_temperature)
    return refuse("its materials have another temperature than those of " + title_of(chosen),
                  "the load cases share one stiffness", own + ", or give `temperature`");
  return true;
}

/// Whether the subcase has loads, read or not; one of METHOD, FREQUENCY or BOUNDARY conditions alone has none.
bool has_loads(const Building& building, const Subcase& subcase, const std::set<Id>& spcs) {
  const auto& cards = building.bulk.spcs;
  return subcase.load || subcase.deform || (subcase.thermal_load && building.bulk.expands) ||
         std::ranges::any_of(cards, [&](const SpcCard& card) { return card.value != 0.0 && spcs.contains(card.set); });
}

/// Nothing, and no problem either, where the subcase has no loads.
std::optional<LoadCase> load_case_of(Building& building, LoadBuilder& builder, const Subcase& subcase,
                                     const std::string& otherwise) {
  const bool same_supports = subcase.spc == building.control.chosen.spc;
  const auto spcs = same_supports ? building.supports : spc_sets(building, subcase.spc);
  if (!has_loads(building, subcase, spcs) || !can_solve(building, subcase, otherwise)) return std::nullopt;
  auto supports = same_supports ? std::nullopt : std::optional(supports_of(building, spcs));
  return builder.build("subcase" + std::to_string(subcase.number), subcase.load, spcs, std::move(supports),
                       title_of(subcase), otherwise);
}

}  // namespace

std::vector<LoadCase> build_load_cases(Building& building) {
  LoadBuilder builder(building);
  std::vector<LoadCase> cases;
  const auto& control = building.control;
  for (const auto& subcase : control.subcases) {
    if (building.stated_subcase && subcase.number != *building.stated_subcase) continue;
    if (subcase.combines)
      building.note(subcase.where, "SUBCOM and SYMCOM", "sums of other subcases' results are not formed",
                    DeckNoteKind::unused);
    else if (auto load_case = load_case_of(building, builder, subcase, describe_instead))
      cases.push_back(std::move(*load_case));
  }
  if (!control.is_present) {
    for (const Id set : builder.top_sets())
      cases.push_back(builder.build("load" + std::to_string(set), set, building.supports, {},
                                    "load case 'load" + std::to_string(set) + "'",
                                    "describe the loads under static.cases"));
    if (!building.bulk.temperatures.empty() && building.bulk.expands)
      building.note(building.bulk.temperatures.front().where, "temperatures without a case control that selects them",
                    "thermal loads are not read", DeckNoteKind::doubtful);
  }
  std::erase_if(cases, is_empty);
  return cases;
}

std::optional<LoadCase> build_preload(Building& building) {
  const auto& control = building.control;
  const Subcase* carried = control.preload();
  if (control.chosen.preload && carried == nullptr && control.solution_number() != 105)
    building.files.problem(control.chosen.preload_where,
                           "STATSUB = " + std::to_string(*control.chosen.preload) + " names no SUBCASE of the deck",
                           "the preload of the structure would be missing", "correct the number");
  if (carried == nullptr) return std::nullopt;
  LoadBuilder builder(building);
  auto load_case = load_case_of(building, builder, *carried, state_preload);
  if (!load_case && building.files.sound())
    building.files.problem(control.chosen.preload_where,
                           "STATSUB = " + std::to_string(carried->number) + ": " + title_of(*carried) + " has no load",
                           "the preload of the structure would be missing", state_preload);
  return load_case;
}

}  // namespace kalfem::nastran
