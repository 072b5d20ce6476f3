// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/load_cases.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/formats/abaqus/active_loads.hpp"
#include "kalfem/formats/abaqus/body_forces.hpp"
#include "kalfem/model/statics/rotation.hpp"

namespace kalfem::abaqus {

namespace {

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
  LoadReader(const RawDeck& raw, PlacedDeck& deck, const NodeAxes& axes, const SupportHistory& history,
             const FiniteElementModel& model)
      : raw_(raw), deck_(deck), axes_(axes), history_(history), model_(model), loads_(raw.from_abaqus) {
    for (const auto& support : model.fixed)
      for (const Index node : support.nodes)
        for (int d = 0; d < 6; ++d)
          if (support.directions[static_cast<std::size_t>(d)]) held_.emplace(NodalDof{node, d}, support.name);
  }

  std::optional<LoadCase> read(const RawDeck::Step& step);

private:
  void read(const Block& block, const RawDeck::Step& step);
  void read_forces(const Block& block, double factor);
  void read_distributed(const Block& block, double factor);
  void read_body(const DataLine& line, const std::string& label, double value);
  void read_element_pressure(const DataLine& line, const std::string& label, double value);
  void read_surface_pressures(const Block& block, double factor);
  [[nodiscard]] LoadedFace loaded(const Face& face);
  void add_bodies(LoadCase& load_case);
  void add_nodal(const Eigen::VectorXd& forces, LoadCase& load_case) const;
  void add_forces(LoadCase& load_case) const;
  void add_holds(const RawDeck::Step& step, LoadCase& load_case);

  void refuse(const Where& where, const std::string& what, const std::string& fix) {
    deck_.problems.add(where, what, "the load case would lack this load", fix);
  }
  /// Whether what the step loads acts in a wanted load case.
  [[nodiscard]] bool counts(const RawDeck::Step& step) const {
    const auto* preload = preload_step(raw_);
    return step.is_static() && (raw_.load_cases || (preload && step.number <= preload->number));
  }
  /// The degree of freedom of the model for a direction along the node's own axes.
  [[nodiscard]] NodalDof dof_of(const NodalDof& own) const {
    const auto local = deck_.local_nodes.find(own.node);
    return local == deck_.local_nodes.end() ? own : NodalDof{local->second, own.direction};
  }

