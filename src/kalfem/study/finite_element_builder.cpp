// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/finite_element_builder.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>

#include "kalfem/formats/gmsh/gmsh.hpp"
#include "kalfem/model/gauges/gauge_placement.hpp"
#include "kalfem/model/mesh/split_quadratic_shells.hpp"
#include "kalfem/model/part_factors.hpp"
#include "kalfem/model/placement.hpp"
#include "kalfem/model/unit_system.hpp"
#include "kalfem/study/assembly.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
namespace d = description;

Vector3d vector(const std::array<double, 3>& values) { return {values[0], values[1], values[2]}; }

BeamSection section_of(const d::RectangleSection& given) { return rectangular_section(given.width, given.height); }
BeamSection section_of(const d::CircleSection& given) { return circular_section(given.diameter); }
BeamSection section_of(const d::CircularTubeSection& given) {
  return circular_tube_section(given.diameter, given.wall);
}
BeamSection section_of(const d::RectangularTubeSection& given) {
  return rectangular_tube_section(given.width, given.height, given.wall);
}
BeamSection section_of(const d::GeneralSection& given) {
  return {given.area, given.inertia_y, given.inertia_z, given.torsion, given.shear_factor_y, given.shear_factor_z};
}

RegionProperty property_of(const d::Region& given) {
  if (const auto* shell = std::get_if<d::ShellRegion>(&given.property))
    return ShellProperty{given.material.value, shell->thickness, shell->offset, 0.0};
  if (const auto* solid = std::get_if<d::SolidRegion>(&given.property))
    return SolidProperty{given.material.value, solid->kind, {}};
  const auto& beam = std::get<d::BeamRegion>(given.property);
  const BeamSection section = std::visit([](const auto& each) { return section_of(each); }, beam.section.section);
  const Vector3d offset = vector(beam.offset);
  return BeamProperty{given.material.value, section, {{vector(beam.up), offset.replicate<1, 2>(), {}}}};
}

std::string metres(double length) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g m", length);
  return text;
}

/// "[0.5, 0, 1] m".
std::string to_string(const Vector3d& place) {
  char text[96];
  std::snprintf(text, sizeof text, "[%.6g, %.6g, %.6g] m", place[0], place[1], place[2]);
  return text;
}

std::array<bool, 6> chosen(const std::vector<std::string>& directions) {
  std::array<bool, 6> result{};
  result.fill(directions.empty());
  for (const auto& name : directions) result[static_cast<std::size_t>(direction_index(name))] = true;
  return result;
}

MatrixDeckFiles matrix_files(const d::MatrixFiles& given) {
  MatrixDeckFiles files{.sets = {}, .units = given.units};
  if (given.coordinates) files.coordinates = given.coordinates->value;
  for (const auto& each : given.sets) {
    MatrixSetFiles set{.files = {},
                       .stiffness = each.stiffness,
                       .mass = each.mass,
                       .damping = each.damping,
                       .directions = each.directions,
                       .where = each.files.front().location};
    for (const auto& file : each.files) set.files.push_back(file.value);
    if (each.dofs) set.dof_map = each.dofs->value;
    files.sets.push_back(std::move(set));
  }
  return files;
}

FactorMatrixFiles factor_files(const d::MatricesOfFactor& given, const UnitSystem& units) {
  const auto named = [](const std::optional<d::FactorMatrix>& each) -> std::optional<NamedMatrixFile> {
    if (!each) return {};
    return NamedMatrixFile{each->file, each->name};
  };
  FactorMatrixFiles files{.stiffness = named(given.stiffness),
                          .mass = named(given.mass),
                          .damping = named(given.damping),
                          .directions = given.directions,
                          .units = units};
  if (given.dofs) files.dof_map = given.dofs->value;
  return files;
}

template <class Map>
std::vector<std::string> names_of(const Map& map) {
  std::vector<std::string> names;
  for (const auto& entry : map) names.push_back(entry.first);
  return names;
}

/// Builds one model in steps: mesh, deck or matrices; materials and properties of regions; their placement; linear
/// shells in place of quadratic ones; named nodes; then masses, springs, links and supports at these nodes. An unknown
/// name becomes an issue with its place, and the building continues.
class Builder {
public:
  Builder(const std::string& name, const d::Substructure& given, const UsedGroups& used, DeckFiles& decks)
      : name_(name), given_(given), fe_(*given.finite_elements), used_(used), decks_(decks) {}

