#include "kalfem/study/unknown_builder.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/study/parameter_lookup.hpp"
#include "kalfem/study/parameterised_structure.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {

using Eigen::Index;
namespace d = description;

namespace {

/// Units of some laws depend on a parameter ("1/m^n"): these are the same only as they stand.
bool same_dimension(const std::string& one, const std::string& other) try {
  return one == other || parse_unit(one).dimension == parse_unit(other).dimension;
} catch (const InvalidInput&) {
  return false;
}

/// Prior standard deviation or walk: in the parameter's unit, or per cent of the initial value.
double absolute(const d::Value& given, const std::string& unit, double initial) {
  const bool percentage = !given.value.bare && given.value.dimension == Dimension{};
  if (percentage && given.value.value < 0.0)
    throw InvalidInput(given.issue(shortest(100.0 * given.value.value) + " % given", "it must be >= 0"));
  if (percentage && initial == 0.0)
    throw InvalidInput(given.issue("per cent of an initial value of 0", "that is nothing", "give it in its unit"));
  return percentage ? given.value.value * std::abs(initial) : checked_number(given, unit, Bounds::nonnegative());
}

/// Of the prior: half the initial value where the case does not say.
double deviation_of(const d::Unknown& given, const std::string& unit, double initial) {
  const double deviation = given.std ? absolute(*given.std, unit, initial) : 0.5 * std::abs(initial);
  if (deviation > 0.0 && std::isfinite(deviation)) return deviation;
  if (!given.std)
    throw InvalidInput(given.initial.issue("it starts at 0 and has no `std`", "by default std is 50 % of initial",
                                           "give std in its unit"));
  throw InvalidInput(given.std->issue("the standard deviation of the prior is " + shortest(deviation),
                                      "a parameter without uncertainty is not unknown",
                                      "give a positive one, or take the unknown out"));
}

/// The lower (0) or upper (1) bound in SI.
double bound(const d::Unknown& given, std::size_t side, const std::string& unit) {
  const std::string& path = given.initial.path;  // ends with ".initial"
  return checked_number({(*given.bounds)[side], given.initial.location, path.substr(0, path.rfind('.')) + ".bounds"},
                        unit);
}

/// What the transform cannot carry.
void check_start(const d::Unknown& given, const ParameterTransform& transform, const std::string& unit,
                 double initial) {
  if (transform.kind == TransformKind::log && !(initial > 0.0))
    throw InvalidInput(given.initial.issue("it starts at " + shortest(initial), "under transform: log it must be > 0",
                                           "give a positive start, or transform: none"));
  if (!given.bounds) return;
  const double lower = bound(given, 0, unit), upper = bound(given, 1, unit);
  if (!(lower < upper))
    throw InvalidInput(
        given.initial.issue("the lower bound " + shortest(lower) + " is not below the upper one " + shortest(upper), "",
                            "write bounds: [lower, upper]"));
  if (!(lower < initial && initial < upper))
    throw InvalidInput(given.initial.issue(
        "it starts at " + shortest(initial) + ", outside its bounds " + shortest(lower) + " to " + shortest(upper),
        "the start must lie strictly between them", "move the start or the bounds"));
}

/// `positive`: where the case does not say, the parameter is kept so.
ParameterTransform transform_of(const d::Unknown& given, const std::string& unit, bool positive) {
  ParameterTransform transform;
  transform.kind = given.transform.value_or(given.bounds ? TransformKind::logit
                                            : positive   ? TransformKind::log
                                                         : TransformKind::none);
  if (transform.kind == TransformKind::logit) {
    if (!given.bounds)
      throw InvalidInput(given.initial.issue("transform: logit without bounds", "it keeps the parameter between them",
                                             "give bounds: [lower, upper]"));
    transform.lower = bound(given, 0, unit);
    transform.upper = bound(given, 1, unit);
  }
  return transform;
}

}  // namespace

std::vector<d::Name> names_of(const std::string& name, const d::Unknown& given) {
  if (!given.applies_to.empty()) return given.applies_to;
  return {{name, given.initial.location, "estimate.unknown." + name}};
}

/// What an unknown stands for: parameters of connectors and lumped elements, or of linear substructures.
struct UnknownBuilder::Targets {
  std::vector<ParameterReference> of_connectors;
  std::vector<StructureParameter> of_linear_part;

  [[nodiscard]] const std::string& unit() const {
    return of_connectors.empty() ? of_linear_part.front().unit : of_connectors.front().unit;
  }
  /// Numbers of finite elements, and springs and masses among the lumped elements: sigma points near a stiffness of
  /// zero would pull the first estimates away. A dashpot may be nothing, and a law's parameter of either sign.
  [[nodiscard]] bool positive_by_nature() const {
    using Kind = ParameterReference::Kind;
    return std::ranges::all_of(of_connectors, [](const auto& reference) {
      return reference.kind == Kind::spring_stiffness || reference.kind == Kind::mass;
    });
  }
  [[nodiscard]] double value() const {
    return of_connectors.empty() ? of_linear_part.back().value : of_connectors.back().value;
  }
};

