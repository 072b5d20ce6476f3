#include "kalfem/formats/abaqus/elements.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/formats/abaqus/orientations.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

bool is_spring(Family family) {
  return family == Family::ground_spring || family == Family::spring || family == Family::axial_spring;
}
bool is_dashpot(Family family) {
  return family == Family::ground_dashpot || family == Family::dashpot || family == Family::axial_dashpot;
}
bool is_axial(Family family) { return family == Family::axial_spring || family == Family::axial_dashpot; }
bool is_grounded(Family family) { return family == Family::ground_spring || family == Family::ground_dashpot; }

/// What *SPRING or *DASHPOT says: directions of its ends and its value.
struct SpringData {
  std::array<int, 2> directions{};
  double value = 0.0;
};

// The table is sorted by deflection; the piece that holds zero, or the last one before it, gives the slope.
/// The slope at no deflection of pairs of force and deflection.
double slope_at_rest(PlacedDeck& deck, const Block& block) {
  std::vector<std::pair<double, double>> points;
  for (std::size_t i = 1; i < block.lines.size(); ++i)
    if (block.lines[i].fields.size() > 1)
      points.emplace_back(number_or(block.lines[i], 1, 0.0, "a deflection", deck.problems),
                          number_or(block.lines[i], 0, 0.0, "a force", deck.problems));
  std::ranges::sort(points);
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    if (points[i + 1].first > 0.0 || i + 2 == points.size())
      if (const double step = points[i + 1].first - points[i].first; step > 0.0)
        return (points[i + 1].second - points[i].second) / step;
  return 0.0;
}

/// First line: directions of the ends, blank for axial ones; second: the value. Decks leave out the blank line.
std::optional<SpringData> spring_data(PlacedDeck& deck, const Block& block, Family family) {
  SpringData data;
  std::size_t value_line = 1;
  const auto& lines = block.lines;
  if (is_axial(family)) {
    if (!lines.empty() && !lines[0].field(0).empty() && (lines.size() == 1 || line_of(block, 1).field(0).empty()))
      value_line = 0;
  } else {
    const auto& line = line_of(block, 0);
    for (std::size_t end = 0; end < (is_grounded(family) ? 1u : 2u); ++end) {
      const auto direction =
          end == 1 && line.field(1).empty() ? to_integer(line.field(0)) : to_integer(line.field(end));
      if (!direction || *direction < 1 || *direction > 6) {
        deck.problems.add(lines.empty() ? block.keyword.where : line.where, block.keyword.title + " has no direction",
                          "the direction (1 to 6) states the axis along or about which it acts",
                          "write the direction on the first data line");
        return {};
      }
      data.directions[end] = static_cast<int>(*direction) - 1;
    }
  }
  if (block.keyword.has("NONLINEAR")) {
    data.value = slope_at_rest(deck, block);
    deck.notes.add(deck.problems.location(block.keyword.where), block.keyword.title + ", NONLINEAR",
                   "only the slope at rest is used");
    return data;
  }
  if (value_line >= lines.size()) {
    deck.problems.add(block.keyword.where, block.keyword.title + " has no value", "",
                      "write it on the second data line");
    return {};
  }
  const auto value = number_at(lines[value_line], 0, "a stiffness or damping", deck.problems);
  if (!value) return {};
  data.value = *value;
  return data;
}

/// Makes the springs and joints of the model.
class SpringMaker {
public:
  SpringMaker(PlacedDeck& deck, FiniteElementModel& model) : deck_(deck), model_(model) {}

  void add(const PlacedElement& element, const PlacedBlock& at, const std::string& set, const SpringData& data);

private:
  void add_axial(const PlacedElement& element, const std::string& name, const std::vector<Index>& nodes,
                 double stiffness, double damping);

  PlacedDeck& deck_;
  FiniteElementModel& model_;
};

