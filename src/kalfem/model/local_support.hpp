#pragma once

#include <Eigen/Dense>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Holds motions of a node in axes of its own. `axes` are orthonormal columns: the local axes in global components;
/// `directions` are the three displacements along them and the three rotations about them. What is held,
///     q_i . u = 0 for the held displacements, q_i . theta = 0 for the held rotations,
/// goes into the model as fixed degrees of freedom where an equation names only one, else as multi-point constraints
/// in reduced row echelon form: none of them has the first degree of freedom of another on its right side. Call it once
/// a node, with all that is held there.
void hold_in_axes(FiniteElementModel& model, const std::string& name, Eigen::Index node, const Eigen::Matrix3d& axes,
                  const std::array<bool, 6>& directions);

/// Homogeneous linear equations between degrees of freedom, kept in reduced row echelon form: every equation has one
/// degree of freedom, its pivot, that stands in no other equation.
class ReducedEquations {
public:
  using Terms = std::vector<std::pair<NodalDof, double>>;

  /// sum_i coefficient_i z_i = 0. The pivot is `preferred` unless its coefficient vanishes in the reduction, otherwise
  /// the largest one. Returns false where the equation follows from the earlier ones.
  bool add(const std::string& name, const Terms& terms, std::optional<NodalDof> preferred = std::nullopt);

  /// Appends to the model: fixed degrees of freedom where an equation has one term, else constraints, pivot first.
  void store(FiniteElementModel& model) const;

private:
  struct Row {
    std::string name;
    std::map<NodalDof, double> terms;  ///< coefficient of the pivot: 1
    NodalDof pivot;
  };
  std::vector<Row> rows_;
  std::map<NodalDof, std::size_t> row_of_pivot_;
  std::map<NodalDof, std::vector<std::size_t>> rows_with_;  ///< rows that hold, or once held, a degree of freedom
};

}  // namespace kalfem
