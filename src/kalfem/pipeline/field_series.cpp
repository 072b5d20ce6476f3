// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pipeline/run_steps.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

const FiniteElementSubstructure* pictured(const Study& study) {
  if (!study.report.pictures) return nullptr;
  for (const auto& elements : study.structure->finite_elements)
    if (elements.part->name == study.report.pictures->substructure) return &elements;
  return nullptr;
}

Index samples_between(const Study& study) {
  return std::max<Index>(1, std::llround(study.report.pictures->every * study.sample_rate()));
}

}  // namespace

FieldCollector::FieldCollector(const Study& study) : study_(study), elements_(pictured(study)) {
  if (!elements_) return;
  series_ = {elements_->part->name + "_simulated", elements_->part->name, {}, {}};
  dofs_ = study.model->find_substructure(elements_->part->name).dofs;
}

void FieldCollector::attach(SimulationOptions& options) {
  if (!elements_) return;
  options.snapshot_every = samples_between(study_);
  options.snapshot = [this](double time, const VectorXd& displacement) { add(time, displacement); };
}

/// A refined simulation starts again at time 0.
void FieldCollector::add(double time, const VectorXd& displacement) {
  if (time == 0.0) {
    series_.times.clear();
    frames_.clear();
  }
  series_.times.push_back(time);
  frames_.emplace_back(displacement(dofs_));
}

std::optional<FieldSeries> FieldCollector::take() {
  if (!elements_ || frames_.empty()) return std::nullopt;
  MatrixXd displacement(frames_.front().size(), static_cast<Index>(frames_.size()));
  for (std::size_t k = 0; k < frames_.size(); ++k) displacement.col(static_cast<Index>(k)) = frames_[k];
  frames_.clear();
  series_.displacement = elements_->reference ? elements_->reference->recover(displacement) : std::move(displacement);
  return std::move(series_);
}

std::optional<FieldSeries> estimated_fields(const Study& study, const EstimationOutcome& outcome) {
  const auto* elements = pictured(study);
  if (!elements || !elements->reduced) return std::nullopt;
  const std::string& name = elements->part->name;
  const auto& parts = study.augmented_model->model->substructures();
  if (std::ranges::none_of(parts, [&](const auto& part) { return part.name == name; })) return std::nullopt;
  FieldSeries series{name + "_estimated", name, {}, {}};
  std::vector<Index> samples;
  for (Index k = 0; k < outcome.result.state.mean.cols(); k += samples_between(study)) {
    samples.push_back(k);
    series.times.push_back(outcome.measurements.time(k));
  }
  const auto& rows = study.augmented_model->model->find_substructure(name).dofs;
  series.displacement = elements->reduced->recover(outcome.result.state.mean(rows, samples));
  return series;
}

}  // namespace kalfem
