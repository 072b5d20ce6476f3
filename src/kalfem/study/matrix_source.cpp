// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/finite_element_builder.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "kalfem/base/units.hpp"
#include "kalfem/formats/matrices/matrix_model.hpp"
#include "kalfem/formats/tables/csv.hpp"
#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/unit_system.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
namespace d = description;

MatrixModel read_set(const d::MatrixSet& set) {
  SuperelementReadOptions options{.stiffness = set.stiffness, .mass = set.mass, .damping = set.damping};
  if (set.dofs) options.dof_map = set.dofs->value;
  options.map.directions = set.directions;
  std::vector<std::filesystem::path> files;
  for (const auto& file : set.files) files.push_back(file.value);
  MatrixModel model = read_superelement(files, options);
  if (model.dofs.empty())
    throw InvalidInput(set.files.front().issue("the files do not state the degrees of freedom of their rows",
                                               "nodes and directions are needed to name places",
                                               "give `dofs`: a list of node.direction, or of nodes with `directions`"));
  return model;
}

/// Numbers the nodes of the model in the order of their appearance. Nodes of the other code come first. Generalised
/// coordinates and further copies of a node then get nodes of their own, one set of matrices at a time.
class NodeNumbering {
public:
  explicit NodeNumbering(Mesh& mesh) : mesh_(mesh) {}

  /// Adds the nodes of the other code. Call it for all sets first: further nodes are numbered beyond these.
  void add_nodes(const std::vector<MatrixDof>& dofs) {
    for (const auto& dof : dofs)
      if (dof.direction >= 0 && dof.copy < 2) node(dof.node);
  }

  std::vector<NodalDof> nodal(const std::vector<MatrixDof>& dofs) {
    std::map<MatrixDof, Index> own;  // generalised coordinates and copies belong to one set
    std::vector<NodalDof> result;
    for (const auto& dof : dofs) {
      if (dof.direction >= 0 && dof.copy < 2) {
        result.push_back({node(dof.node), dof.direction});
        continue;
      }
      const auto [place, is_new] = own.try_emplace({dof.node, std::min(dof.direction, 0), dof.copy}, 0);
      if (is_new) {
        place->second = node(largest_ + 1);
        if (dof.direction < 0) mesh_.node_sets[scalar_points].push_back(place->second);
      }
      result.push_back({place->second, std::max(dof.direction, 0)});
    }
    return result;
  }

  void place_nodes(const std::optional<Located<std::filesystem::path>>& coordinates, double length) {
    mesh_.nodes = Eigen::Matrix3Xd::Zero(3, static_cast<Index>(mesh_.node_ids.size()));
    if (!coordinates) return;
    const CsvTable table = read_csv_table(coordinates->value);
    if (table.values.cols() < 4)
      throw InvalidInput(coordinates->issue("the table has " + std::to_string(table.values.cols()) + " columns",
                                            "a node needs a number, x, y and z", "give these four columns"));
    const Eigen::Vector3d factors = length_factors(table, length, *coordinates);
    for (Index row = 0; row < table.values.rows(); ++row)
      if (const auto found = index_.find(std::llround(table.values(row, 0))); found != index_.end())
        mesh_.nodes.col(found->second) = factors.cwiseProduct(table.values.row(row).segment<3>(1).transpose());
  }

private:
  /// Factor to metres: the unit in a column's title, "x [mm]", or the length unit of the matrices.
  static Eigen::Vector3d length_factors(const CsvTable& table, double length,
                                        const Located<std::filesystem::path>& coordinates) {
    Eigen::Vector3d factors = Eigen::Vector3d::Constant(length);
    IssueList issues;
    for (Index i = 0; i < 3; ++i) {
      const Channel& column = table.columns[static_cast<std::size_t>(i) + 1];
      try {
        if (!column.unit.empty()) factors[i] = parse_unit_as(column.unit, "m").factor;
      } catch (const InvalidInput& error) {
        issues.add({coordinates.value.string(), table.title_line}, "column '" + column.name + "': " + error.what(),
                   "a coordinate must be a length", "correct its title");
      }
    }
    issues.raise();
    return factors;
  }

  Index node(std::int64_t id) {
    const auto [place, is_new] = index_.try_emplace(id, static_cast<Index>(mesh_.node_ids.size()));
    if (is_new) mesh_.node_ids.push_back(id);
    largest_ = std::max(largest_, id);
    return place->second;
  }

  Mesh& mesh_;
  std::map<std::int64_t, Index> index_;
  std::int64_t largest_ = 0;
};

NodalMatrices in_si(const std::string& name, const MatrixModel& given, std::vector<NodalDof> dofs,
                    const UnitSystem& units) {
  std::vector<int> directions;
  for (const auto& dof : given.dofs) directions.push_back(dof.direction);
  const Eigen::VectorXd factors = unit_factors(directions, units);
  return {name, std::move(dofs), scaled(given.model.stiffness, units.mass / (units.time * units.time), factors),
          scaled(given.model.mass, units.mass, factors), scaled(given.model.damping, units.mass / units.time, factors)};
}

}  // namespace

Deck matrices_as_deck(const d::MatrixFiles& files) {
  IssueList issues;
  std::vector<MatrixModel> sets;
  for (const auto& set : files.sets) try {
      sets.push_back(read_set(set));
    } catch (const InvalidInput& error) {
      issues.add(error, set.files.front().location);
    }
  issues.raise();

  Deck deck;
  const std::string source = files.sets.front().files.front().value.string();
  deck.model.mesh.source = source;
  NodeNumbering numbering(deck.model.mesh);
  for (const auto& set : sets) numbering.add_nodes(set.dofs);
  for (std::size_t i = 0; i < sets.size(); ++i) {
    deck.model.matrices.push_back(
        in_si("set" + std::to_string(i + 1), sets[i], numbering.nodal(sets[i].dofs), files.units));
    for (const auto& note : sets[i].notes) deck.notes.push_back({{source, 0}, note, "", 1});
  }
  numbering.place_nodes(files.coordinates, files.units.length);
  return deck;
}

}  // namespace kalfem