  NamedElements build() {
    read_source();
    add_properties();
    add_factors();
    place_source();
    const auto split = centres_of_split_elements();
    replace_quadratic(model_);
    name_nodes();
    place_gauges(split);
    add_masses();
    add_springs();
    add_links_and_supports();
    auto load_groups = cells_of_load_groups();
    forget_groups_of_nodes();
    issues_.raise();
    return {std::move(model_),      std::move(nodes_),      std::move(gauges_),      std::move(notes_),
            std::move(load_groups), std::move(deck_cases_), std::move(deck_preload_)};
  }

private:
  void read_source() {
    try {
      std::visit([&](const auto& source) { read(source); }, fe_.source);
    } catch (const InvalidInput& error) {
      IssueList issues;
      issues.add(error, fe_.location());
      issues.raise();
    }
    model_.name = name_;
    if (fe_.mass_matrix) model_.mass_kind = *fe_.mass_matrix;
  }

  void place_source() {
    Placement placement{.shift = vector(fe_.translate)};
    if (fe_.rotate) {
      placement.rotation = turn_about(vector(fe_.rotate->axis), fe_.rotate->angle);
      placement.about = vector(fe_.rotate->about);
    }
    if (deck_preload_) deck_cases_.push_back(std::move(*deck_preload_));
    place(model_, deck_cases_, placement);
    if (!deck_preload_) return;
    deck_preload_ = std::move(deck_cases_.back());
    deck_cases_.pop_back();
  }

  void read(const d::MeshFile& mesh) {
    model_.mesh = read_gmsh(mesh.file.value, &notes_);
    model_.mesh.nodes *= mesh.scale;
    require_regions("give each physical group a property");
  }

  void read(const d::TableFiles& tables) {
    model_.mesh = read_table_mesh(tables.nodes.value, tables.elements.value, {.scale = tables.scale, .notes = &notes_});
    require_regions("give each region of the table a property");
  }

  void require_regions(const std::string& fix) {
    if (fe_.regions.empty())
      issues_.add(fe_.location(), "substructures." + name_ + ".finite_elements has no `regions`",
                  "a mesh does not state the properties of its elements", fix);
  }

  void read(const d::DeckFile& file) {
    Deck deck = decks_.read(file.file.value, {.format = file.format,
                                              .temperature = file.temperature,
                                              .subcase = file.subcase,
                                              .load_cases = used_.deck_cases});
    accept_missing(deck.notes, file);
    model_ = std::move(deck.model);
    notes_ = std::move(deck.notes);
    deck_cases_ = std::move(deck.load_cases);
    deck_preload_ = std::move(deck.preload);
    to_si(model_, file.units);
    for (auto& load_case : deck_cases_) to_si(load_case, file.units);
    if (deck_preload_) to_si(*deck_preload_, file.units);
  }

  void accept_missing(std::vector<DeckNote>& notes, const d::DeckFile& file) {
    std::vector<std::string> accepted;
    for (const auto& name : file.accept_missing) accepted.push_back(name.value);
    const auto idle = kalfem::accept_missing(notes, accepted, issues_);
    for (const auto& name : file.accept_missing)
      if (std::ranges::find(idle, name.value) != idle.end())
        issues_.add(name.location, name.path + ": nothing in the deck named '" + name.value + "' is missing",
                    "an unused entry could hide a later problem", "remove it or correct the name");
  }

  void read(const d::MatrixFiles& files) {
    Deck deck = read_matrix_deck(matrix_files(files));
    model_ = std::move(deck.model);
    notes_ = std::move(deck.notes);
    has_places_ = files.coordinates.has_value();
    if (has_places_) return;
    for (const auto& [name, place] : fe_.nodes)
      if (place.value.group.empty()) refuse_without_coordinates(place.location, place.path);
    for (const auto& [name, link] : fe_.links) refuse_without_coordinates(link.nodes.location, link.nodes.path);
  }

  void refuse_without_coordinates(const SourceLocation& location, const std::string& path) {
    issues_.add(location, path + ": matrices do not state where their nodes are", "this needs coordinates",
                "give `coordinates`, or refer to nodes by number");
  }

  void add_properties() {
    check_material_names();
    for (const auto& [name, material] : fe_.materials)
      model_.materials[name] = {material.youngs_modulus, material.poissons_ratio, material.density};
    for (const auto& [name, region] : fe_.regions) {
      const auto& place = region.material;
      if (!model_.mesh.regions.contains(name))
        issues_.add(place.location,
                    "region '" + name + "' is not a group of " + model_.mesh.source +
                        did_you_mean(name, names_of(model_.mesh.regions)),
                    "a property needs elements", "name one of its groups");
      else if (!model_.materials.contains(place.value))
        issues_.add(place.location,
                    place.path + ": there is no material '" + place.value + "'" +
                        did_you_mean(place.value, names_of(model_.materials)),
                    "", "define it under `materials`");
      else
        model_.properties[name] = property_of(region);
    }
  }

