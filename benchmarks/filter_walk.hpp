// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/estimation/filter.hpp"
#include "kalfem/estimation/process_model.hpp"

namespace kalfem::benchmarks {

/// A filter that walks through a record. Augmented model and record must outlive it.
class FilterWalk {
public:
  FilterWalk(const AugmentedModel& augmented_model, const FilterInput& record, FilterKind kind);

  /// Predict and update by one sample, from the prior again after the last one; false where the filter failed.
  bool step();
  [[nodiscard]] bool at_end() const { return sample_ + 1 == record_->inputs.cols(); }
  /// From the prior again.
  void restart();

private:
  const AugmentedModel* augmented_model_;
  const FilterInput* record_;
  ProcessModel transition_;
  MeasurementModel measurement_;
  std::unique_ptr<Filter> filter_;  ///< works on these maps
  Innovation innovation_;
  Eigen::VectorXd measured_;
  Eigen::Index sample_ = 0;
};

}  // namespace kalfem::benchmarks
