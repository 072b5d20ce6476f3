// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kalfem/formats/abaqus/elements.hpp"
#include "kalfem/formats/abaqus/orientations.hpp"
#include "kalfem/formats/abaqus/spring_data.hpp"

namespace kalfem::abaqus {

namespace {

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
  JointSpring joint{name, {}, stiffness, damping, true};
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
void add_springs(PlacedDeck& deck, MaterialTemperature& temperature, FiniteElementModel& model) {
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
        if (!data.contains(family)) data[family] = spring_data(deck, *at.block, family, temperature);
        given[static_cast<std::size_t>(index)] = true;
        if (springs)
          deck.origins.try_emplace(set + "." + std::to_string(element.raw->label) + ".stiffness", keyword.where);
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

}  // namespace kalfem::abaqus
