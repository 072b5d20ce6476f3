// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/field_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/formats/vtu.hpp"
#include "kalfem/pictures/nodal_translations.hpp"

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

void write_series(const std::filesystem::path& folder, const FiniteElementPart& part, const FieldSeries& series) {
  std::vector<SeriesEntry> entries;
  for (std::size_t k = 0; k < series.times.size(); ++k) {
    const std::string file = fmt::format("{}/{:05d}.vtu", series.name, k);
    write_vtu((folder / file).string(), part.elements.mesh,
              {{"displacement", nodal_translations(part, series.displacement.col(static_cast<Index>(k)))}});
    entries.push_back({series.times[k], file});
  }
  write_pvd((folder / (series.name + ".pvd")).string(), entries);
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

std::optional<FieldSeries> estimated_fields(const Study& study, const RecordEstimate& estimate) {
  const auto* elements = pictured(study);
  if (!elements || !elements->reduced) return std::nullopt;
  const std::string& name = elements->part->name;
  const auto& parts = study.augmented_model->model->substructures();
  if (std::ranges::none_of(parts, [&](const auto& part) { return part.name == name; })) return std::nullopt;
  FieldSeries series{name + "_estimated", name, {}, {}};
  std::vector<Index> samples;
  for (Index k = 0; k < estimate.result.state.mean.cols(); k += samples_between(study)) {
    samples.push_back(k);
    series.times.push_back(estimate.measurements.time(k));
  }
  const auto& rows = study.augmented_model->model->find_substructure(name).dofs;
  series.displacement = elements->reduced->recover(estimate.result.state.mean(rows, samples));
  return series;
}

void write_field_series(const std::filesystem::path& folder, const Study& study,
                        const std::vector<FieldSeries>& fields) {
  for (const auto& elements : study.structure->finite_elements)
    for (const auto& series : fields)
      if (series.substructure == elements.part->name && !elements.part->elements.mesh.cells.empty())
        write_series(folder, *elements.part, series);
}

}  // namespace kalfem
