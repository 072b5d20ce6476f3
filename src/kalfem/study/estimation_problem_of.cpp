// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/estimation_problem_of.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "kalfem/identification/local_model.hpp"
#include "kalfem/identification/released_elements.hpp"
#include "kalfem/study/sensor_unknowns.hpp"
#include "kalfem/study/spread.hpp"
#include "kalfem/study/unknown_inputs_of.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// Some laws have units that depend on a parameter ("1/m^n"). These are equal only if their texts are.
bool same_dimension(const std::string& one, const std::string& other) try {
  return one == other || parse_unit(one).dimension == parse_unit(other).dimension;
} catch (const InvalidInput&) {
  return false;
}

/// Standard deviation of the prior; half the initial value if the case gives none.
double deviation_of(const d::Unknown& given, const std::string& unit, double initial) {
  const double deviation = given.std ? spread_about(*given.std, unit, initial) : 0.5 * std::abs(initial);
  if (deviation > 0.0 && std::isfinite(deviation)) return deviation;
  if (!given.std)
    throw InvalidInput(given.initial.issue("its initial value is 0 and it has no `std`",
                                           "the default of std is 50 % of initial",
                                           "give std in the parameter's unit"));
  throw InvalidInput(given.std->issue("the standard deviation of the prior is " + shortest(deviation), "it must be > 0",
                                      "to hold a parameter fixed, remove it from estimate.unknown"));
}

/// The lower (0) or upper (1) bound in SI.
double bound(const d::Unknown& given, std::size_t side, const std::string& unit) {
  const std::string& path = given.initial.path;  // ends with ".initial"
  return checked_number({(*given.bounds)[side], given.initial.location, path.substr(0, path.rfind('.')) + ".bounds"},
                        unit);
}

/// Refuses an initial value outside the range of the transform.
void check_start(const d::Unknown& given, const ParameterTransform& transform, const std::string& unit,
                 double initial) {
  if (transform.kind == TransformKind::log && !(initial > 0.0))
    throw InvalidInput(given.initial.issue("its initial value is " + shortest(initial),
                                           "with transform: log it must be > 0",
                                           "give a positive initial value or use transform: none"));
  if (!given.bounds) return;
  const double lower = bound(given, 0, unit), upper = bound(given, 1, unit);
  if (!(lower < upper))
    throw InvalidInput(
        given.initial.issue("the lower bound " + shortest(lower) + " is not below the upper one " + shortest(upper), "",
                            "write bounds: [lower, upper]"));
  if (!(lower < initial && initial < upper))
    throw InvalidInput(given.initial.issue("its initial value is " + shortest(initial) + ", outside its bounds " +
                                               shortest(lower) + " to " + shortest(upper),
                                           "it must lie strictly between the bounds",
                                           "change the initial value or the bounds"));
}

/// The transform of the case; otherwise logit with bounds, log if the parameter is `positive`, or none.
ParameterTransform transform_of(const d::Unknown& given, const std::string& unit, bool positive) {
  ParameterTransform transform;
  transform.kind = given.transform.value_or(given.bounds ? TransformKind::logit
                                            : positive   ? TransformKind::log
                                                         : TransformKind::none);
  if (transform.kind == TransformKind::logit) {
    if (!given.bounds)
      throw InvalidInput(given.initial.issue("transform: logit without bounds",
                                             "this transform keeps the parameter between bounds",
                                             "give bounds: [lower, upper]"));
    transform.lower = bound(given, 0, unit);
    transform.upper = bound(given, 1, unit);
  }
  return transform;
}

/// The part of the structure that the filter's model holds.
StructureModel held_structure(const CaseStudy& study, IssueList& issues) {
  StructureModel held = *study.structure;
  if (!study.given.estimate->local) return held;
  AugmentedModelSetup unused;
  LocalModel(*study.given.estimate->local, held.parts, issues).apply(unused);
  std::erase_if(held.finite_elements, [&](const auto& elements) {
    return std::ranges::none_of(held.parts.finite_elements,
                                [&](const auto& part) { return part.name == elements.part->name; });
  });
  return held;
}

