// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/filter_checks.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/identification/driven_substructure.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/unknown_inputs.hpp"
#include "kalfem/study/record_source.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

void check_start_from_record(const CaseStudy& study, IssueList& issues) {
  const auto measures_displacement = [](const Sensor& sensor) {
    return sensor.output.quantity == ObservedQuantity::displacement;
  };
  if (std::ranges::none_of(study.augmented_model->sensors, measures_displacement))
    issues.add(study.given.source.at({"estimate", "initial_state_from_record"}),
               "estimate.initial_state_from_record is set, but no sensor of the filter's model measures a displacement",
               "the initial state is taken from displacement sensors",
               "remove it, or give the initial state under initial_state");
}

SourceLocation location_of_sensor(const CaseStudy& study, Index row) {
  return std::visit([](const auto& observed) { return observed.points.location; },
                    study.given.sensors[static_cast<std::size_t>(row)].second.observed);
}

void check_first_samples(const CaseStudy& study, IssueList& issues) {
  const Record& record = study.record->record;
  for (const auto& sensor : study.augmented_model->sensors) {
    const Index row = record.find(sensor.name);
    if (sensor.output.quantity != ObservedQuantity::displacement ||
        record.values.row(row).head(std::min(samples_at_start, record.samples())).allFinite())
      continue;
    issues.add(location_of_sensor(study, row),
               "sensors." + sensor.name + ": one of the first " + std::to_string(samples_at_start) +
                   " samples is missing, from " + shortest(record.start) + " s on",
               "estimate.initial_state_from_record takes displacement and velocity from these samples",
               "start later (record.start) or give estimate.initial_state");
  }
}

void check_driving_channels(const CaseStudy& study, IssueList& issues) {
  const Record& record = study.record->record;
  for (const auto& source : study.augmented_model->input_sources) {
    const Index row = source.starts_with('@') ? record.find(source.substr(1)) : -1;
    if (row < 0) continue;
    const auto samples = record.values.row(row);
    const auto gap = std::ranges::find_if(samples, [](double value) { return !std::isfinite(value); });
    if (gap == samples.end()) continue;
    issues.add(location_of_sensor(study, row),
               "sensors." + source.substr(1) +
                   " drives an interface of the filter's model, but its sample is missing at " +
                   shortest(record.time(gap - samples.begin())) + " s",
               "the motion of the interface is unknown there",
               "use a part of the record without gaps in this channel (record.start, record.end)");
  }
}

/// The first samples of the record; zeros if the record will be simulated or comes
/// live. They suffice to make the filter with all its
/// matrices, so that its problems show before the run.
Record first_samples(const CaseStudy& study) {
  constexpr Index most = 100;
  const auto sensors = static_cast<Index>(study.sensors.size());
  if (study.record) {
    const Record& all = study.record->record;
    return {all.sample_rate, all.start, all.channels, all.values.leftCols(std::min(most, all.samples()))};
  }
  const double duration = study.given.simulate ? study.given.simulate->duration : 1.0;
  const auto samples = std::min(most, static_cast<Index>(duration * study.sample_rate()) + 1);
  Record record{.sample_rate = study.sample_rate(), .values = MatrixXd::Zero(sensors, samples)};
  for (const auto& sensor : study.sensors) record.channels.push_back({sensor.name, sensor.unit, 1.0});
  return record;
}

}  // namespace

void check_augmented_model(const CaseStudy& study, IssueList& issues) {
  if (issues.empty()) check_unknown_inputs(study.problem->settings.unknown_inputs, *study.augmented_model, issues);
  const bool from_record = study.given.estimate->initial_state_from_record;
  if (from_record && issues.empty()) check_start_from_record(study, issues);
  if (!study.record) return;
  if (from_record) check_first_samples(study, issues);
  check_driving_channels(study, issues);
}

void check_filter(const CaseStudy& study) {
  const auto& given = *study.given.estimate;
  const FilterRun run = make_filter_run(study.problem, *study.augmented_model, first_samples(study));
  validate(*run.choice.augmented_model,
           {.filter = run.choice.filter, .unscented = given.unscented, .passes = given.passes})
      .raise();
}

namespace {

/// An input of which the sensors see only changes is known in the mean only as far as its process holds it.
void warn_of_slow_inputs(const CaseStudy& study, std::vector<std::string>& warnings) {
  const auto held = held_by(study.problem->settings.unknown_inputs, *study.augmented_model);
  if (held.empty()) return;
  for (const auto& name : observability_of(held, *study.augmented_model).unseen_if_slow) {
    const auto& input = *std::ranges::find(held, name, &UnknownInput::name);
    const std::string seen = "excitation '" + name + "' is unknown and the sensors see only its changes";
    warnings.push_back(seen + (input.is_random_walk()
                                   ? ": its mean drifts without limit, and so do displacements; give std and "
                                     "correlation_time instead of random_walk, or measure a displacement"
                                   : ": its mean is known only as well as its std states; a displacement sensor "
                                     "would show it"));
  }
}

}  // namespace

std::vector<std::string> doubtful_estimation(const CaseStudy& study) {
  std::vector<std::string> warnings;
  const auto& estimate = study.given.estimate;
  if (estimate && study.given.simulate && estimate->settle.value_or(0.0) >= study.given.simulate->duration)
    warnings.emplace_back("estimate.settle is not shorter than the record: errors and NIS use the last sample only");
  if (!study.augmented_model) return warnings;
  warn_of_slow_inputs(study, warnings);
  for (const auto& unknown : study.augmented_model->options.unknowns) {
    const auto entry =
        std::ranges::find(estimate->unknown, unknown.name, &std::pair<std::string, description::Unknown>::first);
    if (entry == estimate->unknown.end()) continue;  // a rest position, which may be negative
    const auto& given = entry->second;
    if (unknown.transform.kind == TransformKind::none && given.std && !given.std->value.bare &&
        unknown.initial != 0.0 && unknown.deviation > 0.6 * std::abs(unknown.initial))
      warnings.push_back(
          "unknown '" + unknown.name +
          "' has a wide prior and no transform, so sigma points may become negative; set transform: log");
  }
  return warnings;
}

void check_driven(const Study& study, const CoupledModel& model, const Name& substructure) {
  constexpr Index largest_driven = 2000;  // degrees of freedom; larger ones are factored once, when they are driven
  if (model.find_substructure(substructure.value).part.model->size() > largest_driven) return;
  const DrivenSubstructure drive(*study.structure, model, substructure.value);
  const auto estimated = study.augmented_model->model->reported_points();
  for (const auto& point : drive.points())
    if (std::ranges::find(estimated, point) == estimated.end())
      throw InvalidInput(substructure.issue("the filter's model does not contain the motion of '" + point + "'",
                                            "this motion drives the substructure",
                                            "include the point in the filter's model or make it an interface"));
}

}  // namespace kalfem
