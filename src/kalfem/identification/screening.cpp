// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/screening.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/identification/settling.hpp"
#include "kalfem/records/isolated_values.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

constexpr int most_runs = 5;
constexpr double most_spikes = 1e-3;    ///< of a channel's samples, beside one: more are a motion of its kind
constexpr double most_outliers = 2e-3;  ///< of the samples in a robust run: more are of a wrong model
constexpr double contradicting = 1.2;   ///< mean NIS over its degrees of freedom
constexpr double far_less = 0.7;        ///< of what exceeds one
constexpr double gate = 25.0;

/// Mean NIS over its degrees of freedom, in which a sample counts no more than `most`.
double relative_nis(const EstimationResult& result, double most = std::numeric_limits<double>::infinity()) {
  if (result.failure) return std::numeric_limits<double>::infinity();
  double sum = 0.0, expected = 0.0;
  for (Index k = 0; k < result.nis.size(); ++k) {
    if (!std::isfinite(result.nis[k]) || result.measured[k] == 0) continue;
    sum += std::min(result.nis[k], most * result.measured[k]);
    expected += result.measured[k];
  }
  return sum / std::max(1.0, expected);
}

/// Whether a channel holds a few values that are far from their neighbours.
bool holds_spikes(const Record& record) {
  const Eigen::MatrixXd kept = without_isolated_values(record.values);
  for (Index i = 0; i < kept.rows(); ++i) {
    const Index spikes = (record.values.row(i).array().isFinite() && !kept.row(i).array().isFinite()).count();
    if (spikes > 0 && static_cast<double>(spikes) <= std::max(1.0, most_spikes * static_cast<double>(kept.cols())))
      return true;
  }
  return false;
}

}  // namespace

Screening::Screening(EstimationProblemPtr problem, AugmentedModelSetup setup, Record record, EstimationOptions options)
    : problem_(std::move(problem)), setup_(std::move(setup)), record_(std::move(record)), options_(std::move(options)) {
  options_.outliers.treatment = problem_->settings.outliers.value_or(OutlierTreatment::keep);
  std::vector<std::string> names;
  for (const auto& sensor : setup_.sensors) names.push_back(sensor.name);
  measured_ = select_channels(record_, names);
  if (problem_->settings.outliers != OutlierTreatment::keep) options_.held_out = constant_stretches(measured_);
}

FilteredRecord Screening::run(int substeps) {
  const bool searches = problem_->settings.outliers != OutlierTreatment::keep;
  FilteredRecord filtered = run_once(substeps);
  // A spike among the first samples throws a run away in which it counts in full.
  if (!problem_->settings.outliers && filtered.run.start.spiked &&
      options_.outliers.treatment == OutlierTreatment::keep) {
    options_.outliers.treatment = OutlierTreatment::robust;
    filtered = run_once(substeps);
  }
  if (!problem_->settings.outliers && options_.outliers.treatment == OutlierTreatment::keep)
    count_spikes_little(filtered, substeps);
  for (int runs = 1; searches && runs < most_runs && changes(filtered); ++runs) {
    state_noise(filtered.result);
    filtered = run_once(substeps);
  }
  return filtered;
}

/// A large spike throws a run away, whose innovations then stay large long behind it: they do not show a single sample
/// far from predictions that otherwise hold, as shows_outliers() asks for. The record does. The robust run stays where
/// it contradicts itself far less.
void Screening::count_spikes_little(FilteredRecord& filtered, int substeps) {
  if (!(relative_nis(filtered.result) > contradicting) || spikes_tried_ || !holds_spikes(measured_)) return;
  spikes_tried_ = true;
  options_.outliers.treatment = OutlierTreatment::robust;
  FilteredRecord robust = run_once(substeps);
  // Judged by the other samples: the spike itself lies as far from its prediction as before.
  const auto few = most_outliers * static_cast<double>(measured_.samples());
  const bool of_spikes = static_cast<double>(robust.result.set_aside.size()) <= std::max(5.0, few);
  if (of_spikes && relative_nis(robust.result, gate) - 1.0 < far_less * (relative_nis(filtered.result, gate) - 1.0))
    filtered = std::move(robust);
  else
    options_.outliers.treatment = OutlierTreatment::keep;
}

FilteredRecord Screening::run_once(int substeps) {
  setup_.options.substeps = substeps;
  steps_ += steps_of_run(*problem_, record_, substeps) / problem_->settings.passes * options_.passes;
  return run_filter(problem_, setup_, record_, options_);
}

std::vector<SensorEvent> Screening::events(const EstimationResult& result) const {
  auto events = missing_samples(measured_);
  for (auto& event : faults(result)) events.push_back(std::move(event));
  return events;
}

/// Whether the result asks for another run, which the options then describe.
bool Screening::changes(const FilteredRecord& filtered) {
  const EstimationResult& result = filtered.result;
  const bool restored =
      std::erase_if(options_.held_out, [&](const HeldOutSamples& stretch) {
        return stretch.end - stretch.begin >= 1 && !is_confirmed(stretch) && !contradicted(result, stretch);
      }) > 0;
  confirmed_ = options_.held_out;
  bool found = false;
  if (!result.failure) {
    found = hold_out(silent_stretches(measured_, result));
    found = hold_out(saturated_samples(measured_, result)) || found;
  }
  const Index settled =
      result.failure ? 0 : first_settled_sample(problem_->settings, setup_, filtered.run.start, measured_);
  const bool spoilt = !problem_->settings.outliers && options_.outliers.treatment == OutlierTreatment::keep &&
                      shows_outliers(result, settled);
  if (spoilt) options_.outliers.treatment = OutlierTreatment::robust;
  return restored || found || spoilt;
}

bool Screening::is_confirmed(const HeldOutSamples& stretch) const {
  return std::ranges::any_of(confirmed_, [&](const auto& each) {
    return each.channel == stretch.channel && each.begin == stretch.begin && each.end == stretch.end;
  });
}

/// Those that no other stretch holds already.
bool Screening::hold_out(const std::vector<HeldOutSamples>& found) {
  bool any = false;
  for (const auto& stretch : found) {
    const bool held = std::ranges::any_of(confirmed_, [&](const auto& each) {
      return each.channel == stretch.channel && each.begin < stretch.end && stretch.begin < each.end;
    });
    if (held) continue;
    options_.held_out.push_back(stretch);
    any = true;
  }
  confirmed_ = options_.held_out;
  return any;
}

std::vector<SensorEvent> Screening::faults(const EstimationResult& result) const {
  return events_of(measured_, result, options_.held_out, options_.outliers.limit);
}

/// The noise of sensors that state it relative to their rms, where part of the channel is no measurement.
void Screening::state_noise(const EstimationResult& result) {
  const auto events = faults(result);
  const Record used = without(measured_, events);
  for (const auto& sensor : setup_.sensors) {
    const bool affected = std::ranges::any_of(events, [&](const auto& each) { return each.channel == sensor.name; });
    if (!sensor.relative_noise || !affected) continue;
    const Index row = used.find(sensor.name);
    record_.channels[static_cast<std::size_t>(record_.find(sensor.name))].noise =
        sensor.deviation(rms_of_present(used.values.row(row).transpose()));
  }
}

}  // namespace kalfem