  /// Factors of elements and of matrices. Matrices are in the units of the deck or of the other matrices.
  void add_factors() {
    for (const auto& [name, factor] : fe_.factors) try {
        if (const auto* elements = std::get_if<d::ElementsOfFactor>(&factor.value.part)) {
          std::vector<std::string> names;
          for (const auto& each : elements->elements) names.push_back(each.value);
          add_element_factor(model_, name, names, elements->of, factor.value.value);
        } else {
          const auto& matrices = std::get<d::MatricesOfFactor>(factor.value.part);
          add_matrix_factor(model_, name, factor_files(matrices, units_of_source()), factor.value.value);
        }
      } catch (const InvalidInput& error) {
        for (const auto& issue : error.issues())
          issues_.add(factor.location, factor.path + ": " + issue.what, issue.why, issue.fix);
      }
  }

  [[nodiscard]] UnitSystem units_of_source() const {
    if (const auto* deck = std::get_if<d::DeckFile>(&fe_.source)) return deck->units;
    if (const auto* matrices = std::get_if<d::MatrixFiles>(&fe_.source)) return matrices->units;
    return {};
  }

  /// For a deck, the case may only replace materials that the deck has: any other name would have no effect.
  void check_material_names() {
    if (!std::holds_alternative<d::DeckFile>(fe_.source)) return;
    for (const auto& [name, material] : fe_.materials) {
      const auto made_of_it = [&](const auto& region) { return region.second.material.value == name; };
      if (!model_.materials.contains(name) && std::ranges::none_of(fe_.regions, made_of_it))
        issues_.add(fe_.location(),
                    "substructures." + name_ + ".finite_elements.materials." + name + ": the deck has no material '" +
                        name + "'" + did_you_mean(name, names_of(model_.materials)),
                    "it would have no effect", "name a material of the deck, or one that a region uses");
    }
  }

  void name_nodes() {
    const NodeFinder finder(model_.mesh);
    for (const auto& [name, place] : fe_.nodes) {
      if (!place.value.group.empty()) {
        if (const Index node = node_of_group(place, finder); node >= 0) nodes_.push_back({name, node});
        continue;
      }
      const Vector3d at = vector(place.value.at);
      const Index node = nearest_node(model_.mesh, at);
      nodes_.push_back({name, node, (model_.mesh.nodes.col(node) - at).norm()});
    }
    check_places();
  }

  [[nodiscard]] const Located<d::NodePlace>& place_of(const std::string& name) const {
    return std::ranges::find(fe_.nodes, name, &std::pair<std::string, Located<d::NodePlace>>::first)->second;
  }

  /// Coordinates stand for the nearest node. They must lie closer to it than the size of the elements around it, and no
  /// other coordinates may stand for the same node.
  void check_places() {
    if (!has_places_) return;
    std::vector<Index> found;
    for (const auto& named : nodes_) found.push_back(named.node);
    const auto sizes = element_sizes(model_.mesh, found);
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (nodes_[i].distance && *nodes_[i].distance > sizes[i] * (1.0 + 1e-9) + 1e-12)
        refuse_far_place(nodes_[i], sizes[i]);
      else
        for (std::size_t j = 0; j < i; ++j) refuse_shared_node(nodes_[j], nodes_[i], sizes[i]);
  }

  [[nodiscard]] std::string title_of(Index node) const {
    return "node " + std::to_string(model_.mesh.node_ids[static_cast<std::size_t>(node)]) + " at " +
           to_string(model_.mesh.nodes.col(node));
  }

  void refuse_far_place(const NamedNode& named, double size) {
    const auto& place = place_of(named.name);
    issues_.add(place.location,
                place.path + ": the nearest node to " + to_string(vector(place.value.at)) + " is " +
                    title_of(named.node) + ", " + metres(*named.distance) + " away",
                "the elements there are " + metres(size) + " large: the place lies outside the model",
                "give coordinates in metres (check the units of the model) or a node number");
  }

  /// Refuses two different places at one node: they would be one motion with two names.
  void refuse_shared_node(const NamedNode& one, const NamedNode& other, double size) {
    if (one.node != other.node || !one.distance || !other.distance) return;
    const auto &first = place_of(one.name), &second = place_of(other.name);
    const Vector3d apart = vector(first.value.at) - vector(second.value.at);
    if (apart.norm() <= 1e-2 * size) return;
    issues_.add(second.location,
                second.path + " " + to_string(vector(second.value.at)) + " and '" + one.name + "' " +
                    to_string(vector(first.value.at)) + " are both nearest to " + title_of(other.node),
                "the mesh is too coarse to separate the two places",
                "refine the mesh there, or give both the number of that node");
  }

