// SPDX-License-Identifier: Apache-2.0
#include "filter_walk.hpp"

namespace kalfem::benchmarks {

FilterWalk::FilterWalk(const AugmentedModel& augmented_model, const FilterInput& record, FilterKind kind)
    : augmented_model_(&augmented_model),
      record_(&record),
      transition_(augmented_model),
      measurement_(augmented_model, sensor_outputs),
      filter_(make_filter(kind, {transition_, augmented_model.process_noise(), measurement_, record.noise})) {
  restart();
}

void FilterWalk::restart() {
  filter_->reset(augmented_model_->prior());
  sample_ = 0;
}

bool FilterWalk::step() {
  if (at_end()) restart();
  ++sample_;
  transition_.set_inputs(record_->inputs.col(sample_ - 1), record_->inputs.col(sample_));
  if (filter_->predict() != FilterOutcome::usable) return false;
  measurement_.set_inputs(record_->inputs.col(sample_));
  measured_ = record_->measured.values.col(sample_);
  return filter_->update(measured_, innovation_) == FilterOutcome::usable;
}

}  // namespace kalfem::benchmarks
