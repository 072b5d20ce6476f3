#include "kalfem/formats/abaqus/load_cases.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem::abaqus {

namespace {

/// Loads that act at one time. Each is kept by its place, for a later step gives it another value.
struct ActiveLoads {
  std::map<NodalDof, double> forces;  ///< in the axes of the node
  std::vector<SurfacePressure> pressures;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  std::map<NodalDof, double> imposed;
};

/// The directions of a *BOUNDARY line with a value, or of *CLOAD.
struct DirectionRange {
  int first = 0, last = -1;
};

/// Counter-clockwise seen from outside the solid that the face belongs to.
void turn_outwards(const Mesh& mesh, const Eigen::Vector3d& inside, LoadedFace& face) {
  const auto corners = corner_count(face.shape);
  const auto at = [&](int i) -> Eigen::Vector3d { return mesh.nodes.col(face.nodes[static_cast<std::size_t>(i)]); };
  const Eigen::Vector3d normal = (at(1) - at(0)).cross(at(corners - 1) - at(0));
  if (normal.dot(at(0) - inside) > 0.0) return;
  std::reverse(face.nodes.begin() + 1, face.nodes.begin() + corners);
  std::reverse(face.nodes.begin() + corners, face.nodes.begin() + node_count(face.shape));
}

CellShape shape_of(const Face& face) {
  const bool quadratic = face.nodes.size() > face.corners;
  if (face.corners == 3) return quadratic ? CellShape::triangle6 : CellShape::triangle3;
  return quadratic ? CellShape::quadrilateral8 : CellShape::quadrilateral4;
}

/// Reads the loads of one step after the other.
class LoadReader {
public:
  LoadReader(PlacedDeck& deck, const NodeAxes& axes, const FiniteElementModel& model) : deck_(deck), axes_(axes) {
    for (const auto& support : model.fixed)
      for (const Index node : support.nodes)
        for (int d = 0; d < 6; ++d)
          if (support.directions[static_cast<std::size_t>(d)]) held_.insert({node, d});
    for (const auto& at : deck.blocks("BOUNDARY"))
      if (!at.block->keyword.has("INSTEP")) read_boundary(*at.block, at.place);
  }

  std::optional<LoadCase> read(const RawDeck::Step& step) {
    const ActiveLoads before = loads_;
    if (step.is_perturbation) loads_ = {};
    const int root = deck_.place_count() - 1;
    for (const auto& block : step.blocks) {
      const std::string& name = block.keyword.name;
      if (block.keyword.has("AMPLITUDE"))
        note(block.keyword, ", AMPLITUDE", "the value on the line is used, not its course over the step");
      if (name == "CLOAD") read_forces(block, root);
      if (name == "DLOAD") read_distributed(block, root);
      if (name == "DSLOAD") read_surface_pressures(block, root);
      if (name == "BOUNDARY") read_boundary(block, root);
    }
    std::optional<LoadCase> found;
    if (step.is_static) found = load_case("step" + std::to_string(step.number));
    if (step.is_perturbation) loads_ = before;
    return found;
  }

private:
  void note(const Keyword& keyword, const std::string& more, const std::string& consequence) {
    deck_.notes.add(deck_.problems.location(keyword.where), keyword.title + more, consequence, DeckNoteKind::doubtful);
  }

  [[nodiscard]] static bool removes_earlier(const Keyword& keyword) { return keyword.word("OP") == "NEW"; }

  std::optional<DirectionRange> directions_of(const DataLine& line, bool has_last) {
    const auto first = to_integer(line.field(1));
    const auto last = has_last && !line.field(2).empty() ? to_integer(line.field(2)) : first;
    if (first && last && *first >= 1 && *last >= *first && *last <= 6)
      return DirectionRange{static_cast<int>(*first) - 1, static_cast<int>(*last) - 1};
    deck_.problems.add(line.where, "the direction '" + to_string(line.field(1)) + "' of a load cannot be read",
                       "loads act along the directions 1 to 6", "correct the line");
    return {};
  }

  /// node or set, direction, value.
  void read_forces(const Block& block, int place) {
    if (removes_earlier(block.keyword)) loads_.forces.clear();
    for (const auto& line : block.lines) {
      const auto directions = directions_of(line, false);
      const auto value = number_at(line, 2, "a force", deck_.problems);
      if (!directions || !value) continue;
      for (const Index node : deck_.node_list({line.field(0), line.where}, place))
        loads_.forces[{node, directions->first}] = *value;
    }
  }

  /// elements, label, value, and the direction of GRAV.
  void read_distributed(const Block& block, int place) {
    if (removes_earlier(block.keyword)) remove_distributed();
    for (const auto& line : block.lines) {
      const std::string label = upper_case(line.field(1));
      const auto value = number_at(line, 2, "a load", deck_.problems);
      if (!value) continue;
      if (label == "GRAV")
        read_gravity(line, place, *value);
      else if (label == "P" || (label.size() == 2 && label[0] == 'P' && label[1] >= '1' && label[1] <= '6'))
        read_element_pressure(line, place, label, *value);
      else
        note(block.keyword, " " + to_string(label), "this kind of load is not read: the load case lacks it");
    }
  }

  void remove_distributed() {
    loads_.pressures.clear();
    loads_.gravity.setZero();
  }

