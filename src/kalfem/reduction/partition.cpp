// SPDX-License-Identifier: Apache-2.0
#include "kalfem/reduction/partition.hpp"

#include <unordered_map>
#include <utility>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/sparse_operations.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

constexpr Index unknown = -1, outside = -2;

std::vector<Index> indices_of(const LinearModel& model, const std::vector<std::string>& boundary) {
  std::unordered_map<std::string, Index> known;
  for (const auto& name : boundary) known.emplace(name, unknown);
  for (Index i = 0; i < model.size(); ++i)
    if (const auto found = known.find(model.dofs[static_cast<std::size_t>(i)]); found != known.end()) found->second = i;
  IssueList issues;
  std::vector<Index> indices;
  for (const auto& name : boundary) {
    const auto found = known.find(name);
    if (found->second == unknown)
      issues.add({}, "the model has no degree of freedom '" + name + "'" + did_you_mean(name, model.dofs),
                 "the boundary must consist of degrees of freedom of the model", "name one of them");
    else if (found->second == outside)
      issues.add({}, "the boundary names '" + name + "' twice", "each degree of freedom can be kept only once",
                 "name it once");
    else
      indices.push_back(std::exchange(found->second, outside));
  }
  issues.raise();
  return indices;
}

}  // namespace

Partition partition(const LinearModel& model, const std::vector<std::string>& boundary) {
  Partition parts;
  parts.boundary = indices_of(model, boundary);
  std::vector<bool> kept(model.dofs.size(), false);
  for (const Index i : parts.boundary) kept[static_cast<std::size_t>(i)] = true;
  for (Index i = 0; i < model.size(); ++i) {
    if (kept[static_cast<std::size_t>(i)]) continue;
    parts.interior.push_back(i);
    parts.interior_names.push_back(model.dofs[static_cast<std::size_t>(i)]);
  }
  parts.stiffness_ii = select(model.stiffness, parts.interior, parts.interior);
  parts.mass_ii = select(model.mass, parts.interior, parts.interior);
  parts.stiffness_ib = select(model.stiffness, parts.interior, parts.boundary);
  return parts;
}

}  // namespace kalfem