/// Translates unknowns one by one. For each it looks up the targets in the part of the structure that the filter's
/// model holds, checks that they share a unit and are treated alike, converts the numbers to SI, and chooses the
/// transform. A problem drops the unknown and the next one follows.
class UnknownReader {
public:
  UnknownReader(const CaseStudy& study, const StructureModel& held, IssueList& issues)
      : study_(study), known_(held), all_(*study.structure), issues_(issues) {}

  std::optional<Unknown> read(const std::string& name, const d::Unknown& given) {
    const auto names = names_of(name, given);
    Unknown unknown{.name = name, .targets = targets_of(name, names), .location = given.initial.location};
    if (unknown.targets.empty()) return std::nullopt;
    try {
      take_unit(given, unknown);
      set_numbers(given, unknown);
      check_linear(unknown);
    } catch (const InvalidInput& error) {
      issues_.add(error, given.initial.location);
      return std::nullopt;
    }
    return unknown;
  }

private:
  [[nodiscard]] bool is_released(const Parameter& target) const {
    return can_be_released(study_.structure->parts, target);
  }

  /// The parameters with these names. Empty, with issues, if one is unknown or if they cannot share a value.
  std::vector<Parameter> targets_of(const std::string& owner, const std::vector<Name>& names) {
    std::vector<Parameter> targets;
    for (const auto& name : names) {
      auto parameter = known_.find(name.value);
      if (!parameter) {
        issues_.add(name.location,
                    name.path + ": there is no parameter '" + name.value + "'" + did_you_mean(name.value, all_.names()),
                    "an unknown must be a parameter of a connector or of a linear substructure in the filter's model",
                    "");
        continue;
      }
      if (const auto issue = unlike_ratios(study_.given, *parameter, name))
        issues_.add(issue->location, issue->what, issue->why, issue->fix);
      targets.push_back(std::move(*parameter));
    }
    if (targets.size() < names.size()) return {};
    check_units(owner, names, targets);
    const auto released = std::ranges::count_if(targets, [&](const auto& target) { return is_released(target); });
    if (released == 0 || released == std::ssize(targets)) return targets;
    issues_.add(names.front().location,
                "estimate.unknown." + owner + " applies to parameters of connectors and of linear substructures",
                "the filter treats them in different ways", "make two unknowns");
    return {};
  }

  /// All share one value, so they need one unit. Parameters of expressions may have none.
  void check_units(const std::string& owner, const std::vector<Name>& names, const std::vector<Parameter>& targets) {
    const std::string& unit = targets.front().unit;
    for (const auto& other : targets) {
      if (unit.empty() || other.unit.empty() || same_dimension(unit, other.unit)) continue;
      issues_.add(names.front().location,
                  "estimate.unknown." + owner + " applies to parameters in " + unit + " and in " + other.unit,
                  "parameters that share a value need the same unit", "list parameters of the same kind");
      return;
    }
  }

  /// A parameter of an expression that was given as a bare number takes the unit of its initial value.
  static void take_unit(const d::Unknown& given, Unknown& unknown) {
    const auto& initial = given.initial.value;
    if (initial.bare || initial.dimension == Dimension{}) return;
    for (Parameter& target : unknown.targets)
      if (target.of_connector() && target.unit.empty()) target.unit = si_unit(initial.dimension);
  }

  void set_numbers(const d::Unknown& given, Unknown& unknown) const {
    const std::string& unit = unknown.unit();
    unknown.initial = checked_number(given.initial, unit);
    const bool positive = unknown.initial > 0.0 && (!is_released(unknown.targets.front()) ||
                                                    std::ranges::all_of(unknown.targets, is_positive_by_nature));
    unknown.transform = transform_of(given, unit, positive);
    check_start(given, unknown.transform, unit, unknown.initial);
    unknown.deviation = deviation_of(given, unit, unknown.initial);
    unknown.random_walk =
        given.random_walk ? spread_about(walk_in(*given.random_walk, unit), unit, unknown.initial) : 0.0;
    if (study_.given.simulate) unknown.truth = unknown.targets.back().value;
    if (given.truth) unknown.truth = checked_number(*given.truth, unit);
  }

