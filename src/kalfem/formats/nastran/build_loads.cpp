#include <algorithm>
#include <set>

#include "kalfem/formats/nastran/model_building.hpp"
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
    for (const auto& support : building.model.fixed)
      for (const auto node : support.nodes)
        for (int d = 0; d < 6; ++d)
          if (support.directions[static_cast<std::size_t>(d)]) held_.insert({node, d});
  }

  /// `load`: number of a LOAD card or of a set of loads. The enforced motions of supports act too.
  LoadCase build(const std::string& name, std::optional<Id> load) {
    LoadCase result{.name = name};
    const LoadSets sets = load ? sets_of(*load) : LoadSets{};
    const auto factor_of = [&](Id set) {
      const auto found = sets.find(set);
      return found == sets.end() ? 0.0 : found->second;
    };
    for (const auto& card : bulk_.forces)
      if (const double factor = factor_of(card.set); factor != 0.0) add(card, factor, result);
    for (const auto& card : bulk_.pressures)
      if (const double factor = factor_of(card.set); factor != 0.0) add(card, factor, result);
    for (const auto& card : bulk_.gravities)
      if (const double factor = factor_of(card.set); factor != 0.0)
        result.gravity += factor * in_basic_axes(card.system, card.vector, Eigen::Vector3d::Zero(), card.where);
    for (const auto& card : bulk_.spcs)
      if (building_.supports.contains(card.set) && card.value != 0.0)
        impose(
            {.node = card.nodes.front().first, .components = card.components, .value = card.value, .where = card.where},
            1.0, result);
    for (const auto& card : bulk_.imposed)
      if (const double factor = factor_of(card.set); factor != 0.0) impose(card, factor, result);
    return result;
  }

  /// Sets that no LOAD card sums up, and the LOAD cards.
  [[nodiscard]] std::set<Id> top_sets() const {
    std::set<Id> sets;
    for (const auto& card : bulk_.forces) sets.insert(card.set);
    for (const auto& card : bulk_.pressures) sets.insert(card.set);
    for (const auto& card : bulk_.gravities) sets.insert(card.set);
    for (const auto& card : bulk_.imposed) sets.insert(card.set);
    for (const auto& [sum, parts] : bulk_.load_sums)
      for (const auto& [part, factor] : parts) sets.erase(part);
    for (const auto& [sum, parts] : bulk_.load_sums) sets.insert(sum);
    return sets;
  }

private:
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
        factor * in_basic_axes(card.system, card.vector, building_.place(node), card.where);
    result.loads.push_back(load);
  }

  /// Pushes into solids, and along the normal of shells.
  void add(const PressureCard& card, double factor, LoadCase& result) {
    SurfacePressure into{{}, factor * card.pressure}, along{{}, -factor * card.pressure};
    for (const auto& range : card.elements)
      for (auto cell = cells_.lower_bound(range.first); cell != cells_.end() && cell->first <= range.last; ++cell) {
        const bool is_shell = dimension(building_.model.mesh.cells[cell->second].shape) == 2;
        if (const auto face = loaded_face(card, cell->second)) (is_shell ? along : into).faces.push_back(*face);
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

std::vector<LoadCase> build_load_cases(Building& building) {
  LoadBuilder builder(building);
  std::vector<LoadCase> cases;
  for (const auto& subcase : building.control.subcases) {
    if (subcase.spc != building.control.spc)
      building.note(subcase.where, "SUBCASEs with different SPC", "the supports of the first one hold in all",
                    DeckNoteKind::doubtful);
    cases.push_back(builder.build("subcase" + std::to_string(subcase.number), subcase.load));
  }
  if (!building.control.is_present)
    for (const Id set : builder.top_sets()) cases.push_back(builder.build("load" + std::to_string(set), set));
  std::erase_if(cases, is_empty);
  return cases;
}

}  // namespace kalfem::nastran