// Deformation d = e . (u2 - u1) with e the unit vector between the nodes, as in small displacements.
void SpringMaker::add_axial(const PlacedElement& element, const std::string& name, const std::vector<Index>& nodes,
                            double stiffness, double damping) {
  const Eigen::Vector3d along = deck_.mesh.nodes.col(nodes[1]) - deck_.mesh.nodes.col(nodes[0]);
  if (!(along.norm() > 0.0)) {
    deck_.problems.add(element.raw->where,
                       "the nodes of " + deck_.type_name(element) + " " + deck_.element_name(element) + " coincide",
                       "it acts along the line between its nodes", "use SPRING2 or DASHPOT2 with a direction");
    return;
  }
  JointSpring joint{name, {}, stiffness, damping};
  for (int a = 0; a < 3; ++a)
    if (const double share = along[a] / along.norm(); share != 0.0) {
      joint.deformation.push_back({{nodes[1], a}, share});
      joint.deformation.push_back({{nodes[0], a}, -share});
    }
  model_.joints.push_back(std::move(joint));
}

// A spring along global axes connects two degrees of freedom directly. With an ORIENTATION its direction is a sum of
// global components, and it becomes a joint with k c c^T.
void SpringMaker::add(const PlacedElement& element, const PlacedBlock& at, const std::string& set,
                      const SpringData& data) {
  std::vector<Index> nodes;
  if (!deck_.nodes_of(element, nodes)) return;
  const Family family = deck_.type_of(element).family;
  const std::string name = set + "." + std::to_string(element.raw->label);
  const double stiffness = is_spring(family) ? data.value : 0.0, damping = is_spring(family) ? 0.0 : data.value;
  if (is_axial(family)) return add_axial(element, name, nodes, stiffness, damping);
  const std::string orientation = at.block->keyword.get("ORIENTATION");
  if (orientation.empty()) {
    NodalSpring spring{name, {nodes[0], data.directions[0]}, {}, "ground", stiffness, damping};
    if (!is_grounded(family)) spring.to = NodalDof{nodes[1], data.directions[1]};
    model_.springs.push_back(std::move(spring));
    return;
  }
  const LocalAxes axes = orientation_axes(deck_, orientation, at.place, at.block->keyword.where);
  JointSpring joint{name, {}, stiffness, damping};
  for (std::size_t end = 0; end < nodes.size(); ++end) {
    const int block = data.directions[end] < 3 ? 0 : 3;
    const Eigen::Vector3d axis = axes.at(deck_.mesh.nodes.col(nodes[end])).col(data.directions[end] - block);
    for (int a = 0; a < 3; ++a)
      if (axis[a] != 0.0) joint.deformation.push_back({{nodes[end], block + a}, end == 0 ? axis[a] : -axis[a]});
  }
  model_.joints.push_back(std::move(joint));
}

}  // namespace

// Springs come first, then dashpots. *SPRING and *DASHPOT apply to the elements of their family in ELSET; an element
// set can hold both. Values are read once for each family of a block. Elements that no keyword covers are told by the
// first of them.
void add_springs(PlacedDeck& deck, FiniteElementModel& model) {
  SpringMaker maker(deck, model);
  std::vector<bool> given(deck.elements.size(), false);
  for (const bool springs : {true, false})
    for (const auto& at : deck.blocks(springs ? "SPRING" : "DASHPOT")) {
      const Keyword& keyword = at.block->keyword;
      const std::string set = deck.spelled_set(keyword.get("ELSET"), at.place, false);
      std::map<Family, std::optional<SpringData>> data;
      for (const Index index : deck.element_list({keyword.get("ELSET"), keyword.where}, at.place)) {
        const auto& element = deck.elements[static_cast<std::size_t>(index)];
        const Family family = deck.type_of(element).family;
        if (springs ? !is_spring(family) : !is_dashpot(family)) continue;
        if (!data.contains(family)) data[family] = spring_data(deck, *at.block, family);
        given[static_cast<std::size_t>(index)] = true;
        if (data[family]) maker.add(element, at, set, *data[family]);
      }
    }
  for (std::size_t i = 0; i < deck.elements.size(); ++i) {
    const Family family = deck.type_of(deck.elements[i]).family;
    if ((is_spring(family) || is_dashpot(family)) && !given[i]) {
      deck.problems.add(deck.elements[i].raw->where,
                        deck.type_name(deck.elements[i]) + " " + deck.element_name(deck.elements[i]) + " has no " +
                            (is_spring(family) ? "*SPRING" : "*DASHPOT"),
                        "it needs a stiffness or a damping", "give one for its ELSET");
      break;
    }
  }
}

