// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/live_plan.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "kalfem/base/units.hpp"
#include "kalfem/live/fixed_lag.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/study/record_source.hpp"
#include "kalfem/study/sensor_unknowns.hpp"

namespace kalfem {
namespace {

namespace d = description;

constexpr double off_the_grid = 0.01;  ///< of a sampling interval

/// What of `estimate` needs a whole record.
void check_estimation(const d::Case& given, IssueList& issues) {
  const auto& estimate = *given.estimate;
  const auto refuse = [&](bool asked, const char* key) {
    if (asked)
      issues.add(given.source.at({"estimate", key}), std::string("estimate.") + key + " needs a whole record",
                 "a live filter does not know what follows", "leave it out, or run the case over a record");
  };
  refuse(estimate.initial_state_from_record, "initial_state_from_record");
  refuse(estimate.estimate_initial_state, "estimate_initial_state");
  refuse(estimate.passes > 1, "passes");
  refuse(estimate.smooth, "smooth");
  refuse(estimate.adaptive_noise.any(), "adaptive_noise");
  refuse(!estimate.known_to.empty(), "known_to");
  refuse(estimate.free != FreeNumbers::ask, "free");
  refuse(estimate.local.has_value(), "local");
  refuse(estimate.alternatives.has_value(), "alternatives");
  for (const auto& [name, unknown] : estimate.unknown)
    if (is_measurement_unknown(name) && !name.ends_with(".offset"))
      issues.add(unknown.initial.location, "estimate.unknown." + name + " needs a whole record",
                 "it is found by the likelihood of a record", "state its value under `sensors`");
}

/// Sections that need a record.
void check_other_sections(const d::Case& given, IssueList& issues) {
  for (const char* section : {"simulate", "record", "validate", "predict", "update", "infer", "place"})
    if (given.source.gives({section}))
      issues.add(given.source.at({section}), std::string("the case has both `live` and `") + section + "`",
                 "samples that come one by one are no record", "remove one of them");
  if (!given.estimate)
    issues.add(given.live->location, "the case has `live` but no `estimate`", "a live case estimates",
               "add `estimate`, or leave `live` out");
}

std::string rounded(double value) { return shortest(std::round(value * 1e9) / 1e9); }

void check_delay(const d::Case& given, const std::string& key, double delay, const SourceLocation& place,
                 IssueList& issues) {
  const double samples = delay * given.live->value.sample_rate;
  if (std::abs(samples - std::round(samples)) > off_the_grid)
    issues.add(place, key + " is " + rounded(delay) + " s, " + rounded(samples) + " samples",
               "a stream is moved by whole samples",
               "give a whole number of samples, or describe the delay in the sensor's chain");
}

void refuse_drift(const std::string& key, double drift, const SourceLocation& place, IssueList& issues) {
  if (drift != 0.0)
    issues.add(place, key + " is given", "a stream is moved by whole samples, and not further and further",
               "let the clocks of the stream be synchronised, or run the case over a record");
}

/// The unit in which a channel comes, if the case states one.
void check_unit(const Located<std::string>& given, const std::string& unit, const std::string& channel) {
  if (given.value.empty()) return;
  try {
    static_cast<void>(parse_unit_as(given.value, unit));
  } catch (const InvalidInput& error) {
    throw InvalidInput(given.issue(error.issues().front().what + " (" + channel + ")", error.issues().front().why,
                                   "write a unit such as " + unit));
  }
}

void check_sensors(const CaseStudy& study, IssueList& issues) {
  for (std::size_t i = 0; i < study.sensors.size(); ++i) {
    const auto& sensor = study.sensors[i];
    const auto& given = study.given.sensors[i].second;
    if (sensor.relative_noise)
      issues.add(sensor.location, "sensors." + sensor.name + ".noise is per cent of the channel's rms",
                 "a stream has no rms before it has come", "give the noise in " + sensor.unit);
    check_delay(study.given, "sensors." + sensor.name + ".delay", given.delay, sensor.location, issues);
    refuse_drift("sensors." + sensor.name + ".drift", given.drift, sensor.location, issues);
    try {
      static_cast<void>(calibration_of(sensor.name, given));
      check_unit(given.unit.value.empty() ? study.given.live->value.unit : given.unit, sensor.unit, sensor.name);
    } catch (const InvalidInput& error) {
      issues.add(error, sensor.location);
    }
  }
}

void check_inputs(const CaseStudy& study, IssueList& issues) {
  for (const auto& [name, excitation] : study.given.excitation) {
    if (!comes_live(study.given, excitation) || excitation.unknown) continue;
    const auto place = study.given.source.at({"excitation", name});
    const auto* column = excitation.signal_as<d::FileSignal>();
    if (accelerates_grounds(study.given, excitation) || std::holds_alternative<d::BaseVelocity>(excitation.target))
      issues.add(place, "excitation." + name + " is a ground's velocity or acceleration that comes sample by sample",
                 "its displacement would drift with the offset, which only a whole record tells",
                 "integrate it behind a high-pass, and give a base_displacement");
    check_delay(study.given, "excitation." + name + ".delay", column->delay, place, issues);
    refuse_drift("excitation." + name + ".clock_drift", column->clock_drift, place, issues);
    if (column->align) issues.add(place, "excitation." + name + ".align needs a whole record", "", "state the delay");
  }
}

std::string column_of(const d::Case& given, std::size_t sensor) {
  const auto& [name, described] = given.sensors[sensor];
  return described.channel.value_or(name);
}

/// A covariate is a column of its own. Options that depend on the sampling rate.
void check_alarms(const d::Case& given, IssueList& issues) {
  const d::Live& live = given.live->value;
  if (!live.alarms) return;
  const auto& [options, covariates] = live.alarms->value;
  if (options.window * live.sample_rate < 10.0)
    issues.add(live.alarms->location,
               "live.alarms.window is " + shortest(options.window * live.sample_rate) + " samples",
               "an estimate is formed of at least ten", "give a longer window");
  if (options.false_alarms_every < options.window)
    issues.add(live.alarms->location, "live.alarms.false_alarms_every is shorter than a window",
               "each window can give one alarm at most", "give a longer time");
  if (given.estimate->unknown.empty())
    issues.add(live.alarms->location, "live.alarms is given, but nothing is unknown",
               "alarms are on changes of unknowns", "add estimate.unknown, or leave live.alarms out");
  std::map<std::string, std::string> used;
  for (std::size_t i = 0; i < given.sensors.size(); ++i)
    used[column_of(given, i)] = "sensors." + given.sensors[i].first;
  for (const auto& [name, excitation] : given.excitation)
    if (const auto* column = excitation.signal_as<d::FileSignal>()) used[column->channel.value] = "excitation." + name;
  for (const auto& [name, covariate] : covariates) {
    const auto [place, fresh] = used.emplace(covariate.value.channel.value, "covariates." + name);
    if (!fresh)
      issues.add(covariate.location,
                 "live.alarms.covariates." + name + ".channel is '" + covariate.value.channel.value + "', that of " +
                     place->second,
                 "a covariate is a column that is nothing else", "name another column");
  }
}

/// Samples come from one place.
void check_ports(const d::Live& live, const SourceLocation& place, IssueList& issues) {
  if (live.port && live.mqtt && !live.mqtt->value.topics.empty())
    issues.add(place, "live has both `port` and `mqtt.topics`", "samples come from one of them", "remove one");
  for (const auto& [name, port] : {std::pair{"metrics", live.metrics}, std::pair{"page", live.page}})
    if (live.port && port == live.port)
      issues.add(place, std::string("live.port and live.") + name + " are the same port",
                 "lines come in by the one, and go out by the other", "give another number");
}

std::string unit_of_input(const d::Excitation& excitation) {
  if (std::holds_alternative<d::BaseDisplacement>(excitation.target)) return unit_of(InputKind::base_displacement);
  return unit_of(std::holds_alternative<d::Force>(excitation.target) ? InputKind::force : InputKind::base_acceleration);
}

/// With substeps where none are given: on hours of samples, forces at four instants leave a bias of a few standard
/// deviations.
EstimationProblemPtr with_substeps(const EstimationProblem& given) {
  auto problem = std::make_shared<EstimationProblem>(given);
  auto& settings = problem->settings;
  if (!settings.substeps) settings.substeps = settings.step_order == 4 ? 4 : 8;
  return problem;
}

/// Displacement of every reported point, and the strain of every gauge.
std::vector<OutputDescription> outputs_of(const CoupledModel& model) {
  std::vector<OutputDescription> outputs;
  for (const auto& point : model.reported_points())
    outputs.push_back({point + ".displacement", ObservedQuantity::displacement, {{point, 1.0}}});
  for (const auto& gauge : model.gauges())
    outputs.push_back({gauge + ".strain", ObservedQuantity::strain, {{gauge, 1.0}}});
  return outputs;
}

}  // namespace

bool comes_live(const d::Case& given, const d::Excitation& excitation) {
  return given.live && excitation.signal_as<d::FileSignal>() != nullptr;
}

void check_live(const CaseStudy& study, IssueList& issues) {
  if (!study.given.live) return;
  check_other_sections(study.given, issues);
  if (!issues.empty()) return;
  check_estimation(study.given, issues);
  check_sensors(study, issues);
  check_inputs(study, issues);
  check_alarms(study.given, issues);
  check_ports(study.given.live->value, study.given.live->location, issues);
}

bool is_live(const Study& study) { return study.description && study.description->live; }

void require_no_stream(const Study& study) {
  if (is_live(study))
    throw InvalidInput(Issue{study.description->live->location, "the case has `live`, which is no record",
                             "its samples come one by one", "use `kalfem watch`, or put `record` in its place"});
}

LivePlan make_live_plan(const Study& study) {
  const d::Case& given = *study.description;
  if (!given.live)
    throw InvalidInput(Issue{{study.file, 1},
                             "the case has no `live`",
                             "to watch is to read samples as they come",
                             "put `live` in the place of its record; kalfem schema live lists the keys"});
  const d::Live& live = given.live->value;
  LivePlan plan{.start = live.start,
                .every = live.every,
                .state = live.state,
                .port = live.port,
                .metrics = live.metrics,
                .page = live.page};
  if (live.mqtt) {
    const d::Mqtt& mqtt = live.mqtt->value;
    plan.mqtt = {.broker = mqtt.broker,
                 .port = mqtt.port,
                 .client = mqtt.client,
                 .topics = mqtt.topics,
                 .publish = mqtt.publish,
                 .login = mqtt.login,
                 .authority = mqtt.authority,
                 .certificate = mqtt.certificate,
                 .key = mqtt.key};
  }
  plan.problem = {with_substeps(*study.problem), *study.augmented_model, outputs_of(*study.augmented_model->model)};
  plan.problem.setup = [&] {
    IssueList issues;
    auto setup = make_augmented_model_setup(*plan.problem.problem, plan.problem.problem->structure->parts, {}, issues);
    issues.raise();
    const Eigen::Index states = 2 * setup.model->system().size() + std::ssize(setup.options.unknowns);
    check_lag(live.lag, states, given.source.at({"live", "lag"}), issues);
    issues.raise();
    return setup;
  }();
  constexpr double an_hour = 3600.0;  // without a line: the filter predicts through it
  plan.options = {.horizon = live.horizon,
                  .longest_gap = std::max(an_hour, 10.0 * live.horizon),
                  .filter = {.input_delay = live.input_delay, .window = live.window, .lag = live.lag}};
  if (live.alarms) {
    auto& changes = plan.options.filter.changes.emplace(live.alarms->value.options);
    for (const auto& [name, covariate] : live.alarms->value.covariates) {
      plan.channels.push_back(
          {.name = name, .column = covariate.value.channel.value, .covariate = changes.covariates.size()});
      changes.covariates.push_back({name, covariate.value.effect});
    }
  }
  if (live.gated) plan.options.filter.gates = live.gates;
  for (std::size_t i = 0; i < given.sensors.size(); ++i) {
    const auto& [name, sensor] = given.sensors[i];
    plan.channels.push_back({.name = name,
                             .column = sensor.channel.value_or(name),
                             .unit = study.sensors[i].unit,
                             .given = sensor.unit.value.empty() ? live.unit.value : sensor.unit.value,
                             .calibration = calibration_of(name, sensor)});
  }
  const auto& parts = plan.problem.problem->structure->parts;
  for (std::size_t i = 0; i < parts.inputs.size(); ++i) {
    const auto& input = parts.inputs[i];
    const auto found = std::ranges::find(given.excitation, input.name, &std::pair<std::string, d::Excitation>::first);
    const bool online = found != given.excitation.end() && comes_live(given, found->second) && !found->second.unknown;
    plan.inputs.push_back({input.name, input.kind == InputKind::base_displacement,
                           online ? nullptr : plan.problem.problem->structure->signals[i]});
    if (!online) continue;
    const auto* column = found->second.signal_as<d::FileSignal>();
    plan.channels.push_back({.name = input.name,
                             .column = column->channel.value,
                             .unit = unit_of_input(found->second),
                             .given = column->unit.value,
                             .calibration = {.gain = 1.0 / found->second.scale, .delay = column->delay},
                             .is_input = true});
  }
  return plan;
}

}  // namespace kalfem
