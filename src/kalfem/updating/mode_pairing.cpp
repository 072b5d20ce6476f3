// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/mode_pairing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double never = 1e3;  ///< cost of a pair that must not be, far above any gain

VectorXd column_squares(const MatrixXd& vectors, const MatrixXd& weighted) {
  return vectors.cwiseProduct(weighted).colwise().sum().transpose();
}

std::map<std::string, Index> numbered(const std::vector<std::string>& dofs) {
  std::map<std::string, Index> numbers;
  for (std::size_t i = 0; i < dofs.size(); ++i) numbers.emplace(dofs[i], static_cast<Index>(i));
  return numbers;
}

InvalidInput no_such_point(const LinearModel& model, const std::string& name) {
  std::vector<std::string> known;
  for (const auto& [point, combination] : model.points) known.push_back(point);
  if (!model.points_only) known.insert(known.end(), model.dofs.begin(), model.dofs.end());
  return {"there is no point '" + name + "'" + did_you_mean(name, known),
          "a measured point must be a point of the model", "name a degree of freedom or a point of the model"};
}

// Pairs are the assignment of measured to model modes with the largest sum of gains, MAC plus a smaller reward for a
// near frequency. The assignment problem is solved by shortest augmenting paths [JV87], with prices u_i, v_j of rows
// and columns such that every reduced cost c_ij - u_i - v_j is nonnegative and those of assigned pairs are zero:
//   1. from the new row, grow a tree of columns by least reduced cost (Dijkstra), through the rows assigned so far;
//   2. raise the prices of all that was reached, so that the tree's pairs stay at reduced cost zero;
//   3. at the first free column, exchange the pairs along the path back to the new row.
// One more column a row, at cost zero, stands for "pairs with nothing".
/// Rows are assigned one after the other; each is a search for the path of least reduced cost to a free column, along
/// which earlier rows change theirs. More columns than rows; index 0 stands for "none" in both.
class Assignment {
public:
  explicit Assignment(const MatrixXd& costs)
      : costs_(costs), row_price_(costs.rows() + 1), column_price_(costs.cols() + 1), row_of_(costs.cols() + 1, 0) {
    std::ranges::fill(row_price_, 0.0);
    std::ranges::fill(column_price_, 0.0);
    for (Index row = 1; row <= costs.rows(); ++row) assign(row);
  }

  [[nodiscard]] std::vector<Index> column_of_row() const {
    std::vector<Index> columns(static_cast<std::size_t>(costs_.rows()));
    for (std::size_t column = 1; column < row_of_.size(); ++column)
      if (row_of_[column] > 0) columns[row_of_[column] - 1] = static_cast<Index>(column) - 1;
    return columns;
  }

private:
  void assign(Index row) {
    const std::size_t columns = row_of_.size();
    std::vector<double> distance(columns, std::numeric_limits<double>::infinity());
    std::vector<std::size_t> before(columns, 0);
    std::vector<bool> reached(columns, false);
    row_of_[0] = static_cast<std::size_t>(row);
    std::size_t at = 0;
    while (row_of_[at] != 0) {
      reached[at] = true;
      const std::size_t next = relax(at, distance, before, reached);
      const double step = distance[next];
      for (std::size_t j = 0; j < columns; ++j)
        if (reached[j])
          row_price_[row_of_[j]] += step, column_price_[j] -= step;
        else
          distance[j] -= step;
      at = next;
    }
    for (; at != 0; at = before[at]) row_of_[at] = row_of_[before[at]];
  }

  /// Distances over the row of column `at`; the nearest column that is not yet reached.
  std::size_t relax(std::size_t at, std::vector<double>& distance, std::vector<std::size_t>& before,
                    const std::vector<bool>& reached) const {
    const std::size_t row = row_of_[at];
    std::size_t nearest = 0;
    for (std::size_t j = 1; j < row_of_.size(); ++j) {
      if (reached[j]) continue;
      const double reduced =
          costs_(static_cast<Index>(row) - 1, static_cast<Index>(j) - 1) - row_price_[row] - column_price_[j];
      if (reduced < distance[j]) distance[j] = reduced, before[j] = at;
      if (nearest == 0 || distance[j] < distance[nearest]) nearest = j;
    }
    return nearest;
  }

  const MatrixXd& costs_;
  std::vector<double> row_price_, column_price_;
  std::vector<std::size_t> row_of_;  ///< per column
};