namespace {

/// Reports the first element of a family whose keyword is missing.
void report_missing(PlacedDeck& deck, const std::vector<bool>& given, Family family, const char* keyword) {
  for (std::size_t i = 0; i < deck.elements.size(); ++i)
    if (deck.type_of(deck.elements[i]).family == family && !given[i]) {
      deck.problems.add(
          deck.elements[i].raw->where,
          deck.type_name(deck.elements[i]) + " " + deck.element_name(deck.elements[i]) + " has no " + keyword,
          "the model would be incomplete without it", std::string("give ") + keyword + " for its ELSET");
      return;
    }
}

/// Three masses along the axes, of *MASS, TYPE=ANISOTROPIC.
NodalMatrices directional_mass(const std::string& name, Index node, const Eigen::Matrix3d& mass) {
  NodalMatrices matrices;
  matrices.name = name;
  for (int a = 0; a < 3; ++a) matrices.dofs.push_back({node, a});
  matrices.mass = mass.sparseView();
  return matrices;
}

// TYPE=ANISOTROPIC has one mass in each direction: M = A diag(m) A^T with the axes of the instance or orientation.
void add_mass(PlacedDeck& deck, const PlacedBlock& at, const PlacedElement& element, const std::string& name,
              Index node, FiniteElementModel& model) {
  const auto& line = line_of(*at.block, 0);
  const auto mass = number_at(line, 0, "a mass", deck.problems);
  if (!mass) return;
  if (at.block->keyword.word("TYPE") != "ANISOTROPIC") {
    model.masses.push_back({name, node, *mass});
    return;
  }
  const Eigen::Vector3d along(*mass, number_or(line, 1, 0.0, "a mass", deck.problems),
                              number_or(line, 2, 0.0, "a mass", deck.problems));
  Eigen::Matrix3d axes = deck.place(element.place).motion.linear();
  if (!at.block->keyword.get("ORIENTATION").empty())
    axes = orientation_axes(deck, at.block->keyword.get("ORIENTATION"), at.place, at.block->keyword.where)
               .at(deck.mesh.nodes.col(node));
  model.matrices.push_back(directional_mass(name, node, axes * along.asDiagonal() * axes.transpose()));
}

/// I11 I22 I33 I12 I13 I23: components of the tensor, in the axes of the instance or of an orientation.
void add_inertia(PlacedDeck& deck, const PlacedBlock& at, const PlacedElement& element, const std::string& name,
                 Index node, FiniteElementModel& model) {
  const auto& line = line_of(*at.block, 0);
  std::array<double, 6> c{};
  for (std::size_t i = 0; i < 6; ++i) c[i] = number_or(line, i, 0.0, "a moment of inertia", deck.problems);
  Eigen::Matrix3d inertia;
  inertia << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];
  Eigen::Matrix3d axes = deck.place(element.place).motion.linear();
  if (!at.block->keyword.get("ORIENTATION").empty())
    axes = orientation_axes(deck, at.block->keyword.get("ORIENTATION"), at.place, at.block->keyword.where)
               .at(deck.mesh.nodes.col(node));
  const Eigen::Matrix3d turned = axes * inertia * axes.transpose();
  model.masses.push_back({name, node, 0.0, 0.5 * (turned + turned.transpose())});
}

/// Length, area or volume of a cell: of solids by splitting them into tetrahedra about their centre.
double extent(const Mesh& mesh, const Cell& cell) {
  const auto nodes = mesh.nodes_of(cell);
  const auto at = [&](std::size_t i) -> Eigen::Vector3d { return mesh.nodes.col(nodes[i]); };
  const auto triangle = [&](std::size_t i, std::size_t j, std::size_t k) -> Eigen::Vector3d {
    return 0.5 * (at(j) - at(i)).cross(at(k) - at(i));
  };
  const auto quad = [&](std::size_t i, std::size_t j, std::size_t k, std::size_t l) -> Eigen::Vector3d {
    return 0.5 * (at(k) - at(i)).cross(at(l) - at(j));
  };
  const int dimension = kalfem::dimension(cell.shape), corners = corner_count(cell.shape);
  if (dimension == 1) return (at(1) - at(0)).norm();
  if (dimension == 2) return corners == 3 ? triangle(0, 1, 2).norm() : quad(0, 1, 2, 3).norm();
  // The flux of x / 3 through the faces, seen from the first corner.
  const auto flux = [&](const Eigen::Vector3d& area, std::initializer_list<std::size_t> face) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const auto corner : face) centre += at(corner) - at(0);
    return area.dot(centre) / (3.0 * static_cast<double>(face.size()));
  };
  if (corners == 4) return std::abs(triangle(1, 2, 3).dot(at(1) - at(0))) / 3.0;
  if (corners == 6)
    return std::abs(flux(triangle(3, 4, 5), {3, 4, 5}) + flux(quad(1, 2, 5, 4), {1, 2, 5, 4}) +
                    flux(quad(0, 1, 4, 3), {0, 1, 4, 3}) + flux(quad(2, 0, 3, 5), {2, 0, 3, 5}));
  return std::abs(flux(quad(4, 5, 6, 7), {4, 5, 6, 7}) + flux(quad(0, 1, 5, 4), {0, 1, 5, 4}) +
                  flux(quad(1, 2, 6, 5), {1, 2, 6, 5}) + flux(quad(2, 3, 7, 6), {2, 3, 7, 6}) +
                  flux(quad(3, 0, 4, 7), {3, 0, 4, 7}));
}

}  // namespace

