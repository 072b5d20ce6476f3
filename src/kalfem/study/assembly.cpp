// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/assembly.hpp"

#include <algorithm>
#include <map>

#include "kalfem/study/case_checks.hpp"
#include "kalfem/study/component_parts.hpp"
#include "kalfem/system/laws/law_library.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {
namespace {

using description::Case;

/// Limit for a lumped substructure: its matrices are full, and take 200 MB each at this size.
constexpr std::size_t most_masses = 5000;

std::string qualified(const std::string& node, const std::string& direction) {
  return direction.empty() ? node : node + "." + direction;
}

DofCombination combination(const Named<double>& weights) { return {weights.begin(), weights.end()}; }

void add_chain(LumpedSubstructure& part, const description::Chain& chain) {
  for (int i = 1; i <= chain.masses; ++i) {
    part.masses.push_back({std::to_string(i), chain.mass});
    if (i > 1)
      part.springs.push_back({std::to_string(i - 1) + "-" + std::to_string(i), std::to_string(i - 1), std::to_string(i),
                              chain.stiffness, chain.damping});
  }
}

LumpedSubstructure make_substructure(const std::string& name, const description::Substructure& given) {
  LumpedSubstructure part;
  part.name = name;
  for (const auto& [node, masses] : given.masses)
    for (const auto& [direction, mass] : masses) part.masses.push_back({qualified(node, direction), mass});
  if (given.chain) add_chain(part, *given.chain);
  for (const auto& spring : given.springs)
    part.springs.push_back({spring_name(spring), spring.from.value, spring.to.value, spring.stiffness, spring.damping});
  part.grounds.insert(part.grounds.end(), given.grounds.begin(), given.grounds.end());
  for (const auto& [point, weights] : given.points) part.points[point] = combination(weights);
  part.modal_damping = given.damping.modal;
  part.rayleigh = {given.damping.mass_factor, given.damping.stiffness_factor};
  return part;
}

/// SI unit of a value as it is given; empty for a bare number and for per cent.
std::string given_unit(const description::Value& value) {
  return value.value.bare || value.value.dimension == Dimension{} ? "" : si_unit(value.value.dimension);
}

LawArguments law_arguments(const description::Connector& given) {
  LawArguments arguments;
  for (const auto& [name, value] : given.parameters) arguments.parameters.push_back({name, given_unit(value)});
  arguments.force = given.force;
  for (const auto& [name, state] : given.states)
    arguments.states.push_back({{name, state.unit, "internal state"}, state.rate});
  for (const auto& [name, value] : given.let) arguments.lets.push_back({name, value});
  for (const auto& [name, signal] : given.signals) arguments.signals.push_back({name, "", "signal"});
  return arguments;
}

/// Values in the law's order; a unit of '?' accepts the user's own (expressions).
Eigen::VectorXd parameter_values(const std::string& connector, const description::Connector& given,
                                 const ConnectorLaw& law, IssueList& issues) {
  const auto& quantities = law.parameters();
  Eigen::VectorXd values(static_cast<Eigen::Index>(quantities.size()));
  std::vector<std::string> names;
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    names.push_back(quantities[i].name);
    values[static_cast<Eigen::Index>(i)] = quantities[i].default_value;
    const auto found =
        std::ranges::find(given.parameters, quantities[i].name, &std::pair<std::string, description::Value>::first);
    if (found != given.parameters.end()) {
      try {
        values[static_cast<Eigen::Index>(i)] = given.law.value == "expression"
                                                   ? found->second.value.value
                                                   : checked_number(found->second, quantities[i].unit);
      } catch (const InvalidInput& error) {
        issues.add(error, found->second.location);
        values[static_cast<Eigen::Index>(i)] = 1.0;
      }
    } else if (std::isnan(quantities[i].default_value)) {
      issues.add(given.law.location, connector + ": parameter '" + quantities[i].name + "' is missing",
                 "the law '" + given.law.value + "' needs it: " + quantities[i].meaning,
                 "give it in " + quantities[i].unit);
      values[static_cast<Eigen::Index>(i)] = 1.0;
    }
  }
  for (const auto& [name, value] : given.parameters)
    if (std::ranges::find(names, name) == names.end())
      issues.add(value.location,
                 value.path + ": the law '" + given.law.value + "' has no such parameter" + did_you_mean(name, names));
  return values;
}

