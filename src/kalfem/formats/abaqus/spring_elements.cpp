#include <algorithm>
#include <cmath>

#include "kalfem/formats/abaqus/fields.hpp"
#include "kalfem/formats/abaqus/numbers.hpp"
#include "kalfem/formats/abaqus/orientations.hpp"
#include "kalfem/formats/abaqus/point_elements.hpp"

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
                          "1 to 6 say along or about which axis it acts", "write the direction on the first data line");
        return {};
      }
      data.directions[end] = static_cast<int>(*direction) - 1;
    }
  }
  if (block.keyword.has("NONLINEAR")) {
    data.value = slope_at_rest(deck, block);
    deck.notes.add(deck.problems.location(block.keyword.where), block.keyword.title + ", NONLINEAR",
                   "linear behaviour is used: the slope at rest");
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

void SpringMaker::add_axial(const PlacedElement& element, const std::string& name, const std::vector<Index>& nodes,
                            double stiffness, double damping) {
  const Eigen::Vector3d along = deck_.mesh.nodes.col(nodes[1]) - deck_.mesh.nodes.col(nodes[0]);
  if (!(along.norm() > 0.0)) {
    deck_.problems.add(element.raw->where,
                       "the nodes of " + deck_.type_name(element) + " " + deck_.element_name(element) + " coincide",
                       "it acts along the line between them", "use SPRING2 or DASHPOT2 with a direction");
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
                        "it needs a stiffness or damping", "give one for its ELSET");
      break;
    }
  }
}

}  // namespace kalfem::abaqus
