// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/structure.hpp"
#include "kalfem/prediction/base_driven.hpp"

namespace kalfem {

/// A substructure of a structure, driven by the motion of its boundary: the degrees of freedom of a finite-element
/// model that its reduction keeps, or those that connectors touch.
class DrivenSubstructure {
public:
  /// `model`: the whole structure, with the inputs of `structure`. Throws InvalidInput as BaseDrivenSubstructure.
  DrivenSubstructure(const StructureModel& structure, const CoupledModel& model, const std::string& substructure);

  /// The substructure, and the places of its degrees of freedom in the whole model. It shares the matrices and does not
  /// need the model any more.
  struct Place {
    Substructure part;
    std::vector<Eigen::Index> dofs;
  };
  [[nodiscard]] const Place& place() const { return place_; }
  /// Qualified points whose motion drives it: one a boundary degree of freedom, then those outside that pull at it by
  /// cross damping.
  [[nodiscard]] const std::vector<std::string>& points() const { return points_; }
  /// `rows` over the substructure's degrees of freedom; with the inputs that act on it itself.
  [[nodiscard]] PredictedMotion predict(const SparseRows& rows, const BoundaryMotion& motion,
                                        const PredictionStart& start, const PredictionOptions& options) const {
    return driven_.predict(rows, motion, applied_, start, options);
  }

private:
  Place place_;
  BaseDrivenSubstructure driven_;
  std::vector<std::string> points_;
  std::vector<AppliedInput> applied_;
};

}  // namespace kalfem
