// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Homogeneous linear equations between degrees of freedom, kept in reduced row echelon form: every equation has one
/// degree of freedom, its pivot, that stands in no other equation.
class ReducedEquations {
public:
  /// `leading`: degrees of freedom that others should follow, such as those with an imposed motion; they are pivots
  /// only of equations that hold no others.
  explicit ReducedEquations(std::set<NodalDof> leading = {}) : leading_(std::move(leading)) {}

  /// sum_i coefficient_i z_i = 0. The pivot is `preferred` unless its coefficient vanishes in the reduction, otherwise
  /// the largest one. Returns false where the equation follows from the earlier ones.
  /// `where`: of the equation in a deck, for messages.
  bool add(const std::string& name, const DofSum& terms, std::optional<NodalDof> preferred = std::nullopt,
           const SourceLocation& where = {});

  /// Appends to the model: fixed degrees of freedom where an equation has one term, else constraints, pivot first.
  void store(FiniteElementModel& model) const;

private:
  struct Row {
    std::string name;
    std::map<NodalDof, double> terms;  ///< coefficient of the pivot: 1
    NodalDof pivot;
    SourceLocation where;
  };
  [[nodiscard]] NodalDof pivot_of(const std::map<NodalDof, double>& terms,
                                  const std::optional<NodalDof>& preferred) const;

  std::set<NodalDof> leading_;
  std::vector<Row> rows_;
  std::map<NodalDof, std::size_t> row_of_pivot_;
  std::map<NodalDof, std::vector<std::size_t>> rows_with_;  ///< rows that hold, or once held, a degree of freedom
};

}  // namespace kalfem