  /// Checks an unknown of a linear substructure.
  void check_linear(const Unknown& unknown) {
    if (is_released(unknown.targets.front())) return;
    if (study_.given.update)
      throw InvalidInput(
          "estimate.unknown." + unknown.name + ": a parameter of a linear substructure, but the case has `update`",
          "during updating the filter cannot estimate parameters of linear substructures",
          "list it under update.parameters");
    for (const auto& target : unknown.targets)
      if (!linear_.insert(target.name).second)
        throw InvalidInput("estimate.unknown." + unknown.name + ": '" + target.name + "' is already an unknown",
                           "a parameter can have only one value", "remove one of them");
  }

  const CaseStudy& study_;
  ParameterSet known_;  ///< of the part that the filter's model holds
  ParameterSet all_;
  IssueList& issues_;
  std::set<std::string> linear_;  ///< names that no connector carries
};

std::vector<SensorOffset> rest_positions(const CaseStudy& study) {
  if (!study.record || !study.record->free_response || !study.record->free_response->rest_is_unknown()) return {};
  std::vector<SensorOffset> rests;
  for (const auto& sensor : study.sensors)
    rests.push_back(
        rest_position(sensor.name, study.record->free_response->deviation[study.record->record.find(sensor.name)]));
  return rests;
}

}  // namespace

EstimationProblem make_estimation_problem(const CaseStudy& study, IssueList& issues) {
  const d::Estimation& given = *study.given.estimate;
  EstimationProblem problem{study.structure, study.sensors, rest_positions(study), study.sample_rate(), {}};
  problem.settings = {.filter = given.filter,
                      .unscented = given.unscented,
                      .unknowns = {},
                      .initial_state = given.initial_state,
                      .initial_state_from_record = given.initial_state_from_record,
                      .initial_connector_states = given.initial_connector_states,
                      .process_noise = given.process_noise,
                      .adaptive_noise = given.adaptive_noise,
                      .local = given.local,
                      .settle = given.settle,
                      .estimate_initial_state = given.estimate_initial_state,
                      .passes = given.passes,
                      .substeps = given.substeps,
                      .step_order = given.step_order ? given.step_order->value : 4,
                      .threads = given.threads,
                      .outliers = given.outliers,
                      .diagnose = given.diagnose,
                      .second_thoughts = given.second_thoughts.value_or(given.diagnose ? StepBudget::unlimited : 0.0),
                      .smooth = given.smooth,
                      .free = given.free};
  if (study.record) problem.settings.clocks_since = study.record->began;
  problem.settings.unknown_inputs = unknown_inputs_of(study, issues);
  const StructureModel held = held_structure(study, issues);
  if (!issues.empty()) return problem;
  UnknownReader reader(study, held, issues);
  for (const auto& [name, unknown] : given.unknown) {
    if (!is_measurement_unknown(name)) {
      if (auto read = reader.read(name, unknown)) problem.settings.unknowns.push_back(std::move(*read));
      continue;
    }
    try {
      add_measurement_unknown(study, name, unknown, problem);
    } catch (const InvalidInput& error) {
      issues.add(error, unknown.initial.location);
    }
  }
  return problem;
}

std::vector<Name> names_of(const std::string& name, const description::Unknown& given) {
  if (!given.applies_to.empty()) return given.applies_to;
  return {{name, given.initial.location, "estimate.unknown." + name}};
}

std::optional<Issue> unlike_ratios(const description::Case& given, const Parameter& parameter, const Name& name) {
  if (!parameter.name.ends_with(".damping.modal")) return std::nullopt;
  const auto& ratios =
      std::ranges::find(given.substructures, parameter.owner, &std::pair<std::string, description::Substructure>::first)
          ->second.damping.modal;
  if (std::ranges::adjacent_find(ratios, std::ranges::not_equal_to{}) == ratios.end()) return std::nullopt;
  std::string listed;
  for (const double ratio : ratios) listed += (listed.empty() ? "" : ", ") + shortest(100.0 * ratio) + " %";
  return name.issue(
      "'" + parameter.name + "' is one value for all modal damping ratios, but the case gives [" + listed + "]",
      "the ratios would all become equal",
      "name single ratios, " + parameter.name + ".1 and so on; use applies_to for several that share a value");
}

}  // namespace kalfem
