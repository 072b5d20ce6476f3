// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/static_residual.hpp"

#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/updating/mode_pairing.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void check(const std::vector<StaticTest>& tests) {
  IssueList issues;
  if (tests.empty()) issues.add({}, "there are no static tests", "a static residual needs at least one");
  for (const StaticTest& test : tests) {
    const std::string name = "static test '" + test.name + "'";
    if (test.forces.empty()) issues.add({}, name + " has no forces", "the structure would not deform");
    if (test.displacements.empty())
      issues.add({}, name + " has no measured displacements", "there is nothing to compare with");
    for (const auto& force : test.forces)
      if (!std::isfinite(force.force)) issues.add({}, "a force of " + name + " is not a number");
    for (const auto& displacement : test.displacements) {
      if (!std::isfinite(displacement.value)) issues.add({}, "a displacement of " + name + " is not a number");
      if (!(displacement.deviation > 0.0))
        issues.add({}, "a standard deviation of " + name + " is not positive", "",
                   "give the accuracy of the displacement");
    }
  }
  issues.raise();
}

InvalidInput free_to_move(const std::string& how) {
  return {"the structure is free to move under static loads: " + how,
          "static displacements exist only if supports or springs to grounds restrain every rigid-body motion",
          "restrain the structure or compare modes instead"};
}

// A test's displacement is u_i = s_i^T K^-1 F. Its derivative needs one adjoint solve a measured point, whatever the
// number of parameters: du_i = -w_i^T dK u with w_i = K^-1 s_i^T.
/// u = K^-1 F with the factor. Throws InvalidInput where K leaves a motion free.
struct Equilibrium {
  Equilibrium(const LinearModel& model, const MatrixXd& forces)
      : factor(factored(model)), displacements(factor.solve(forces)) {
    for (Index test = 0; test < forces.cols(); ++test)  // a singular K may leave pivots of rounding
      if (displacements.col(test).squaredNorm() > 0.0 && moves_rigidly(model.stiffness, displacements.col(test)))
        throw free_to_move("the loads move it without strain");
  }

  static SparseFactor factored(const LinearModel& model) {
    try {
      return SparseFactor(model.stiffness);
    } catch (const NotPositiveDefinite& error) {
      throw free_to_move("nothing restrains '" + model.dofs[static_cast<std::size_t>(error.column())] + "'");
    }
  }

  SparseFactor factor;
  MatrixXd displacements;  ///< n x tests
};

std::vector<DofCombination> loaded_points(const std::vector<StaticTest>& tests) {
  std::vector<DofCombination> points;
  for (const auto& test : tests)
    for (const auto& force : test.forces) points.push_back(force.point);
  return points;
}

/// F = sum of force times the point's row, n x tests.
MatrixXd load_vectors(const std::vector<StaticTest>& tests, const LinearModel& model) {
  const Eigen::SparseMatrix<double, Eigen::RowMajor> rows = point_rows(model, loaded_points(tests));
  MatrixXd loads = MatrixXd::Zero(model.size(), static_cast<Index>(tests.size()));
  Index row = 0;
  for (std::size_t t = 0; t < tests.size(); ++t)
    for (const auto& force : tests[t].forces)
      loads.col(static_cast<Index>(t)) += force.force * VectorXd(rows.row(row++).transpose());
  return loads;
}

}  // namespace

// All tests share the stiffness, and so one factorisation: their loads are columns, their measured points rows. The
// structure at the start is solved once, so that one that is free to move is refused before the search.
StaticResidual::StaticResidual(std::shared_ptr<const ParameterisedModel> model, std::vector<StaticTest> tests,
                               const VectorXd& start)
    : model_(std::move(model)), tests_(std::move(tests)) {
  check(tests_);
  std::vector<DofCombination> points;
  std::vector<double> values, deviations;
  for (std::size_t t = 0; t < tests_.size(); ++t)
    for (const auto& displacement : tests_[t].displacements) {
      points.push_back(displacement.point);
      values.push_back(displacement.value);
      deviations.push_back(displacement.deviation);
      test_of_.push_back(static_cast<Index>(t));
    }
  measured_ = Eigen::Map<VectorXd>(values.data(), static_cast<Index>(values.size()));
  deviation_ = Eigen::Map<VectorXd>(deviations.data(), static_cast<Index>(deviations.size()));
  const LinearModel first = model_->at(start).model;
  rows_ = point_rows(first, points);
  forces_ = load_vectors(tests_, first);
  (void)Equilibrium(first, forces_);
}

VectorXd StaticResidual::own(const MatrixXd& displacements) const {
  const MatrixXd all = rows_ * displacements;
  VectorXd own(size());
  for (Index i = 0; i < size(); ++i) own[i] = all(i, test_of_[static_cast<std::size_t>(i)]);
  return own;
}

VectorXd StaticResidual::displacements(const VectorXd& parameters) const {
  return own(Equilibrium(model_->at(parameters).model, forces_).displacements);
}

// Values without a structure, or with one that is free to move, are no error of the user's: the search takes another
// step.
std::optional<ResidualValue> StaticResidual::evaluate(const VectorXd& parameters, bool with_jacobian) const {
  try {
    const Equilibrium state(model_->at(parameters).model, forces_);
    ResidualValue result{(own(state.displacements) - measured_).cwiseQuotient(deviation_), {}};
    if (with_jacobian) result.jacobian = jacobian(state.factor, state.displacements, model_->derivatives(parameters));
    return result;
  } catch (const InvalidInput&) {  // no structure, or one that is free to move
    return {};
  }
}

/// -w_i^T (dK u) / deviation_i.
MatrixXd StaticResidual::jacobian(const SparseFactor& factor, const MatrixXd& displacements,
                                  const std::vector<ModelDerivative>& derivatives) const {
  const MatrixXd influence = factor.solve(MatrixXd(rows_.transpose()));  // w_i
  MatrixXd jacobian = MatrixXd::Zero(size(), static_cast<Index>(derivatives.size()));
  for (std::size_t p = 0; p < derivatives.size(); ++p) {
    if (derivatives[p].stiffness.nonZeros() == 0) continue;
    const MatrixXd unbalance = derivatives[p].stiffness * displacements;
    for (Index i = 0; i < size(); ++i)
      jacobian(i, static_cast<Index>(p)) =
          -influence.col(i).dot(unbalance.col(test_of_[static_cast<std::size_t>(i)])) / deviation_[i];
  }
  return jacobian;
}

}  // namespace kalfem
