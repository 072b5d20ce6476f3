// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/estimation/process_model.hpp"

namespace kalfem {

/// What the embedded step of order 2 (CollocationStep) would shift in a filter's estimates, found within the filter's
/// own run. With the filter's mean m, its gain K and the maps F and h of prediction and measurement,
///     delta <- F(m + delta) - F(m) + e,     delta <- delta - K (h(m + delta) - h(m)),
/// where e is the embedded difference of the step at m: of the state and the unknowns both, as the gains carry it over.
/// It starts at zero. It costs four evaluations at a point a sample.
class StepShift {
public:
  /// The model has a step of order 4.
  explicit StepShift(std::shared_ptr<const AugmentedModel> model);

  /// Over the interval that ends at sample k; `mean` is that at its begin.
  void predict_to(Eigen::Index k, const FilterInput& input, const Eigen::VectorXd& mean);
  /// Through the update at sample k; `mean` is that before it.
  void update_at(Eigen::Index k, const FilterInput& input, const Eigen::VectorXd& mean, const Filter& filter,
                 const Innovation& innovation);
  /// The same in the coordinates of another linearisation.
  void move_to(std::shared_ptr<const AugmentedModel> model);

  /// delta of the augmented state; not a number from where a map could not be evaluated.
  [[nodiscard]] const Eigen::VectorXd& value() const { return shift_; }

private:
  struct Maps {
    explicit Maps(std::shared_ptr<const AugmentedModel> of);
    std::shared_ptr<const AugmentedModel> model;
    ProcessModel transition;
    MeasurementModel measurement;
  };
  bool outputs(PartiallyLinearMap& map, const Eigen::VectorXd& mean);
  [[nodiscard]] Eigen::VectorXd response(const PartiallyLinearMap& map) const;

  std::unique_ptr<Maps> maps_;
  Eigen::VectorXd shift_;
  Eigen::ArrayXXd in_, out_;  ///< a row at the mean and one beside it
};

}  // namespace kalfem
