// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/constraint_elimination.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kalfem {

namespace {

/// A coefficient below this share of the equation's largest is rounding.
constexpr double coefficient_rounding = 1e-11;

double largest(const std::map<NodalDof, double>& terms) {
  double value = 0.0;
  for (const auto& [dof, coefficient] : terms) value = std::max(value, std::abs(coefficient));
  return value;
}

void drop_below(std::map<NodalDof, double>& terms, double limit) {
  std::erase_if(terms, [&](const auto& term) { return std::abs(term.second) <= limit; });
}

}  // namespace

// Of nearly equal coefficients the first is taken, so that the choice does not depend on rounding.
NodalDof ReducedEquations::pivot_of(const std::map<NodalDof, double>& terms,
                                    const std::optional<NodalDof>& preferred) const {
  const double least = 1e-6 * largest(terms);
  const auto can_follow = [&](const auto& term) {
    return std::abs(term.second) > least && !leading_.contains(term.first);
  };
  const bool any_follows = std::ranges::any_of(terms, can_follow);
  const auto is_candidate = [&](const auto& term) { return !any_follows || can_follow(term); };
  if (preferred)
    if (const auto found = terms.find(*preferred);
        found != terms.end() && std::abs(found->second) > least && is_candidate(*found))
      return *preferred;
  const std::pair<const NodalDof, double>* pivot = nullptr;
  for (const auto& term : terms)
    if (is_candidate(term) && (!pivot || std::abs(pivot->second) < std::abs(term.second) * (1.0 - 1e-9))) pivot = &term;
  return pivot->first;
}

// One step of Gauss-Jordan elimination, kept reduced: every row has the coefficient 1 at its pivot, and no other row
// contains that pivot.
// 1. Add equal terms and substitute the pivots of earlier rows. If only rounding is left, the equation is redundant.
// 2. Choose the pivot: the preferred degree of freedom unless its coefficient is negligible, otherwise the largest.
// 3. Divide by the pivot's coefficient and substitute the new row into the earlier ones that contain the pivot.
bool ReducedEquations::add(const std::string& name, const DofSum& given, std::optional<NodalDof> preferred,
                           const SourceLocation& where) {
  std::map<NodalDof, double> terms;
  double scale = 0.0;
  for (const auto& [dof, coefficient] : given) {
    terms[dof] += coefficient;
    scale = std::max(scale, std::abs(coefficient));
  }
  // Pivots of earlier equations are replaced; what comes in with them is no pivot.
  for (const auto& [dof, coefficient] : std::map(terms)) {
    const auto earlier = row_of_pivot_.find(dof);
    if (earlier == row_of_pivot_.end()) continue;
    for (const auto& [other, share] : rows_[earlier->second].terms) terms[other] -= coefficient * share;
    terms.erase(dof);
  }
  drop_below(terms, coefficient_rounding * scale);
  if (terms.empty()) return false;

  const NodalDof pivot = pivot_of(terms, preferred);
  const double divisor = terms.at(pivot);
  for (auto& [dof, coefficient] : terms) coefficient /= divisor;
  drop_below(terms, coefficient_rounding * largest(terms));

  const std::size_t index = rows_.size();
  for (const std::size_t row : std::exchange(rows_with_[pivot], {})) {
    auto& others = rows_[row].terms;
    const auto held = others.find(pivot);
    if (held == others.end()) continue;
    const double factor = held->second;
    others.erase(held);
    for (const auto& [dof, coefficient] : terms) {
      if (dof == pivot) continue;
      others[dof] -= factor * coefficient;
      rows_with_[dof].push_back(row);
    }
    drop_below(others, coefficient_rounding * largest(others));
  }
  for (const auto& [dof, coefficient] : terms) rows_with_[dof].push_back(index);
  row_of_pivot_[pivot] = index;
  rows_.push_back({name, std::move(terms), pivot, where});
  return true;
}

// A row of the pivot alone states u = 0 and becomes a support; all directions of one name and node share one.
void ReducedEquations::store(FiniteElementModel& model) const {
  std::map<std::pair<std::string, Eigen::Index>, std::size_t> fixed_at;
  for (const auto& row : rows_) {
    if (row.terms.size() == 1) {
      const auto [place, is_new] = fixed_at.try_emplace({row.name, row.pivot.node}, model.fixed.size());
      if (is_new) model.fixed.push_back({row.name, {row.pivot.node}, {}});
      model.fixed[place->second].directions[static_cast<std::size_t>(row.pivot.direction)] = true;
      continue;
    }
    MultiPointConstraint constraint{row.name, {{row.pivot, 1.0}}, row.where};
    for (const auto& [dof, coefficient] : row.terms)
      if (dof != row.pivot) constraint.terms.emplace_back(dof, coefficient);
    model.constraints.push_back(std::move(constraint));
  }
}

}  // namespace kalfem