/// Reports the values that the law does not allow, each at its own place. The law names the parameter at the start of
/// its issue, which leads back to the key of the case.
void check_ranges(const std::string& connector, const description::Connector& given, const ConnectorLaw& law,
                  const Eigen::VectorXd& values, IssueList& issues) {
  for (const auto& issue : validate_parameters(law, values)) {
    const auto named = [&](const auto& parameter) {
      return issue.what.starts_with("parameter '" + parameter.first + "'");
    };
    const auto found = std::ranges::find_if(given.parameters, named);
    const auto& place = found == given.parameters.end() ? given.law.location : found->second.location;
    issues.add(place, connector + ": " + issue.what, issue.why, issue.fix);
  }
}

/// Refuses `force` and `states` for laws of the library: only law: expression uses them.
void check_expression_keys(const std::string& key_of_case, const description::Connector& given, IssueList& issues) {
  if (given.law.value == "expression") return;
  for (const auto& [key, present] :
       {std::pair{"force", !given.force.empty()}, std::pair{"states", !given.states.empty()},
        std::pair{"let", !given.let.empty()}, std::pair{"signals", !given.signals.empty()}})
    if (present)
      issues.add(given.law.location, key_of_case + ": `" + key + "` is given beside the law '" + given.law.value + "'",
                 "the law has its own force, so this would have no effect",
                 "remove `" + std::string(key) + "`, or write law: expression");
}

/// The signals of a law stand behind its connector, in their order.
void add_signals(const std::string& name, const description::Connector& given, StructureParts& parts) {
  for (const auto& [signal, feed] : given.signals)
    parts.connectors.push_back({name + "." + signal, fixed_ground, signal_ground(name, signal), signal_law(),
                                Eigen::VectorXd(0), feed.location});
}

/// `key`: of the connector in the case.
void add_connector(const std::string& name, const std::string& key, const description::Connector& given,
                   StructureParts& parts, IssueList& issues) {
  check_expression_keys(key, given, issues);
  try {
    const auto law = make_law(given.law.value, law_arguments(given));
    IssueList own;
    const auto values = parameter_values(key, given, *law, own);
    if (own.empty()) check_ranges(key, given, *law, values, own);
    for (const auto& [location, what, why, fix] : own.issues()) issues.add(location, what, why, fix);
    parts.connectors.push_back({name, given.from.value, given.to.value, law, values, given.from.location});
    add_signals(name, given, parts);
  } catch (const InvalidInput& error) {
    for (const auto& issue : error.issues())
      issues.add(given.law.location, key + ": " + issue.what, issue.why, issue.fix);
  }
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

/// The ground whose displacement, or velocity, an excitation gives; null where it is another one.
const Name* displaced_ground(const description::Excitation& given) {
  if (const auto* base = std::get_if<description::BaseDisplacement>(&given.target)) return &base->ground;
  const auto* base = std::get_if<description::BaseVelocity>(&given.target);
  return base ? &base->ground : nullptr;
}

/// Translates the target of an excitation. Accelerated grounds become displaced ones, whose displacement is the
/// integral of the signal; an accelerated base without named grounds stays an acceleration of the whole structure.
InputDescription make_input(const std::string& name, const description::Excitation& given, bool of_grounds) {
  if (const auto* ground = displaced_ground(given))
    return {name, InputKind::base_displacement, ground->value, {}, ground->location};
  if (const auto* force = std::get_if<description::Force>(&given.target))
    return {name, InputKind::force, force->point.value, {}, force->point.location};
  if (const auto* signal = std::get_if<description::SignalTarget>(&given.target))
    return {name, InputKind::base_displacement, signal->ground.value, {}, signal->ground.location};
  const auto& [direction, location, path] = std::get<description::BaseAcceleration>(given.target).direction;
  if (of_grounds)
    return {name, InputKind::base_displacement, direction.front().first, combination(direction), location};
  const bool all = direction.size() == 1 && direction.front().first == "all";
  return {name, InputKind::base_acceleration, "", all ? DofCombination{} : combination(direction), location};
}

/// Modal damping of the whole structure. In a lumped structure every mode has its ratio; only finite elements use the
/// limit `up_to`.
GlobalModalDamping global_modal_damping(const Case& given, IssueList& issues) {
  const auto& damping = given.damping->value;
  GlobalModalDamping result{damping.modal, {}};
  for (const auto& [name, part] : given.substructures) {
    if (part.finite_elements) result.up_to = damping.up_to;
    if (!part.damping.modal.empty())
      issues.add(given.damping->location,
                 "damping: modal damping is given for the whole structure and for substructure '" + name + "'",
                 "its modes would be damped twice", "remove one of the two");
  }
  if (given.estimate && given.estimate->local)
    issues.add(given.damping->location,
               "damping: modal damping is given for the whole structure, but the filter's model is local",
               "a part of the structure does not have its modes", "give the substructures their own damping");
  return result;
}

/// Reports the issues that the library finds in a lumped substructure, with their places in the file. An issue that
/// quotes a spring stands at that spring, all others at the substructure.
void check_substructure(const Case& given, const std::string& name, const LumpedSubstructure& part,
                        const description::Substructure& described, IssueList& issues) {
  const auto found = validate(part);
  if (found.empty()) return;
  std::map<std::string, SourceLocation> springs;
  for (const auto& spring : described.springs)
    springs.emplace("spring '" + name + "." + spring_name(spring) + "'", spring.from.location);
  const SourceLocation place = given.source.at({"substructures", name});
  for (const auto& issue : found) {
    const auto spring = springs.find(issue.what.substr(0, issue.what.find('\'', issue.what.find('\'') + 1) + 1));
    issues.add(spring == springs.end() ? place : spring->second, issue.what, issue.why, issue.fix);
  }
}

/// Number of masses of a lumped substructure.
std::size_t masses_of(const description::Substructure& given) {
  std::size_t count = given.chain ? static_cast<std::size_t>(given.chain->masses) : 0;
  for (const auto& [node, masses] : given.masses) count += masses.size();
  return count;
}

}  // namespace