  Index node_of_group(const Located<d::NodePlace>& place, const NodeFinder& finder) {
    const std::string& word = place.value.group;
    if (const auto set = model_.mesh.node_sets.find(word); set != model_.mesh.node_sets.end()) {
      if (set->second.size() == 1) return set->second.front();
      issues_.add(place.location,
                  place.path + ": the group '" + word + "' has " + std::to_string(set->second.size()) + " nodes",
                  "a named node must be a single node", "give a node number or coordinates");
      return -1;
    }
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    const bool is_number = error == std::errc{} && end == word.data() + word.size();
    if (const Index node = is_number ? finder.find(number) : -1; node >= 0) return node;
    issues_.add(place.location,
                place.path + ": " + model_.mesh.source + " has no " + (is_number ? "node " : "group ") + "'" + word +
                    "'" + did_you_mean(word, names_of(model_.mesh.node_sets)),
                "", "give a group of one node, a node number or coordinates [x, y, z]");
    return -1;
  }

  /// Index of a named node; -1, with an issue, if there is none.
  Index find_node(const std::string& name, const SourceLocation& location, const std::string& path) {
    const auto found = std::ranges::find(nodes_, name, &NamedNode::name);
    if (found != nodes_.end()) return found->node;
    if (std::ranges::find(fe_.nodes, name, &std::pair<std::string, Located<d::NodePlace>>::first) == fe_.nodes.end())
      issues_.add(location, path + ": there is no node '" + name + "'" + did_you_mean(name, names_of(fe_.nodes)), "",
                  "define it under `nodes`");
    return -1;
  }

  /// Centres of the quadratic lines and shells that gauges name. Linear ones stand in their place later.
  [[nodiscard]] std::map<std::int64_t, Vector3d> centres_of_split_elements() const {
    std::map<std::int64_t, Vector3d> centres;
    for (const auto& [name, gauge] : fe_.gauges)
      if (const auto* element = std::get_if<d::GaugeElement>(&gauge.value.place))
        for (const auto& cell : model_.mesh.cells)
          if (cell.id == element->number && (dimension(cell.shape) == 1 || dimension(cell.shape) == 2) &&
              node_count(cell.shape) > corner_count(cell.shape))
            centres[cell.id] = corner_places(model_.mesh, cell).rowwise().mean();
    return centres;
  }

  void place_gauges(const std::map<std::int64_t, Vector3d>& split) {
    if (!issues_.empty()) return;
    const NodeFinder finder(model_.mesh);
    for (const auto& [name, gauge] : fe_.gauges) try {
        if (const auto place = place_of_gauge(gauge.value, split, finder))
          gauges_.push_back(place_gauge(model_, described(name, gauge.value, *place)));
      } catch (const InvalidInput& error) {
        issues_.add(error, gauge.location);
      }
  }

  using GaugePlace = std::variant<Vector3d, std::int64_t>;

  std::optional<GaugePlace> place_of_gauge(const d::Gauge& gauge, const std::map<std::int64_t, Vector3d>& split,
                                           const NodeFinder& finder) {
    if (const auto* element = std::get_if<d::GaugeElement>(&gauge.place)) {
      const auto centre = split.find(element->number);
      return centre == split.end() ? GaugePlace(element->number) : GaugePlace(centre->second);
    }
    const auto& at = std::get<Located<d::NodePlace>>(gauge.place);
    if (at.value.group.empty()) return vector(at.value.at);
    const Index node = node_of_group(at, finder);
    return node < 0 ? std::nullopt : std::optional<GaugePlace>(Vector3d(model_.mesh.nodes.col(node)));
  }

  static GaugeDescription described(const std::string& name, const d::Gauge& gauge, const GaugePlace& place) {
    GaugeDescription description{.name = name, .place = place, .surface = gauge.surface};
    if (gauge.direction) description.direction = vector(*gauge.direction);
    if (gauge.fibre) description.fibre = Eigen::Vector2d((*gauge.fibre)[0], (*gauge.fibre)[1]);
    if (gauge.region) description.region = gauge.region->value;
    return description;
  }

  void add_masses() {
    for (const auto& [name, mass] : fe_.masses)
      if (const Index node = find_node(mass.at.value, mass.at.location, mass.at.path); node >= 0)
        model_.masses.push_back({name, node, mass.mass, vector(mass.inertia).asDiagonal(), vector(mass.offset)});
  }

