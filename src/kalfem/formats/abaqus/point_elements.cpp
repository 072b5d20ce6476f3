// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/elements.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "kalfem/formats/abaqus/orientations.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

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
  const std::string type = at.block->keyword.word("TYPE");
  const bool by_direction = type == "ANISOTROPIC";
  if (!by_direction && !type.empty() && type != "ISOTROPIC")
    deck.problems.add(at.block->keyword.where, "*MASS has TYPE=" + to_string(type),
                      "it must be ISOTROPIC or ANISOTROPIC", "correct it");
  deck.element_masses.push_back({deck.position_of(element), node, *mass, 0.0, by_direction});
  if (!by_direction) {
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
        if (masses) deck.origins.try_emplace(name + ".mass", keyword.where);
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
    static const std::set<std::string, std::less<>> known = {"", "TOTALMASS", "MASSPERVOLUME", "MASSPERAREA",
                                                             "MASSPERLENGTH"};
    if (!known.contains(units))
      deck.problems.add(keyword.where, "*NONSTRUCTURAL MASS has UNITS=" + to_string(units),
                        "it must be TOTAL MASS, MASS PER VOLUME, MASS PER AREA or MASS PER LENGTH", "correct it");
    if (!value) continue;
    double total = 0.0;
    std::vector<std::pair<Index, Index>> cells;  // elements and their cells
    for (const Index index : deck.element_list({keyword.get("ELSET"), keyword.where}, at.place))
      if (const Index cell = deck.elements[static_cast<std::size_t>(index)].cell; cell >= 0) {
        cells.emplace_back(index, cell);
        total += extent(model.mesh, model.mesh.cells[static_cast<std::size_t>(cell)]);
      }
    if (!(total > 0.0)) {
      deck.problems.add(keyword.where, "*NONSTRUCTURAL MASS is spread over no elements", "",
                        "name shells, beams or solids by ELSET");
      continue;
    }
    const double density = units == "TOTALMASS" ? *value / total : *value;
    deck.notes.add(deck.problems.location(keyword.where), "*NONSTRUCTURAL MASS",
                   "it is replaced by masses at the nodes", DeckNoteKind::changed);
    for (const auto& [element, cell] : cells) {
      const auto& item = model.mesh.cells[static_cast<std::size_t>(cell)];
      const auto corners = model.mesh.nodes_of(item).first(static_cast<std::size_t>(corner_count(item.shape)));
      const double share = density * extent(model.mesh, item) / static_cast<double>(corners.size());
      for (const Index node : corners) {
        at_node[node] += share;
        deck.element_masses.push_back({element, node, share});
      }
    }
  }
  for (const auto& [node, mass] : at_node)
    model.masses.push_back(
        {"nonstructural.n" + std::to_string(deck.mesh.node_ids[static_cast<std::size_t>(node)]), node, mass});
}

}  // namespace kalfem::abaqus