double closeness(double measured, double model, double spread) {
  if (!(model > 0.0)) return 0.0;
  const double distance = std::log(model / measured) / spread;
  return std::exp(-distance * distance);
}

}  // namespace

SparseMatrix point_rows(const LinearModel& model, const std::vector<DofCombination>& points) {
  const auto number = numbered(model.dofs);
  std::vector<Eigen::Triplet<double>> entries;
  IssueList issues;
  for (std::size_t row = 0; row < points.size(); ++row) {
    const auto add = [&](const std::string& dof, double coefficient) {
      entries.emplace_back(static_cast<int>(row), static_cast<int>(number.at(dof)), coefficient);
    };
    for (const auto& [name, coefficient] : points[row])
      if (number.contains(name))
        add(name, coefficient);
      else if (const auto point = model.points.find(name); point != model.points.end())
        for (const auto& [dof, share] : point->second) add(dof, coefficient * share);
      else
        issues.add(no_such_point(model, name), {});
  }
  issues.raise();
  SparseMatrix rows(static_cast<Index>(points.size()), model.size());
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

MatrixXd mac_matrix(const MatrixXd& one, const MatrixXd& other, const SparseMatrix* weight) {
  const MatrixXd weighted = weight ? MatrixXd(*weight * other) : other;
  const VectorXd ones = column_squares(one, weight ? MatrixXd(*weight * one) : one);
  const VectorXd others = column_squares(other, weighted);
  const MatrixXd scale = ones * others.transpose();
  const MatrixXd squares = (one.transpose() * weighted).cwiseAbs2();
  return (scale.array() > 0.0).select(squares.array() / scale.array(), 0.0);
}

MatrixXd complex_mac_matrix(const Eigen::MatrixXcd& one, const Eigen::MatrixXcd& other) {
  const VectorXd ones = one.colwise().squaredNorm(), others = other.colwise().squaredNorm();
  const MatrixXd scale = ones * others.transpose();
  const MatrixXd squares = (one.adjoint() * other).cwiseAbs2();
  return (scale.array() > 0.0).select(squares.array() / scale.array(), 0.0);
}

SubspaceFit fit_in_subspace(const MatrixXd& gram, const VectorXd& toward, double target_squared) {
  SubspaceFit fit{gram.completeOrthogonalDecomposition().solve(toward), 0.0};
  if (target_squared > 0.0) fit.mac = std::clamp(toward.dot(fit.coefficients) / target_squared, 0.0, 1.0);
  return fit;
}

std::vector<std::optional<Index>> best_assignment(const MatrixXd& gains) {
  MatrixXd costs = MatrixXd::Zero(gains.rows(), gains.cols() + gains.rows());  // one more column a row: nothing
  costs.leftCols(gains.cols()) = (gains.array() > 0.0).select(-gains.array(), never);
  std::vector<std::optional<Index>> assignment;
  for (const Index column : Assignment(costs).column_of_row())
    assignment.push_back(column < gains.cols() ? std::optional(column) : std::nullopt);
  return assignment;
}

// Gains of pairs below the least MAC are zero, and such pairs cost `never`: a mode without a partner pairs with
// nothing.
std::vector<ModePair> pair_modes(const MatrixXd& mac, const VectorXd& measured_frequencies,
                                 const VectorXd& model_frequencies, const ModePairingOptions& options) {
  MatrixXd gains(mac.rows(), mac.cols());
  for (Index i = 0; i < mac.rows(); ++i)
    for (Index j = 0; j < mac.cols(); ++j)
      gains(i, j) =
          mac(i, j) >= options.least_mac && mac(i, j) > 0.0
              ? mac(i, j) + options.frequency_weight *
                                closeness(measured_frequencies[i], model_frequencies[j], options.frequency_spread)
              : 0.0;
  const auto assignment = best_assignment(gains);

  std::vector<ModePair> pairs;
  for (Index i = 0; i < mac.rows(); ++i) {
    const auto model = assignment[static_cast<std::size_t>(i)];
    Index nearest = 0;
    if (!model && mac.cols() > 0) (model_frequencies.array() - measured_frequencies[i]).abs().minCoeff(&nearest);
    const double shown = mac.cols() > 0 ? model_frequencies[model.value_or(nearest)] : 0.0;
    const double agreement = model ? mac(i, *model) : mac.cols() > 0 ? mac.row(i).maxCoeff() : 0.0;
    pairs.push_back({model, agreement, shown / measured_frequencies[i] - 1.0});
  }
  return pairs;
}

}  // namespace kalfem