void UnknownBuilder::add(const std::string& name, const d::Unknown& given) {
  const auto names = names_of(name, given);
  const auto targets = found(name, names);
  if (!targets) return;
  try {
    const std::string unit = targets->unit();
    const double initial = checked_number(given.initial, unit);
    const bool positive = targets->positive_by_nature() && initial > 0.0;
    UnknownParameter unknown{name, unit, {}, transform_of(given, unit, positive), initial, 0.0, 0.0};
    check_start(given, unknown.transform, unit, initial);
    unknown.deviation = deviation_of(given, unit, initial);
    unknown.random_walk = given.random_walk ? absolute(*given.random_walk, unit, unknown.initial) : 0.0;
    if (const auto value = present_.find(name); value != present_.end()) unknown.initial = value->second;
    unknown.in_linear_part = linear_part_follows(*targets);
    if (unknown.in_linear_part && targets->positive_by_nature() && !(unknown.initial > 0.0))
      throw InvalidInput(given.initial.issue("'" + name + "' starts at " + shortest(unknown.initial) + " " + unit,
                                             "damping of its substructure follows it, and needs it positive",
                                             "start from a positive first guess"));
    for (std::size_t i = 0; i < targets->of_connectors.size(); ++i) add_target(names[i], unknown);
    add_linear(targets->of_linear_part, unknown);
    std::optional<double> truth;
    if (study_.given.simulate) truth = targets->value();
    if (given.truth) truth = checked_number(*given.truth, unit);
    setup_.options.unknowns.push_back(unknown);
    setup_.true_parameters.push_back(truth);
  } catch (const InvalidInput& error) {
    issues_.add(error, given.initial.location);
  }
}

/// Nothing, and an issue a name, where one is not known.
std::optional<UnknownBuilder::Targets> UnknownBuilder::found(const std::string& owner,
                                                             const std::vector<d::Name>& names) {
  Targets targets;
  for (const auto& name : names) {
    const auto reference = find_parameter(study_.parts, name.value);
    if (reference && find_parameter(parts_, name.value) && can_be_released(study_.parts, *reference)) {
      targets.of_connectors.push_back(*reference);
    } else if (auto parameter = find_structure_parameter(study_, name.value); parameter && holds(*parameter)) {
      if (const auto issue = unlike_ratios(study_, *parameter, name))
        issues_.add(issue->location, issue->what, issue->why, issue->fix);
      targets.of_linear_part.push_back(std::move(*parameter));
    } else {
      issues_.add(name.location,
                  name.path + ": there is no parameter '" + name.value + "'" + did_you_mean(name.value, all_names()),
                  "an unknown is a parameter of a connector or of a linear substructure that the filter's model holds",
                  "");
    }
  }
  if (targets.of_connectors.size() + targets.of_linear_part.size() < names.size()) return std::nullopt;
  check_units(owner, names, targets);
  if (targets.of_connectors.empty() || targets.of_linear_part.empty()) return targets;
  issues_.add(names.front().location,
              "estimate.unknown." + owner + " applies to parameters of connectors and of linear substructures",
              "the filter carries the two in different ways", "make it two unknowns");
  return std::nullopt;
}

/// All share one value, so that they have one unit; expressions have none of their own.
void UnknownBuilder::check_units(const std::string& owner, const std::vector<d::Name>& names, const Targets& targets) {
  for (const auto& other : targets.of_connectors) {
    const std::string& unit = targets.of_connectors.front().unit;
    if (unit.empty() || other.unit.empty() || same_dimension(unit, other.unit)) continue;
    issues_.add(names.front().location,
                "estimate.unknown." + owner + " applies to parameters in " + unit + " and in " + other.unit,
                "they share one value", "give parameters of one kind");
    return;
  }
}

bool UnknownBuilder::holds(const StructureParameter& parameter) const {
  const auto named = [&](const auto& part) { return part.name == parameter.substructure; };
  return std::ranges::any_of(parts_.substructures, named) || std::ranges::any_of(parts_.finite_elements, named);
}

std::vector<std::string> UnknownBuilder::all_names() const {
  auto names = parameter_names(study_.parts);
  for (auto& name : structure_parameter_names(study_)) names.push_back(std::move(name));
  return names;
}

void UnknownBuilder::add_target(const d::Name& name, UnknownParameter& unknown) {
  const auto reference = find_parameter(parts_, name.value);
  const auto target = release_linear_element(parts_, *reference, unknown.initial);
  unknown.targets.push_back({static_cast<Index>(target.part), static_cast<Index>(target.element)});
  parts_.connectors[target.part].parameters[static_cast<Index>(target.element)] = unknown.initial;
}

/// Whether damping of the linear part changes with these parameters.
bool UnknownBuilder::linear_part_follows(const Targets& targets) const {
  return std::ranges::any_of(targets.of_connectors, [&](const auto& reference) {
    return kalfem::linear_part_follows(study_.parts, reference);
  });
}

/// Records the unknown as one of the linear part, and where it stands if no connector carries it.
void UnknownBuilder::add_linear(const std::vector<StructureParameter>& targets, const UnknownParameter& unknown) {
  if (targets.empty() && !unknown.in_linear_part) return;
  auto& linear = setup_.linear_unknowns;
  linear.names.push_back(unknown.name);
  linear.initial.push_back(unknown.initial);
  if (targets.empty()) return;
  if (study_.given.update)
    throw InvalidInput("estimate.unknown." + unknown.name + ": a number of a linear substructure, and the case updates",
                       "while the structure is being updated the filter cannot estimate its numbers too",
                       "refine it under update.parameters");
  for (const auto& target : targets) {
    if (target.unit != unknown.unit)
      throw InvalidInput(
          "estimate.unknown." + unknown.name + " applies to numbers in " + unknown.unit + " and in " + target.unit,
          "they share one value", "give parameters of one kind");
    const auto same = [&](const auto& binding) { return binding.target.name == target.name; };
    if (std::ranges::any_of(linear.bindings, same))
      throw InvalidInput("estimate.unknown." + unknown.name + ": '" + target.name + "' is an unknown already",
                         "a parameter has one value", "take one of them out");
    linear.bindings.push_back({static_cast<Index>(linear.names.size()) - 1, target});
  }
}

}  // namespace kalfem