std::string spring_name(const description::Spring& spring) {
  return spring.name.empty() ? spring.from.value + "-" + spring.to.value : spring.name;
}

bool accelerates_grounds(const Case& given, const description::Excitation& excitation) {
  const auto* base = std::get_if<description::BaseAcceleration>(&excitation.target);
  if (!base) return false;
  std::vector<std::string> grounds;
  for (const auto& [part, substructure] : given.substructures) {
    grounds.push_back(part + ".ground");
    for (const auto& ground : substructure.grounds) grounds.push_back(part + "." + ground);
  }
  return std::ranges::any_of(base->direction.value, [&](const auto& each) { return contains(grounds, each.first); });
}

std::vector<std::string> attached_points(const Case& given, const std::string& substructure) {
  std::vector<std::string> points;
  const auto add = [&](const std::string& point) {
    if (point.starts_with(substructure + ".")) points.push_back(point.substr(substructure.size() + 1));
  };
  for (const auto& [name, connector] : given.connectors) {
    add(connector.from.value);
    add(connector.to.value);
  }
  for (const auto& [name, excitation] : given.excitation)
    if (const auto* force = std::get_if<description::Force>(&excitation.target)) add(force->point.value);
  return points;
}

StructureParts make_parts(const Case& given, std::vector<Substructure> finite_elements, IssueList& issues) {
  StructureParts parts;
  parts.finite_elements = std::move(finite_elements);
  for (const auto& [name, part] : given.substructures) {
    if (part.finite_elements) {
      if (!part.masses.empty() || part.chain)
        issues.add(part.finite_elements->location(),
                   "substructures." + name + " has both finite elements and masses or a chain",
                   "only one of them is possible", "give masses at nodes under finite_elements.masses");
      continue;
    }
    if (const auto masses = masses_of(part); masses > most_masses) {
      issues.add(given.source.at({"substructures", name}),
                 "substructures." + name + " has " + std::to_string(masses) + " masses",
                 "a lumped substructure has full matrices, so at most " + std::to_string(most_masses) + " masses",
                 "describe a larger one by finite_elements or by its matrices");
      continue;
    }
    parts.substructures.push_back(make_substructure(name, part));
    if (consists_of_grounds(name, given)) continue;
    if (parts.substructures.back().masses.empty())
      issues.add(given.source.at({"substructures", name}), "substructures." + name + " has no masses",
                 "it has no degrees of freedom", "give it `masses`, a `chain` or `finite_elements`");
    check_substructure(given, name, parts.substructures.back(), part, issues);
  }
  const bool points_are_known = issues.empty();
  for (const auto& [name, connector] : given.connectors)
    add_connector(name, key_of_connector(name, given), connector, parts, issues);
  for (const auto& [name, excitation] : given.excitation)
    parts.inputs.push_back(make_input(name, excitation, accelerates_grounds(given, excitation)));
  if (given.damping) parts.damping = global_modal_damping(given, issues);
  if (points_are_known) check_places(given, parts, issues);
  return parts;
}

}  // namespace kalfem
