// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>

#include "kalfem/base/units.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/formats/matrices/matrix_model.hpp"
#include "kalfem/formats/tables/csv.hpp"
#include "kalfem/model/part_factors.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

MatrixModel read_set(const MatrixSetFiles& set) {
  const MatrixModel model = read_superelement(set.files, {.stiffness = set.stiffness,
                                                          .mass = set.mass,
                                                          .damping = set.damping,
                                                          .dof_map = set.dof_map,
                                                          .map = {set.directions}});
  if (model.dofs.empty())
    throw InvalidInput("the files do not state the degrees of freedom of their rows",
                       "nodes and directions are needed to name places",
                       "give `dofs`: a list of node.direction, or of nodes with `directions`");
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

  void place_nodes(const std::optional<std::filesystem::path>& coordinates, double length) {
    mesh_.nodes = Eigen::Matrix3Xd::Zero(3, static_cast<Index>(mesh_.node_ids.size()));
    if (!coordinates) return;
    const CsvTable table = read_csv_table(*coordinates);
    if (table.values.cols() < 4)
      throw InvalidInput(Issue{{coordinates->string(), table.title_line},
                               "the table has " + std::to_string(table.values.cols()) + " columns",
                               "a node needs a number, x, y and z",
                               "give these four columns"});
    const Eigen::Vector3d factors = length_factors(table, length, *coordinates);
    for (Index row = 0; row < table.values.rows(); ++row)
      if (const auto found = index_.find(std::llround(table.values(row, 0))); found != index_.end())
        mesh_.nodes.col(found->second) = factors.cwiseProduct(table.values.row(row).segment<3>(1).transpose());
  }

private:
  /// Factor to metres: the unit in a column's title, "x [mm]", or the length unit of the matrices.
  static Eigen::Vector3d length_factors(const CsvTable& table, double length,
                                        const std::filesystem::path& coordinates) {
    Eigen::Vector3d factors = Eigen::Vector3d::Constant(length);
    IssueList issues;
    for (Index i = 0; i < 3; ++i) {
      const Channel& column = table.columns[static_cast<std::size_t>(i) + 1];
      try {
        if (!column.unit.empty()) factors[i] = parse_unit_as(column.unit, "m").factor;
      } catch (const InvalidInput& error) {
        issues.add({coordinates.string(), table.title_line}, "column '" + column.name + "': " + error.what(),
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

/// In SI, over degrees of freedom of these directions.
SparseMatrix in_si(const SparseMatrix& matrix, double unit, const std::vector<NodalDof>& dofs,
                   const UnitSystem& units) {
  if (matrix.size() == 0) return matrix;
  std::vector<int> directions;
  for (const auto& dof : dofs) directions.push_back(dof.direction);
  return scaled(matrix, unit, unit_factors(directions, units));
}

NodalMatrices in_si(const std::string& name, const LinearModel& given, std::vector<NodalDof> dofs,
                    const UnitSystem& units) {
  NodalMatrices matrices{name, std::move(dofs), {}, {}, {}};
  matrices.stiffness = in_si(given.stiffness, units.mass / (units.time * units.time), matrices.dofs, units);
  matrices.mass = in_si(given.mass, units.mass, matrices.dofs, units);
  matrices.damping = in_si(given.damping, units.mass / units.time, matrices.dofs, units);
  return matrices;
}

/// The matrix of that name, or the only one of the file.
ForeignMatrix read_one(const NamedMatrixFile& given) {
  MatrixReadOptions options;
  if (!given.name.empty()) options.names = {given.name};
  auto all = read_matrices(given.file, options);
  if (all.size() == 1) return std::move(all.front());
  std::string names;
  for (const auto& each : all) names += (names.empty() ? "" : ", ") + each.name;
  throw InvalidInput(Issue{{given.file.string(), 0},
                           "the file holds " + std::to_string(all.size()) + " matrices: " + names,
                           "a factor multiplies one",
                           "name it: {file: ..., name: ...}"});
}

/// Nodes and directions of rows, by the numbers of the nodes.
std::vector<NodalDof> nodal(const std::vector<MatrixDof>& dofs, const Mesh& mesh) {
  const NodeFinder finder(mesh);
  std::vector<NodalDof> result;
  IssueList issues;
  for (const auto& dof : dofs) {
    const Index node = dof.direction < 0 || dof.copy > 1 ? -1 : finder.find(dof.node);
    result.push_back({std::max<Index>(node, 0), std::max(dof.direction, 0)});
    if (node >= 0) continue;
    issues.add({}, "a factor's matrices have the row " + dof_name(dof), "the model has no such degree of freedom",
               "give rows of nodes of the model, or matrices in the order of the model's own");
    break;
  }
  issues.raise();
  return result;
}

/// The matrices of the model, where it consists of one set of them; else null.
const NodalMatrices* only_set(const FiniteElementModel& model) {
  const auto is_set = [](const NodalMatrices& each) { return each.factor.empty(); };
  if (!model.properties.empty() || std::ranges::count_if(model.matrices, is_set) != 1) return nullptr;
  return &*std::ranges::find_if(model.matrices, is_set);
}

}  // namespace

Deck read_matrix_deck(const MatrixDeckFiles& files) {
  if (files.sets.empty()) throw InvalidInput("no matrices are given", "stiffness and mass are required", "");
  IssueList issues;
  std::vector<MatrixModel> sets;
  for (const auto& set : files.sets) try {
      sets.push_back(read_set(set));
    } catch (const InvalidInput& error) {
      issues.add(error, set.where);
    }
  issues.raise();

  Deck deck;
  const std::string source = files.sets.front().files.front().string();
  deck.model.mesh.source = source;
  NodeNumbering numbering(deck.model.mesh);
  for (const auto& set : sets) numbering.add_nodes(set.dofs);
  for (std::size_t i = 0; i < sets.size(); ++i) {
    deck.model.matrices.push_back(
        in_si("set" + std::to_string(i + 1), sets[i].model, numbering.nodal(sets[i].dofs), files.units));
    for (const auto& note : sets[i].notes) deck.notes.push_back({{source, 0}, note, "", 1});
  }
  numbering.place_nodes(files.coordinates, files.units.length);
  return deck;
}

void add_matrix_factor(FiniteElementModel& model, const std::string& factor, const FactorMatrixFiles& files,
                       double value) {
  const auto read = [](const auto& file) { return file ? std::optional(read_one(*file)) : std::nullopt; };
  const auto stiffness = read(files.stiffness), mass = read(files.mass), damping = read(files.damping);
  if (!stiffness && !mass && !damping)
    throw InvalidInput("factor '" + factor + "' has no matrix", "it would have no effect",
                       "give `stiffness`, `mass` or `damping`");
  MatrixModelOptions options;
  if (files.dof_map) options.dofs = read_dof_map(*files.dof_map, {files.directions});
  const NodalMatrices* whole = only_set(model);
  const MatrixModel part =
      part_matrices(stiffness, mass, damping, options, whole ? std::optional(std::ssize(whole->dofs)) : std::nullopt);
  auto dofs = part.dofs.empty() ? whole->dofs : nodal(part.dofs, model.mesh);
  add_matrix_factor(model, factor, in_si(factor, part.model, std::move(dofs), files.units), value);
}

}  // namespace kalfem
