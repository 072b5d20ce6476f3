// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus.hpp"

#include <algorithm>
#include <set>

#include "kalfem/formats/abaqus/deck_reader.hpp"
#include "kalfem/formats/abaqus/elements.hpp"
#include "kalfem/formats/abaqus/kinematics.hpp"
#include "kalfem/formats/abaqus/ledger_sweep.hpp"
#include "kalfem/formats/abaqus/load_cases.hpp"
#include "kalfem/formats/held_turns.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/model/mesh/split_quadratic_shells.hpp"

namespace kalfem {

namespace {

using namespace abaqus;

/// NAME, NAME.2, NAME.3 ... for items of one name.
template <typename Item>
void make_names_unique(std::vector<Item>& items) {
  std::set<std::string> taken;
  std::map<std::string, int> count;
  for (auto& item : items) {
    const std::string base = item.name;
    while (!taken.insert(item.name).second)
      item.name = base + "." + std::to_string(++count.try_emplace(base, 1).first->second);
  }
}

/// Quadratic shells and beams become linear ones.
void replace_quadratic_cells(PlacedDeck& deck, FiniteElementModel& model) {
  bool any = false;
  for (const auto& element : deck.elements) {
    const auto& type = deck.type_of(element);
    if (element.cell < 0 || type.family == Family::solid || node_count(type.shape) == corner_count(type.shape))
      continue;
    any = true;
    deck.notes.add(
        deck.problems.location(element.raw->where), "element type " + deck.type_name(element),
        type.family == Family::beam ? "each is replaced by two linear beams" : "each is replaced by four linear shells",
        DeckNoteKind::changed);
  }
  if (any) replace_quadratic(model);
}

/// Nodes whose turn about the normal supports hold through local nodes, which load cases move, are `separate`.
void find_held_through_local_nodes(const PlacedDeck& deck, const std::vector<FixedNodes>& supports,
                                   const std::vector<NodalSurface>& surfaces, std::vector<bool>& separate) {
  std::map<Eigen::Index, std::set<int>> held;
  for (const auto& support : supports)
    for (const auto node : support.nodes)
      for (int d = 0; d < 6; ++d)
        if (support.directions[static_cast<std::size_t>(d)]) held[node].insert(d);
  for (const auto& [node, local] : deck.local_nodes) {
    const auto& surface = surfaces[static_cast<std::size_t>(node)];
    if (!surface.is_surface() || !held.contains(local)) continue;
    const Eigen::Vector3d normal = surface.normal.normalized();
    bool turns = false, in_plane = false;
    for (const int d : held.at(local)) {
      const double along = std::abs(deck.mesh.axes.at(local).col(d % 3).dot(normal));
      (d < 3 ? in_plane : turns) |= d < 3 ? along < 1.0 - 1e-6 : along > 1e-6;
    }
    if (turns && !in_plane) separate[static_cast<std::size_t>(node)] = true;
  }
}

/// Of the supports of a load case, and of the preloads that it is solved with: releases those along the normal; nodes
/// that are held along other axes are `separate`.
void release_in_load_case(const PlacedDeck& deck, FiniteElementModel& model, const std::vector<NodalSurface>& surfaces,
                          const std::vector<bool>& turned, LoadCase& load_case, std::vector<bool>& separate) {
  for (auto& carried : load_case.preload) release_in_load_case(deck, model, surfaces, turned, carried, separate);
  if (!load_case.supports) return;
  find_held_through_local_nodes(deck, *load_case.supports, surfaces, separate);
  std::swap(model.fixed, *load_case.supports);
  std::vector<NodalDof> along;
  for (const auto& dof : held_drilling(model, surfaces))
    if (const auto node = static_cast<std::size_t>(dof.node); !turned[node] && is_along_normal(surfaces, dof))
      along.push_back(dof);
    else
      separate[node] = true;
  release(model, along);
  std::swap(model.fixed, *load_case.supports);
}

/// Abaqus and CalculiX give shells next to no stiffness against turns about their normal, so that decks may hold these
/// turns everywhere. Here they follow the turn of the surface, and to hold them would hold the surface itself. Where
/// single load cases hold them along oblique axes, the shells get nodes of their own, with next to no stiffness between
/// both turns: that of Nastran's K6ROT = 100.
void release_held_rotations(PlacedDeck& deck, Deck& result) {
  FiniteElementModel& model = result.model;
  const auto surfaces = nodal_surfaces(model);
  const auto turned = turned_by_others(model);
  std::vector<bool> separate(surfaces.size(), false);
  std::size_t count = release_turns_about_normal(model, surfaces, turned);
  find_held_through_local_nodes(deck, model.fixed, surfaces, separate);
  for (auto& load_case : result.load_cases) release_in_load_case(deck, model, surfaces, turned, load_case, separate);
  if (result.preload) release_in_load_case(deck, model, surfaces, turned, *result.preload, separate);
  const auto own = separate_shells(model, surfaces, separate);
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (own[i] < 0) continue;
    ++count;
    model.joints.push_back({.name = "drilling",
                            .deformation = turn_between(static_cast<Eigen::Index>(i), own[i], surfaces[i]),
                            .stiffness = 1e-4 * surfaces[i].shear_stiffness});
  }
  if (count == 0) return;
  deck.notes.add({}, "fixed rotations of shells about their normal",
                 "at " + std::to_string(count) + " nodes these rotations are left free, as in Abaqus and CalculiX",
                 DeckNoteKind::changed);
}

/// The load case that is the deck's own preload; without wanted load cases it is the only one.
void take_preload(const RawDeck& raw, Deck& result) {
  if (const auto* step = preload_step(raw))
    for (const auto& load_case : result.load_cases)
      if (load_case.name == step->name()) result.preload = load_case;
  if (!raw.load_cases) result.load_cases.clear();
  result.is_static_analysis =
      !raw.steps.empty() && std::ranges::all_of(raw.steps, [](const auto& step) { return step.is_static(); });
}

// Order: regions and point elements, then constraints and supports, which motions.store() reduces and stores together.
// Steps that change cells follow, when no keyword refers to the elements any more.
void build_model(const RawDeck& raw, bool with_ledger, DeckNotes& notes, Problems& problems, Deck& result,
                 DeckOrigins* origins) {
  FiniteElementModel& model = result.model;
  PlacedDeck deck(raw, model.mesh, notes, problems);
  if (deck.mesh.node_count() == 0)
    problems.fail({0, 1}, "the deck has no nodes", "a model needs nodes and elements",
                  "check that this is the right file");
  Materials materials(raw, deck);
  build_regions(raw, deck, materials, model);
  add_springs(deck, materials.temperature(), model);
  add_masses(deck, model);
  add_nonstructural_masses(deck, model);
  add_matrices(raw, deck, model);
  for (auto& [name, material] : materials.used()) model.materials[name] = material;
  if (raw.temperature && !materials.depend_on_temperature())
    notes.add(problems.location({}), "a stated temperature", "no material of the deck depends on it",
              DeckNoteKind::doubtful);

  const NodeAxes axes = read_transforms(deck);
  Kinematics motions(model, notes, problems);
  read_rigid_bodies(deck, motions);
  read_couplings(deck, motions);
  read_multi_point_constraints(deck, motions);
  read_ties(deck, model, motions);
  read_equations(deck, axes, motions);
  const SupportHistory supports(raw, deck);
  read_boundaries(deck, axes, supports, motions);
  problems.raise();
  motions.store();
  deck.store_sets();
  result.load_cases = read_load_cases(raw, deck, axes, supports, model);
  take_preload(raw, result);
  note_steps(raw, notes, problems);
  problems.raise();
  replace_quadratic_cells(deck, model);
  apply_nodal_thickness(deck, model);
  release_held_rotations(deck, result);
  problems.raise();
  if (origins)
    for (const auto& [name, where] : deck.origins) (*origins)[name] = problems.location(where);
  Ledger ledger;
  settle_ledger(raw, notes, problems, with_ledger ? &ledger : nullptr);
  result.ledger = ledger.take();
  make_names_unique(model.masses);
  make_names_unique(model.springs);
  make_names_unique(model.joints);
  make_names_unique(model.matrices);
  make_names_unique(model.links);
  make_names_unique(model.weighted_links);
  make_names_unique(model.constraints);
}

RawDeck read_raw(std::string content, const std::string& source, const DeckLoader& loader, bool load_cases,
                 DeckNotes& notes, Problems& problems) {
  DeckLines lines(std::move(content), source, loader, problems);
  return read_deck(lines, load_cases, notes, problems);
}

}  // namespace

Deck parse_abaqus(std::string content, const std::string& source, const DeckLoader& loader, const DeckOptions& options,
                  DeckOrigins* origins) {
  DeckNotes notes;
  Problems problems;
  RawDeck raw = read_raw(std::move(content), source, loader, options.load_cases, notes, problems);
  raw.temperature = options.temperature;
  Deck deck;
  build_model(raw, options.ledger, notes, problems, deck, origins);
  deck.model.mesh.source = source;
  deck.model.name = std::filesystem::path(source).stem().string();
  deck.notes = notes.take();
  return deck;
}

Deck read_abaqus(const std::filesystem::path& file, const DeckOptions& options) {
  return parse_abaqus(
      read_text(file), file.string(), [](const std::filesystem::path& path) { return read_text(path); }, options);
}

}  // namespace kalfem
