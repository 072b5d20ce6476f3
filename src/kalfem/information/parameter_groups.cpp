// SPDX-License-Identifier: Apache-2.0
#include "kalfem/information/parameter_groups.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

struct Groups {
  std::vector<std::vector<Index>> members;
  MatrixXd information;  ///< per relative change of a group

  [[nodiscard]] double alikeness(Index i, Index j) const {
    return information(i, j) / std::sqrt(information(i, i) * information(j, j));
  }

  /// Group j goes into group i: one change moves the members of both.
  void join(Index i, Index j) {
    auto& into = members[static_cast<std::size_t>(i)];
    const auto& from = members[static_cast<std::size_t>(j)];
    into.insert(into.end(), from.begin(), from.end());
    information.row(i) += information.row(j);
    information.col(i) += information.col(j);
    remove(j);
  }

  void remove(Index j) {
    members.erase(members.begin() + j);
    std::vector<Index> kept;
    for (Index i = 0; i < information.rows(); ++i)
      if (i != j) kept.push_back(i);
    information = MatrixXd(information(kept, kept));
  }
};

/// The combination that is determined least; nothing where all are determined.
std::optional<ParameterCombination> least_determined(const Groups& groups, const IdentifiabilityOptions& options) {
  const std::vector<InformedParameter> changes(groups.members.size(),
                                               {"", 1.0, std::numeric_limits<double>::infinity()});
  const auto told = identifiability(groups.information, changes, options);
  const auto& last = told.combinations.back();
  return last.determined ? std::nullopt : std::optional(last);
}

/// Joins or holds members of an undetermined combination.
void mend(const ParameterCombination& combination, const IdentifiabilityOptions& options, Groups& groups,
          std::vector<Index>& hold) {
  const double least = options.significant * combination.direction.cwiseAbs().maxCoeff();
  std::vector<Index> taking_part;
  for (Index i = 0; i < combination.direction.size(); ++i)
    if (std::abs(combination.direction[i]) >= least) taking_part.push_back(i);
  double best = 0.0;
  std::pair<Index, Index> pair{-1, -1};
  for (const Index i : taking_part)
    for (const Index j : taking_part)
      if (i < j && groups.information(i, i) > 0.0 && groups.information(j, j) > 0.0 && groups.alikeness(i, j) > best) {
        best = groups.alikeness(i, j);
        pair = {i, j};
      }
  if (pair.first >= 0) return groups.join(pair.first, pair.second);
  const Index least_told =
      *std::ranges::min_element(taking_part, {}, [&](Index i) { return groups.information(i, i); });
  const auto& held = groups.members[static_cast<std::size_t>(least_told)];
  hold.insert(hold.end(), held.begin(), held.end());
  groups.remove(least_told);
}

}  // namespace

ParameterGrouping propose_groups(const MatrixXd& information, const std::vector<InformedParameter>& parameters,
                                 const IdentifiabilityOptions& options) {
  const Identifiability told = identifiability(information, parameters, options);
  Eigen::VectorXd values(std::ssize(parameters));
  Groups groups;
  for (Index i = 0; i < values.size(); ++i) {
    const double value = std::abs(parameters[static_cast<std::size_t>(i)].value);
    values[i] = value > 0.0 ? value : told.scale[i];
    groups.members.push_back({i});
  }
  groups.information = values.asDiagonal() * information * values.asDiagonal();
  ParameterGrouping proposal;
  while (!groups.members.empty()) {
    const auto combination = least_determined(groups, options);
    if (!combination) break;
    mend(*combination, options, groups, proposal.hold);
  }
  for (auto& members : groups.members) std::ranges::sort(members);
  std::ranges::sort(groups.members);
  std::ranges::sort(proposal.hold);
  proposal.groups = std::move(groups.members);
  return proposal;
}

}  // namespace kalfem
