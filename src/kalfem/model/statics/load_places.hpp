// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/model/assembly/fe_linear_model.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem {

/// The nodes and faces of a model that loads name. Keeps references to what it is made of.
class LoadPlaces {
public:
  /// `nodes`: that have names; `groups`: cells of lines and surfaces, by name.
  LoadPlaces(const FiniteElementModel& model, const std::vector<NamedNode>& nodes,
             const std::map<std::string, std::vector<Eigen::Index>>& groups);

  /// Nodes with the part of a load that each takes: a named node, a node number, a group of lines or surfaces, over
  /// which it is spread evenly, or a group of nodes, which share it equally. Nothing: there is none of that name.
  [[nodiscard]] std::optional<std::map<Eigen::Index, double>> shares(const std::string& place) const;

  /// Whether a group has that name.
  [[nodiscard]] bool has_group(const std::string& name) const;
  /// Faces of a group on which pressure acts, see faces_of_cells(). Empty: there are none.
  [[nodiscard]] std::vector<LoadedFace> faces(const std::string& group) const;

  /// "tip.z" of a named node. Nothing: the direction or the node is unknown.
  [[nodiscard]] std::optional<NodalDof> dof(const std::string& name) const;

  /// The named node; null: there is none.
  [[nodiscard]] const NamedNode* node(const std::string& name) const;
  /// " (did you mean 'tip'?)" of all names.
  [[nodiscard]] std::string hint(const std::string& name) const;

private:
  [[nodiscard]] Eigen::Index numbered(const std::string& word) const;

  const FiniteElementModel& model_;
  const std::vector<NamedNode>& nodes_;
  const std::map<std::string, std::vector<Eigen::Index>>& groups_;
  NodeFinder finder_;
};

/// Adds a force and moment on a place, each node with its share. False: there is no such place.
bool add_force(const LoadPlaces& places, const std::string& place, const Eigen::Vector3d& force,
               const Eigen::Vector3d& moment, LoadCase& load_case);

}  // namespace kalfem