void add_masses(PlacedDeck& deck, FiniteElementModel& model) {
  std::vector<bool> given(deck.elements.size(), false);
  std::vector<Index> nodes;
  for (const bool masses : {true, false})
    for (const auto& at : deck.blocks(masses ? "MASS" : "ROTARYINERTIA")) {
      const Keyword& keyword = at.block->keyword;
      const std::string set = deck.spelled_set(keyword.get("ELSET"), at.place, false);
      for (const Index index : deck.element_list({keyword.get("ELSET"), keyword.where}, at.place)) {
        const auto& element = deck.elements[static_cast<std::size_t>(index)];
        if (deck.type_of(element).family != (masses ? Family::mass : Family::rotary_inertia)) continue;
        given[static_cast<std::size_t>(index)] = true;
        if (!deck.nodes_of(element, nodes)) continue;
        const std::string name = set + "." + std::to_string(element.raw->label);
        masses ? add_mass(deck, at, element, name, nodes.front(), model)
               : add_inertia(deck, at, element, name, nodes.front(), model);
      }
    }
  report_missing(deck, given, Family::mass, "*MASS");
  report_missing(deck, given, Family::rotary_inertia, "*ROTARY INERTIA");
}

// Spreads the mass over cells in proportion to their size, then equally over the corners of a cell. UNITS=TOTAL MASS
// gives the whole; otherwise the value is a mass per length, area or volume.
void add_nonstructural_masses(PlacedDeck& deck, FiniteElementModel& model) {
  std::map<Index, double> at_node;
  for (const auto& at : deck.blocks("NONSTRUCTURALMASS")) {
    const Keyword& keyword = at.block->keyword;
    const auto value = number_at(line_of(*at.block, 0), 0, "a mass", deck.problems);
    const std::string units = keyword.word("UNITS");
    if (!value) continue;
    double total = 0.0;
    std::vector<Index> cells;
    for (const Index index : deck.element_list({keyword.get("ELSET"), keyword.where}, at.place))
      if (const Index cell = deck.elements[static_cast<std::size_t>(index)].cell; cell >= 0) {
        cells.push_back(cell);
        total += extent(model.mesh, model.mesh.cells[static_cast<std::size_t>(cell)]);
      }
    if (!(total > 0.0)) {
      deck.problems.add(keyword.where, "*NONSTRUCTURAL MASS is spread over no elements", "",
                        "name shells, beams or solids by ELSET");
      continue;
    }
    const double density = units == "TOTALMASS" ? *value / total : *value;
    deck.notes.add(deck.problems.location(keyword.where), "*NONSTRUCTURAL MASS",
                   "it is replaced by masses at the nodes");
    for (const Index cell : cells) {
      const auto& item = model.mesh.cells[static_cast<std::size_t>(cell)];
      const auto corners = model.mesh.nodes_of(item).first(static_cast<std::size_t>(corner_count(item.shape)));
      for (const Index node : corners)
        at_node[node] += density * extent(model.mesh, item) / static_cast<double>(corners.size());
    }
  }
  for (const auto& [node, mass] : at_node)
    model.masses.push_back(
        {"nonstructural.n" + std::to_string(deck.mesh.node_ids[static_cast<std::size_t>(node)]), node, mass});
}

}  // namespace kalfem::abaqus
