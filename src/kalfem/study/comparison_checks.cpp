// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/updating_setup.hpp"

#include <algorithm>
#include <set>

#include "kalfem/casefile/update_description.hpp"
#include "kalfem/identification/released_elements.hpp"
#include "kalfem/study/estimation_problem_of.hpp"
#include "kalfem/study/filter_checks.hpp"

namespace kalfem {
namespace {

namespace d = description;

const Name& substructure_of(const d::Comparison& given) {
  static const Name none;
  return std::visit(
      [](const auto& data) -> const Name& {
        if constexpr (requires { data.substructure; }) return data.substructure;
        return none;
      },
      given.data);
}

/// Refuses unknowns of the filter in a substructure that the estimated motion of its boundary drives: that comparison
/// would keep their initial values.
void check_unknowns_of_driven_part(const CaseStudy& study, const Name& substructure, IssueList& issues) {
  const ParameterSet known(*study.structure);
  for (const auto& [name, given] : study.given.estimate->unknown)
    for (const auto& target : names_of(name, given)) {
      const auto element = known.find(target.value);
      if (!element || element->owner != substructure.value || !can_be_released(study.structure->parts, *element))
        continue;
      issues.add(target.location,
                 target.path + ": '" + target.value + "' is an unknown of the filter, but " + substructure.path +
                     " compares the record with its substructure",
                 "in that comparison it would keep its initial value", "list it under update.parameters instead");
    }
}

const std::vector<Name>* sensors_of(const d::Comparison& given) {
  if (const auto* driven = std::get_if<d::DrivenHistory>(&given.data)) return &driven->sensors;
  if (const auto* simulated = std::get_if<d::SimulatedHistory>(&given.data)) return &simulated->sensors;
  return nullptr;
}

/// Motion sensors whose points all belong to one substructure.
std::vector<std::string> sensors_on(const CaseStudy& study, const std::string& substructure) {
  std::vector<std::string> names;
  for (const auto& sensor : study.sensors)
    if (is_motion(sensor.output.quantity) && std::ranges::all_of(sensor.output.points, [&](const auto& point) {
          return point.first.starts_with(substructure + ".");
        }))
      names.push_back(sensor.name);
  return names;
}

/// Refuses an entry that is listed twice: it would count twice.
void check_twice(const std::vector<Name>& names, IssueList& issues) {
  std::set<std::string> seen;
  for (const auto& name : names)
    if (!seen.insert(name.value).second)
      issues.add(name.location, name.path + ": '" + name.value + "' is given twice", "it would be counted twice",
                 "remove one of them");
}

double samples_of(const CaseStudy& study) {
  if (study.record) return static_cast<double>(study.record->record.samples());
  return study.given.simulate->duration * study.given.simulate->sample_rate + 1.0;
}

/// Checks one comparison by names and sections alone. Its substructure must exist. An FRF excludes damping of the whole
/// structure, whose share in the substructure is unknown. A comparison with the record needs a record, sensors that
/// exist and, if it drives a substructure, an estimate of the boundary motion. The sensors are resolved only if none of
/// these is wrong.
class ComparisonCheck {
public:
  ComparisonCheck(const CaseStudy& study, const Located<d::Comparison>& comparison, IssueList& issues)
      : study_(study), comparison_(comparison), issues_(issues) {}

  void run() {
    check_substructure();
    if (const auto* frf = std::get_if<d::FrfData>(&comparison_.value.data)) check_frf(*frf);
    if (const auto* modal = std::get_if<d::ModalData>(&comparison_.value.data)) check_modes(*modal);
    if (const auto* sensors = sensors_of(comparison_.value)) check_record(*sensors);
  }

private:
  [[nodiscard]] bool is_driven() const { return std::holds_alternative<d::DrivenHistory>(comparison_.value.data); }

  void check_substructure() {
    std::vector<std::string> parts;
    for (const auto& [name, part] : study_.given.substructures) parts.push_back(name);
    const auto& part = substructure_of(comparison_.value);
    if (!part.path.empty() && std::ranges::find(parts, part.value) == parts.end())
      issues_.add(part.location,
                  part.path + ": there is no substructure '" + part.value + "'" + did_you_mean(part.value, parts));
  }

  void check_frf(const d::FrfData& frf) {
    if (study_.given.damping)
      issues_.add(comparison_.location,
                  comparison_.path + " compares one substructure, but modal damping is given for the whole structure",
                  "the damping of the substructure alone is unknown",
                  "give the substructure its own modal damping instead of `damping`");
    check_twice(frf.outputs, issues_);
  }