  const RawDeck& raw_;
  PlacedDeck& deck_;
  const NodeAxes& axes_;
  const SupportHistory& history_;
  const FiniteElementModel& model_;
  std::map<NodalDof, std::string> held_;  ///< by supports of the model, with their names
  std::map<int, LoadCase> read_cases_;    ///< by the number of the step
  ActiveLoads loads_;
  bool forces_removed_ = false, distributed_removed_ = false;  ///< in this step: only its first OP=NEW counts
};

// A perturbation of Abaqus has its own loads alone, and the steps behind it go on with those before it. CalculiX takes
// nodal forces away at its begin; all other loads, and those of the perturbation, go on.
std::optional<LoadCase> LoadReader::read(const RawDeck::Step& step) {
  const ActiveLoads before = loads_;
  if (step.is_perturbation()) raw_.from_abaqus ? loads_.remove_all() : loads_.remove_forces();
  loads_.begin_step();
  forces_removed_ = distributed_removed_ = false;
  for (const auto& block : step.blocks) read(block, step);
  std::optional<LoadCase> found;
  if (wants_case(raw_, step)) {
    found = LoadCase{.name = step.name(), .pressures = loads_.pressures()};
    found->of_deck = true;
    add_forces(*found);
    add_bodies(*found);
    add_holds(step, *found);
    if (const auto* base = base_step(raw_, step); base && read_cases_.contains(base->number))
      found->preload = {read_cases_.at(base->number)};
    if (is_empty(*found))
      found.reset();
    else
      read_cases_.emplace(step.number, *found);
  }
  if (step.is_perturbation() && raw_.from_abaqus) loads_ = before;
  return found;
}

void LoadReader::read(const Block& block, const RawDeck::Step& step) {
  const std::string& name = block.keyword.name;
  if (name == "BOUNDARY") return;
  if (name == "TEMPERATURE") {
    if (raw_.expands && counts(step))
      refuse(block.keyword.where, "*TEMPERATURE in step " + std::to_string(step.number) + " loads what expands",
             "leave out *EXPANSION or *TEMPERATURE, or give forces that do the same");
    return;
  }
  if (name != "CLOAD" && name != "DLOAD" && name != "DSLOAD") {
    if (counts(step))
      refuse(block.keyword.where, block.keyword.title + " in step " + std::to_string(step.number) + " is not read",
             "describe what it does by *CLOAD, *DLOAD, *DSLOAD or *BOUNDARY");
    return;
  }
  const double factor = step.is_static() ? amplitude_at_end(deck_, block.keyword, raw_, step) : 1.0;
  if (const auto load_case = block.keyword.word("LOADCASE"); !load_case.empty() && load_case != "1")
    return refuse(block.keyword.where,
                  block.keyword.title + ", LOAD CASE=" + to_string(load_case) + " is an imaginary load",
                  "static loads are real: leave it out");
  if (removes_earlier(deck_, block.keyword)) {
    bool& removed = name == "CLOAD" ? forces_removed_ : distributed_removed_;
    if (!removed) name == "CLOAD" ? loads_.remove_forces() : loads_.remove_distributed(name == "DSLOAD");
  }
  (name == "CLOAD" ? forces_removed_ : distributed_removed_) = true;
  if (name == "CLOAD") read_forces(block, factor);
  if (name == "DLOAD") read_distributed(block, factor);
  if (name == "DSLOAD") read_surface_pressures(block, factor);
}

/// node or set, direction, value.
void LoadReader::read_forces(const Block& block, double factor) {
  for (const auto& line : block.lines) {
    const auto direction = to_integer(line.field(1));
    const auto value = number_at(line, 2, "a force", deck_.problems);
    if (!direction || *direction < 1 || *direction > 6) {
      deck_.problems.add(line.where, "the direction '" + to_string(line.field(1)) + "' of a load cannot be read",
                         "loads act along the directions 1 to 6", "correct the line");
      continue;
    }
    if (!value) continue;
    for (const Index node : deck_.node_list({line.field(0), line.where}, 0))
      loads_.add_force({node, static_cast<int>(*direction) - 1}, factor * *value);
  }
}

/// elements, label, value, and what GRAV and CENTRIF have behind it.
void LoadReader::read_distributed(const Block& block, double factor) {
  for (const auto& line : block.lines) {
    const std::string label = upper_case(line.field(1));
    const bool is_pressure =
        label == "P" || (label.size() == 2 && label[0] == 'P' && label[1] >= '1' && label[1] <= '6');
    const bool is_body = label == "GRAV" || label == "CENTRIF" || label == "BX" || label == "BY" || label == "BZ";
    if (!is_pressure && !is_body) {
      refuse(line.where, block.keyword.title + " " + to_string(line.field(1)) + " is not read",
             "read are P, P1 to P6, GRAV, CENTRIF, BX, BY and BZ; give the others as *CLOAD");
      continue;
    }
    const auto value = number_at(line, 2, "a load", deck_.problems);
    if (!value) continue;
    if (is_pressure)
      read_element_pressure(line, label, factor * *value);
    else
      read_body(line, label, factor * *value);
  }
}

/// GRAV, value, direction; CENTRIF, square of the speed, a point of the axis, its direction; BX, value.
void LoadReader::read_body(const DataLine& line, const std::string& label, double value) {
  const auto vector_at = [&](std::size_t first) {
    Eigen::Vector3d vector;
    for (std::size_t i = 0; i < 3; ++i)
      vector[static_cast<Index>(i)] = number_or(line, first + i, 0.0, "a component", deck_.problems);
    return vector;
  };
  BodyLoad load{.set = upper_case(line.field(0)), .value = value, .where = line.where};
  if (label == "GRAV") {
    load.direction = vector_at(3);
  } else if (label == "CENTRIF") {
    load.kind = BodyLoad::Kind::centrifugal;
    load.about = vector_at(3);
    load.direction = vector_at(6);
  } else {
    load.kind = BodyLoad::Kind::force_per_volume;
    load.direction = Eigen::Vector3d::Unit(label[1] - 'X');
  }
  if (!(load.direction.norm() > 0.0))
    return deck_.problems.add(line.where, label + " has no direction", "it acts along a line, or about one",
                              "give its three components behind the value");
  if (load.kind == BodyLoad::Kind::centrifugal && value < 0.0)
    return deck_.problems.add(line.where, "CENTRIF has the negative value " + to_string(line.field(2)),
                              "it is the square of the angular speed", "correct the line");
  load.direction.normalize();
  if (!load.set.empty() && deck_.element_list({line.field(0), line.where}, 0).empty()) return;
  loads_.add_body(std::move(load));
}

/// Pn acts on a face of a solid, into it; P on shells, along their normal.
void LoadReader::read_element_pressure(const DataLine& line, const std::string& label, double value) {
  for (const Index element : deck_.element_list({line.field(0), line.where}, 0)) {
    const std::string side = label == "P" ? "SPOS" : "S" + label.substr(1);
    const auto face = find_face(deck_, element, side);
    if (!face)
      return deck_.problems.add(line.where,
                                "element " + deck_.element_name(deck_.elements[static_cast<std::size_t>(element)]) +
                                    " has no face for the load " + to_string(label),
                                "P acts on shells, P1 to P6 on the faces of solids", "correct the line");
    loads_.add_pressure(element, label == "P" ? "P" : side, false, loaded(*face), label == "P" ? -value : value);
  }
}

/// surface, P, value: into solids, and into the named side of shells.
void LoadReader::read_surface_pressures(const Block& block, double factor) {
  for (const auto& line : block.lines) {
    if (upper_case(line.field(1)) != "P") {
      refuse(line.where, block.keyword.title + " " + to_string(line.field(1)) + " is not read",
             "a pressure P is read; give other loads on a surface as *CLOAD");
      continue;
    }
    const auto value = number_at(line, 2, "a pressure", deck_.problems);
    const Surface surface = find_surface(deck_, line.field(0), 0, line.where);
    if (!value) continue;
    for (const auto& face : surface.faces) {
      if (face.corners < 3) {
        refuse(line.where, "the surface '" + to_string(line.field(0)) + "' has edges, on which a pressure acts",
               "give the forces on edges as *CLOAD");
        break;
      }
      loads_.add_pressure(face.element, face.label, true, loaded(face),
                          (face.from_below ? -1.0 : 1.0) * factor * *value);
    }
  }
}

LoadedFace LoadReader::loaded(const Face& face) {
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

// Fields on everything that has a mass are the load case's gravity and rotation, with one axis; others are forces.
void LoadReader::add_bodies(LoadCase& load_case) {
  using Kind = BodyLoad::Kind;
  for (const auto& body : loads_.bodies()) {
    if (body.value == 0.0) continue;
    std::vector<Index> elements(deck_.elements.size());
    for (std::size_t i = 0; i < elements.size(); ++i) elements[i] = static_cast<Index>(i);
    if (!body.set.empty()) elements = deck_.element_list({body.set, body.where}, 0);
    const bool everywhere = body.set.empty() || are_all_masses(deck_, elements);
    const Rotation rotation{body.direction, body.about, std::sqrt(std::abs(body.value))};
    if (everywhere && body.kind == Kind::gravity) {
      load_case.gravity += body.value * body.direction;
      continue;
    }
    if (everywhere && body.kind == Kind::centrifugal) {
      auto& known = load_case.rotation;
      if (!known) {
        known = rotation;
        continue;
      }
      if (known->axis == rotation.axis && known->about == rotation.about) {
        known->speed = std::hypot(known->speed, rotation.speed);
        continue;
      }
    }
    const AccelerationField field = body.kind == Kind::centrifugal
                                        ? centrifugal_field(rotation)
                                        : AccelerationField(Eigen::Vector3d(body.value * body.direction));
    if (const auto forces =
            field_forces(deck_, model_, elements, field, body.kind == Kind::force_per_volume, body.where))
      add_nodal(*forces, load_case);
  }
}

void LoadReader::add_nodal(const Eigen::VectorXd& forces, LoadCase& load_case) const {
  for (Index node = 0; node < deck_.mesh.node_count() && 6 * node + 5 < forces.size(); ++node)
    if (const Eigen::Matrix<double, 6, 1> own = forces.segment<6>(6 * node); !own.isZero(0.0))
      load_case.loads.push_back({node, own.head<3>(), own.tail<3>()});
}

void LoadReader::add_forces(LoadCase& load_case) const {
  std::map<Index, NodeLoad> at_nodes;
  for (const auto& [dof, value] : loads_.forces()) {
    auto& load = at_nodes.try_emplace(dof.node, NodeLoad{.node = dof.node}).first->second;
    const auto own = axes_.find(dof.node);
    const auto of_coupling = deck_.load_axes.find(dof.node);
    const Eigen::Matrix3d axes = of_coupling != deck_.load_axes.end() ? of_coupling->second
                                 : own == axes_.end()                 ? Eigen::Matrix3d::Identity()
                                                                      : own->second;
    (dof.direction < 3 ? load.force : load.moment) += value * axes.col(dof.direction % 3);
  }
  for (const auto& [node, load] : at_nodes) load_case.loads.push_back(load);
}

// Where the step holds just what the model does, the case has no supports of its own.
void LoadReader::add_holds(const RawDeck::Step& step, LoadCase& load_case) {
  const Holds& holds = history_.of_step(step.number);
  auto held = held_;
  bool changed = false;
  for (const auto& dof : history_.varying()) {
    const auto hold = holds.find(dof);
    const NodalDof own = dof_of(dof);
    if (hold == holds.end()) {
      if (!history_.of_model().contains(dof)) continue;
      changed = true;
      if (held.erase(own) == 0)
        deck_.problems.add(step.keyword.where,
                           step.name() + " lets go of a motion that a support of the model holds through a link",
                           "such a support is no single degree of freedom", "support the node that leads the link");
      continue;
    }
    if (hold->second.frozen)
      deck_.problems.add(hold->second.where, "*BOUNDARY, FIXED holds nodes where the step before left them",
                         "the load cases are solved each by itself", "write the displacement as the value");
    changed = held.try_emplace(own, hold->second.name).second || changed;
    if (hold->second.value != 0.0) load_case.imposed.push_back({own, hold->second.value, true});
  }
  if (changed) load_case.supports = grouped_supports(held);
}

}  // namespace

std::vector<LoadCase> read_load_cases(const RawDeck& raw, PlacedDeck& deck, const NodeAxes& axes,
                                      const SupportHistory& history, const FiniteElementModel& model) {
  if (!raw.load_cases && !preload_step(raw)) return {};
  if (raw.initial_stress && std::ranges::any_of(raw.steps, &RawDeck::Step::is_static))
    deck.problems.add(*raw.initial_stress, "*INITIAL CONDITIONS, TYPE=STRESS loads the static steps",
                      "initial stresses are not read: the load cases would lack them", "leave them out");
  LoadReader reader(raw, deck, axes, history, model);
  std::vector<LoadCase> cases;
  const int last = raw.load_cases ? static_cast<int>(raw.steps.size()) : preload_step(raw)->number;
  for (const auto& step : raw.steps)
    if (step.number > last)
      break;
    else if (auto found = reader.read(step))
      cases.push_back(std::move(*found));
  return cases;
}

}  // namespace kalfem::abaqus