  /// Gravity acts on the whole model.
  void read_gravity(const DataLine& line, int place, double value) {
    Eigen::Vector3d direction;
    for (int i = 0; i < 3; ++i)
      direction[i] = number_or(line, 3 + static_cast<std::size_t>(i), 0.0, "a direction", deck_.problems);
    if (!line.field(0).empty()) {
      const auto members = deck_.element_list({line.field(0), line.where}, place);
      if (members.empty()) return;
      std::vector<bool> loaded(deck_.elements.size(), false);
      for (const Index element : members) loaded[static_cast<std::size_t>(element)] = true;
      for (std::size_t i = 0; i < deck_.elements.size(); ++i)
        if (deck_.elements[i].cell >= 0 && !loaded[i]) {
          deck_.problems.add(line.where,
                             "GRAV does not act on element " + deck_.element_name(deck_.elements[i]) + " and others",
                             "gravity acts on the whole model", "name a set of all elements");
          break;
        }
    }
    if (direction.norm() > 0.0)
      loads_.gravity = value * direction.normalized();
    else
      deck_.problems.add(line.where, "GRAV has no direction", "gravity acts along a line",
                         "give its three components behind the value");
  }

  /// Pn acts on a face of a solid, into it; P on shells, along their normal.
  void read_element_pressure(const DataLine& line, int place, const std::string& label, double value) {
    SurfacePressure pressure{{}, label == "P" ? -value : value};
    for (const Index element : deck_.element_list({line.field(0), line.where}, place)) {
      const auto face = find_face(deck_, element, label == "P" ? "SPOS" : "S" + label.substr(1));
      if (face)
        pressure.faces.push_back(loaded(*face));
      else
        return deck_.problems.add(line.where,
                                  "element " + deck_.element_name(deck_.elements[static_cast<std::size_t>(element)]) +
                                      " has no face for the load " + to_string(label),
                                  "P acts on shells, P1 to P6 on the faces of solids", "correct the line");
    }
    loads_.pressures.push_back(std::move(pressure));
  }

  /// surface, P, value: into solids, and into the named side of shells.
  void read_surface_pressures(const Block& block, int place) {
    if (removes_earlier(block.keyword)) remove_distributed();
    for (const auto& line : block.lines) {
      if (upper_case(line.field(1)) != "P") {
        note(block.keyword, " " + to_string(line.field(1)), "this kind of load is not read: the load case lacks it");
        continue;
      }
      const auto value = number_at(line, 2, "a pressure", deck_.problems);
      const Surface surface = find_surface(deck_, line.field(0), place, line.where);
      if (!value) continue;
      SurfacePressure above{{}, *value}, below{{}, -*value};
      for (const auto& face : surface.faces)
        if (face.corners >= 3) (face.from_below ? below : above).faces.push_back(loaded(face));
      for (auto& pressure : {above, below})
        if (!pressure.faces.empty()) loads_.pressures.push_back(pressure);
    }
  }

  LoadedFace loaded(const Face& face) {
    LoadedFace result{.shape = shape_of(face)};
    std::ranges::copy(face.nodes, result.nodes.begin());
    const auto& element = deck_.elements[static_cast<std::size_t>(face.element)];
    if (deck_.type_of(element).family != Family::solid) return result;
    std::vector<Index> nodes;
    deck_.nodes_of(element, nodes);
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Index node : nodes) middle += deck_.mesh.nodes.col(node) / static_cast<double>(nodes.size());
    turn_outwards(deck_.mesh, middle, result);
    return result;
  }

  /// node or set, first and last direction, value. Zeros hold, see read_boundaries(), unless they bring something back.
  void read_boundary(const Block& block, int place) {
    if (removes_earlier(block.keyword)) loads_.imposed.clear();
    for (const auto& line : block.lines) {
      const auto value = to_number(line.field(3));
      if (!value) continue;
      const auto directions = directions_of(line, true);
      if (!directions) continue;
      for (const Index node : deck_.node_list({line.field(0), line.where}, place)) {
        if (axes_.contains(node) && !deck_.local_nodes.contains(node)) {
          if (*value != 0.0)
            note(block.keyword, " with a value in axes of *TRANSFORM, first in a later step", "the motion is left out");
          continue;
        }
        for (int d = directions->first; d <= directions->last; ++d) impose({moved_node(node), d}, *value);
      }
    }
  }

  /// The node whose degrees of freedom are along the axes of the line.
  [[nodiscard]] Index moved_node(Index node) const {
    const auto local = deck_.local_nodes.find(node);
    return local == deck_.local_nodes.end() ? node : local->second;
  }

  void impose(const NodalDof& dof, double value) {
    if (value != 0.0 || loads_.imposed.contains(dof)) loads_.imposed[dof] = value;
  }

  [[nodiscard]] LoadCase load_case(const std::string& name) const {
    LoadCase result{.name = name, .pressures = loads_.pressures, .gravity = loads_.gravity};
    std::map<Index, NodeLoad> at_nodes;
    for (const auto& [dof, value] : loads_.forces) {
      auto& load = at_nodes.try_emplace(dof.node, NodeLoad{.node = dof.node}).first->second;
      const auto own = axes_.find(dof.node);
      const Eigen::Matrix3d axes = own == axes_.end() ? Eigen::Matrix3d::Identity() : own->second;
      (dof.direction < 3 ? load.force : load.moment) += value * axes.col(dof.direction % 3);
    }
    for (const auto& [node, load] : at_nodes) result.loads.push_back(load);
    for (const auto& [dof, value] : loads_.imposed) result.imposed.push_back({dof, value, held_.contains(dof)});
    return result;
  }

  PlacedDeck& deck_;
  const NodeAxes& axes_;
  std::set<NodalDof> held_;  ///< by supports
  ActiveLoads loads_;
};

}  // namespace

std::vector<LoadCase> read_load_cases(const RawDeck& raw, PlacedDeck& deck, const NodeAxes& axes,
                                      const FiniteElementModel& model) {
  LoadReader reader(deck, axes, model);
  std::vector<LoadCase> cases;
  for (const auto& step : raw.steps)
    if (auto found = reader.read(step); found && !is_empty(*found)) cases.push_back(std::move(*found));
  return cases;
}

}  // namespace kalfem::abaqus