  void check_modes(const d::ModalData& modal) {
    if (study_.given.damping && has_dampings(modal))
      issues_.add(comparison_.location,
                  comparison_.path +
                      " compares dampings of one substructure, but modal damping is given for the whole structure",
                  "the damping of the substructure alone is unknown",
                  "give the substructure its own modal damping instead of `damping`");
    if (std::set<int>(modal.model_modes.begin(), modal.model_modes.end()).size() < modal.model_modes.size())
      issues_.add(comparison_.location, comparison_.path + ".model_modes: a mode is listed twice",
                  "each measured mode needs its own mode of the model", "correct the numbers");
  }

  void check_record(const std::vector<Name>& sensors) {
    check_twice(sensors, issues_);
    const std::size_t before = issues_.issues().size();
    check_sensors_exist(sensors);
    if (!study_.given.simulate && !study_.given.record)
      issues_.add(comparison_.location, comparison_.path + " compares with a record, but the case has none", "",
                  "add `record` or `simulate`");
    if (is_driven() && study_.given.estimate)
      check_unknowns_of_driven_part(study_, substructure_of(comparison_.value), issues_);
    if (issues_.issues().size() == before) check_compared_sensors();
    if (is_driven() && !study_.given.estimate)
      issues_.add(comparison_.location,
                  comparison_.path + " needs the motion of the boundary, but the case does not estimate it", "",
                  "add `estimate`");
  }

  void check_sensors_exist(const std::vector<Name>& sensors) {
    std::vector<std::string> known;
    for (const auto& sensor : study_.sensors) known.push_back(sensor.name);
    for (const auto& sensor : sensors)
      if ((sensor.value != "all" || is_driven()) && std::ranges::find(known, sensor.value) == known.end())
        issues_.add(sensor.location,
                    sensor.path + ": there is no sensor '" + sensor.value + "'" + did_you_mean(sensor.value, known));
  }

  void check_compared_sensors() {
    try {
      if (const auto* driven = std::get_if<d::DrivenHistory>(&comparison_.value.data))
        compared_sensors(study_, *driven);
      if (const auto* simulated = std::get_if<d::SimulatedHistory>(&comparison_.value.data))
        compared_sensors(study_, *simulated);
    } catch (const InvalidInput& error) {
      add_at(comparison_.location, error, issues_);
    }
  }

  const CaseStudy& study_;
  const Located<d::Comparison>& comparison_;
  IssueList& issues_;
};

}  // namespace

std::vector<std::string> compared_sensors(const CaseStudy& study, const description::DrivenHistory& given) {
  const auto own = sensors_on(study, given.substructure.value);
  std::vector<std::string> sensors;
  IssueList issues;
  for (const auto& name : given.sensors) {
    sensors.push_back(name.value);
    if (std::ranges::find(own, name.value) == own.end())
      issues.add(name.location,
                 name.path + ": sensor '" + name.value + "' does not measure the motion of '" +
                     given.substructure.value + "' alone",
                 "its points must belong to that substructure");
  }
  issues.raise();
  if (sensors.empty()) sensors = own;
  if (sensors.empty())
    throw InvalidInput(given.substructure.issue("no sensor measures the motion of '" + given.substructure.value + "'",
                                                "there is nothing to compare with"));
  return sensors;
}

std::vector<std::string> compared_sensors(const CaseStudy& study, const description::SimulatedHistory& given) {
  std::vector<std::string> sensors;
  for (const auto& sensor : study.sensors)
    if (std::ranges::any_of(given.sensors,
                            [&](const auto& name) { return name.value == "all" || name.value == sensor.name; }))
      sensors.push_back(sensor.name);
  if (sensors.empty()) throw InvalidInput("no sensor is listed", "", "list some, or write simulation: all");
  return sensors;
}

void check_comparisons(const CaseStudy& study, IssueList& issues) {
  double weights = 0.0;
  for (const auto& [name, given] : study.given.update->comparisons) weights += given.value.weight;
  if (!study.given.update->comparisons.empty() && weights == 0.0)
    issues.add(study.given.source.at({"update", "compare"}), "every comparison has weight 0",
               "no measurement is left for the updating", "give at least one a weight > 0");
  for (const auto& [name, given] : study.given.update->comparisons) ComparisonCheck(study, given, issues).run();
}

void check_driven_histories(const CaseStudy& study, const CoupledModel& start, IssueList& issues) {
  for (const auto& [name, given] : study.given.update->comparisons) {
    const auto* driven = std::get_if<d::DrivenHistory>(&given.value.data);
    if (!driven) continue;
    try {
      check_driven(study, start, driven->substructure);
    } catch (const InvalidInput& error) {
      add_at(driven->substructure.location, error, issues);
    }
    const double settle = study.given.estimate->settle.value_or(0.0);
    if (settle * study.sample_rate() >= samples_of(study) - 1.5)
      issues.add(study.given.source.at({"estimate", "settle"}),
                 "estimate.settle: " + shortest(settle) + " s cover the whole record",
                 "'" + given.path + "' compares the samples after this time", "shorten it");
  }
}

}  // namespace kalfem
