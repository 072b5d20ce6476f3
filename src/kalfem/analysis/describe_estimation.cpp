// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kalfem/analysis/case_sections.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/base/units.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// A number in SI.
d::Value bare(double value) { return {{value, {}, true}, {}, {}}; }

d::ObservedPoints observed(const OutputDescription& output) {
  using enum ObservedQuantity;
  const d::Points points{{output.points.begin(), output.points.end()}, {}, {}};
  switch (output.quantity) {
    case displacement:
      return d::Observed<displacement>{points};
    case velocity:
      return d::Observed<velocity>{points};
    case acceleration:
      break;
    case connector_force:
      return d::Observed<connector_force>{points};
    case connector_deformation:
      return d::Observed<connector_deformation>{points};
    case connector_rate:
      return d::Observed<connector_rate>{points};
    case strain:
      return d::Observed<strain>{points};
  }
  return d::Observed<acceleration>{points};
}

/// Writes the sections that tell what is estimated from which record.
class EstimationSections {
public:
  EstimationSections(const Analysis& analysis, CaseInMaking& making)
      : analysis_(analysis), options_(*analysis.estimate), making_(making) {}

  void write() {
    for (const auto& sensor : options_.sensors) making_.given.sensors.emplace_back(sensor.name, described(sensor));
    if (analysis_.record)
      write_record(*analysis_.record);
    else
      making_.refuse("there is no record", "an estimation is one from a record", "give it");
    write_estimate();
  }

private:
  d::Sensor described(const SensorDescription& given) {
    d::Sensor sensor{.observed = observed(given.output),
                     .relative = given.output.relative_to_base,
                     .noise = bare(given.noise),
                     .chain = given.chain.sections,
                     .unit = {}};
    for (const auto& section : given.chain.sections)
      if (const auto* delay = std::get_if<DelaySection>(&section); delay && delay->order != DelaySection{}.order)
        making_.refuse("sensor '" + given.name + "' has a delay of order " + std::to_string(delay->order),
                       "in a case it is " + std::to_string(DelaySection{}.order), "");
    if (!given.output.carried_masses.empty()) set_mass(given, sensor);
    return sensor;
  }

  /// The mass between a load cell and its connector, which stands at one of the connector's ends.
  void set_mass(const SensorDescription& given, d::Sensor& sensor) {
    const auto& [point, mass] = *given.output.carried_masses.begin();
    const auto& [name, weight] = *given.output.points.begin();
    const auto& connectors = analysis_.structure.description().parts.connectors;
    const auto connector = std::ranges::find(connectors, name, &ConnectorDescription::name);
    const bool simple = given.output.carried_masses.size() == 1 && given.output.points.size() == 1;
    if (!simple || connector == connectors.end())
      return making_.refuse("sensor '" + given.name + "' carries several masses", "a load cell has one", "");
    const bool at_to = connector->to == point;
    sensor.mass = {(at_to ? mass : -mass) / weight, {}, {}};
    sensor.mass_at = at_to ? d::ConnectorEnd::to : d::ConnectorEnd::from;
  }

  void write_record(const Record& all) {
    std::vector<std::string> names;
    for (const auto& sensor : options_.sensors) names.push_back(sensor.name);
    Record record = select_channels(all, names);
    if (record.used) making_.refuse("the filter learns from a part of the record", "a case cuts its record", "cut it");
    for (std::size_t i = 0; i < names.size(); ++i) {
      record.channels[i].unit = unit_of(options_.sensors[i].output.quantity);
      const auto row = record.values.row(static_cast<Eigen::Index>(i)).array();
      making_.given.sensors[i].second.accept_constant = (row == row[0]).all();
    }
    auto& written = making_.given.record.emplace();
    written.sample_rate = record.sample_rate;
    written.skip_missing = !record.values.allFinite();
    written.file = {making_.add_file("", record), {}, {}};
  }

  void write_estimate() {
    auto& estimate = making_.given.estimate.emplace();
    if (!options_.outputs.empty())
      making_.refuse("virtual sensors are asked for: '" + options_.outputs.front().name + "'",
                     "a case estimates the motion of all points", "leave `outputs` empty");
    estimate.filter = options_.filter;
    for (const auto& unknown : options_.unknowns) estimate.unknown.emplace_back(unknown.name, described(unknown));
    for (const auto& [point, prior] : options_.initial_state)
      estimate.initial_state.push_back({point, {prior, {}, {}}});
    for (const auto& [state, prior] : options_.initial_connector_states)
      estimate.initial_connector_states.push_back({state, {prior, {}, {}}});
    estimate.initial_state_from_record = options_.initial_state_from_record;
    estimate.process_noise.acceleration = options_.process_noise;
    const auto& [sensors, process, memory] = options_.adaptive_noise;
    estimate.adaptive_noise = {sensors, process, memory};
    estimate.settle = options_.settle;
    estimate.estimate_initial_state = options_.estimate_initial_state;
    estimate.passes = options_.passes;
    estimate.substeps = options_.substeps;
    estimate.step_order = {options_.step_order, {}, {}};
    estimate.threads = options_.threads;
    estimate.diagnose = options_.diagnose;
    estimate.second_thoughts = options_.second_thoughts;
    estimate.free = options_.free;
    for (const auto& known : options_.known_to)
      estimate.known_to.push_back({known.name, {{known.deviation, {}, !known.relative, known.relative}, {}, {}}});
  }

  d::Unknown described(const UnknownDescription& unknown) {
    const auto& [name, prior] = unknown;
    const std::string& target = prior.applies_to.empty() ? name : prior.applies_to.front();
    d::Unknown given{.initial = bare(prior.initial ? *prior.initial : analysis_.structure.value(target))};
    if (prior.std != 0.0) given.std = bare(prior.std);
    if (prior.random_walk != 0.0) given.random_walk = bare(prior.random_walk);
    if (prior.transform) {
      given.transform = prior.transform->kind;
      if (prior.transform->kind == TransformKind::logit)
        given.bounds = {Quantity{.value = prior.transform->lower}, Quantity{.value = prior.transform->upper}};
    }
    for (const auto& each : prior.applies_to) given.applies_to.push_back({each, {}, {}});
    return given;
  }

  const Analysis& analysis_;
  const EstimateOptions& options_;
  CaseInMaking& making_;
};

}  // namespace

void describe_estimation(const Analysis& analysis, CaseInMaking& making) {
  EstimationSections(analysis, making).write();
}

}  // namespace kalfem
