// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/model/parameterised_model.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// A force along a point: it does work on the point's displacement.
struct PointForce {
  DofCombination point;
  double force = 0.0;  ///< [N], along a rotation [N m]
};

/// A displacement that was measured under the loads.
struct MeasuredDisplacement {
  DofCombination point;
  double value = 0.0;      ///< [m], of a rotation [rad]
  double deviation = 0.0;  ///< standard deviation, in the same unit
};

/// Loads that act together and what was measured under them.
struct StaticTest {
  std::string name;
  std::vector<PointForce> forces;
  std::vector<MeasuredDisplacement> displacements;
};

/// Static displacements against measured ones, (p_i^T u - measured_i) / deviation_i with K u = F of its test, in the
/// order of the tests. K is factored once for all tests and derivatives: dp_i^T u / dtheta = -w_i^T dK u with K w_i =
/// p_i, the displacements under a unit force at the measured point.
class StaticResidual final : public Residual {
public:
  /// Throws InvalidInput with everything that is wrong: points that the model does not have, deviations that are not
  /// positive, a structure that is free to move at the starting parameters.
  StaticResidual(std::shared_ptr<const ParameterisedModel> model, std::vector<StaticTest> tests,
                 const Eigen::VectorXd& start);

  [[nodiscard]] std::string name() const override { return "static displacements"; }
  [[nodiscard]] Eigen::Index size() const override { return measured_.size(); }
  [[nodiscard]] std::optional<ResidualValue> evaluate(const Eigen::VectorXd& parameters,
                                                      bool with_jacobian) const override;

  /// Displacements of the model in the order of the residual. Throws InvalidInput where the structure is free to move.
  [[nodiscard]] Eigen::VectorXd displacements(const Eigen::VectorXd& parameters) const;
  [[nodiscard]] const std::vector<StaticTest>& tests() const { return tests_; }

private:
  [[nodiscard]] Eigen::VectorXd own(const Eigen::MatrixXd& displacements) const;
  [[nodiscard]] Eigen::MatrixXd jacobian(const SparseFactor& factor, const Eigen::MatrixXd& displacements,
                                         const std::vector<ModelDerivative>& derivatives) const;

  std::shared_ptr<const ParameterisedModel> model_;
  std::vector<StaticTest> tests_;
  SparseMatrix rows_;                     ///< p_i^T, displacements x n
  Eigen::MatrixXd forces_;                ///< F, n x tests
  std::vector<Eigen::Index> test_of_;     ///< by displacement
  Eigen::VectorXd measured_, deviation_;  ///< by displacement
};

}  // namespace kalfem