  [[nodiscard]] bool is_ground(const std::string& name) const {
    return name == "ground" || std::ranges::find(given_.grounds, name) != given_.grounds.end();
  }

  std::optional<NodalDof> spring_end(const Name& end) {
    const auto dot = end.value.rfind('.');
    const int direction = dot == std::string::npos ? -1 : direction_index(end.value.substr(dot + 1));
    if (direction < 0) {
      issues_.add(end.location, end.path + ": '" + end.value + "' has no direction", "a spring acts in one direction",
                  "write node.x, y, z, rx, ry or rz, or a ground");
      return std::nullopt;
    }
    const Index node = find_node(end.value.substr(0, dot), end.location, end.path);
    if (node < 0) return std::nullopt;
    return NodalDof{node, direction};
  }

  void add_springs() {
    for (const auto& spring : given_.springs) {
      const bool from_ground = is_ground(spring.from.value), to_ground = is_ground(spring.to.value);
      if (from_ground && to_ground) {
        issues_.add(spring.from.location, spring.from.path + ": the spring connects two grounds", "it has no effect",
                    "");
        continue;
      }
      const auto first = spring_end(from_ground ? spring.to : spring.from);
      NodalSpring nodal{spring_name(spring), first.value_or(NodalDof{}), {}, "ground", spring.stiffness,
                        spring.damping};
      if (from_ground || to_ground)
        nodal.ground = (from_ground ? spring.from : spring.to).value;
      else
        nodal.to = spring_end(spring.to);
      if (first && (nodal.to || from_ground || to_ground)) model_.springs.push_back(nodal);
    }
  }

  /// Nodes of a group of the mesh, or one named node.
  std::vector<Index> node_group(const Located<std::string>& place) {
    if (const auto set = model_.mesh.node_sets.find(place.value); set != model_.mesh.node_sets.end())
      return set->second;
    const Index node = find_node(place.value, place.location, place.path);
    return node < 0 ? std::vector<Index>{} : std::vector<Index>{node};
  }

  void add_links_and_supports() {
    for (const auto& [name, link] : fe_.links) {
      const Index master = find_node(link.master.value, link.master.location, link.master.path);
      auto slaves = node_group(link.nodes);
      if (std::erase(slaves, master) > 0 && slaves.empty())
        issues_.add(link.nodes.location, link.nodes.path + ": '" + link.nodes.value + "' holds the master alone",
                    "a node cannot follow itself", "name a group of other nodes");
      if (master >= 0 && !slaves.empty()) model_.links.push_back({name, master, slaves, chosen(link.directions)});
    }
    for (const auto& [name, fixed] : fe_.fixed)
      if (const auto nodes = node_group(fixed.nodes); !nodes.empty())
        model_.fixed.push_back({name, nodes, chosen(fixed.directions)});
  }

  [[nodiscard]] std::map<std::string, std::vector<Index>> cells_of_load_groups() const {
    std::map<std::string, std::vector<Index>> groups;
    for (const auto& group : used_.loaded)
      if (const auto region = model_.mesh.regions.find(group); region != model_.mesh.regions.end())
        groups.insert(*region);
    return groups;
  }

  /// Removes groups of cells that only name nodes for supports, links, loads or boundaries: they need no property.
  void forget_groups_of_nodes() {
    const auto forget = [&](const std::string& group) {
      if (!model_.properties.contains(group)) model_.mesh.regions.erase(group);
    };
    for (const auto& [name, link] : fe_.links) forget(link.nodes.value);
    for (const auto& [name, fixed] : fe_.fixed) forget(fixed.nodes.value);
    for (const auto& group : used_.loaded) forget(group);
    for (const auto& group : used_.joined) forget(group.value);
    if (given_.reduction)
      for (const auto& place : given_.reduction->value.boundary) forget(place.value);
  }

  const std::string& name_;
  const d::Substructure& given_;
  const d::FiniteElements& fe_;
  const UsedGroups& used_;
  DeckFiles& decks_;
  FiniteElementModel model_;
  std::vector<DeckNote> notes_;
  std::vector<LoadCase> deck_cases_;
  std::optional<LoadCase> deck_preload_;
  std::vector<NamedNode> nodes_;
  std::vector<StrainGauge> gauges_;
  IssueList issues_;
  bool has_places_ = true;  ///< matrices alone may have none
};

}  // namespace

NamedElements build_finite_elements(const std::string& name, const d::Substructure& given, const UsedGroups& used,
                                    DeckFiles& decks) {
  return Builder(name, given, used, decks).build();
}

}  // namespace kalfem
