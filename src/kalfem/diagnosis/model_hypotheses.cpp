// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "kalfem/diagnosis/candidates.hpp"
#include "kalfem/identification/fixed_numbers.hpp"
#include "kalfem/system/laws/law_library.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double prior_of_law = 0.3;  ///< of each further term of a law, relative to the connector's force
constexpr std::size_t most_parameters = 80;
constexpr const char* suffix = " (further terms)";

bool contains(const std::vector<std::string>& all, const std::string& name) {
  return std::ranges::find(all, name) != all.end();
}

/// Parameters that neither the filter nor an updating found, at a value other than zero.
std::vector<Parameter> fixed_parameters(const DiagnosisInput& input) {
  const EstimationProblem& problem = *input.problem;
  auto fixed =
      kalfem::fixed_parameters(*problem.structure, input.parts, estimated_parameters(problem.settings, input.updated));
  std::erase_if(fixed, [&](const Parameter& each) { return each.value == 0.0 || contains(input.added, each.owner); });
  return fixed;
}

/// "stiffness" of "body.1-2.stiffness".
std::string kind_of(const Parameter& parameter) { return parameter.name.substr(parameter.name.rfind('.') + 1); }

std::string joined(const std::vector<Parameter>& parameters) {
  if (parameters.size() > 4) return fmt::format("{} to {}", parameters.front().name, parameters.back().name);
  std::string names;
  for (const auto& each : parameters) names += (names.empty() ? "" : ", ") + each.name;
  return names;
}

/// Single parameters, then those of one kind and value that a case states in one place: the springs of a chain, the
/// same parameter of equal suspensions.
std::vector<std::vector<Parameter>> candidates_of(const DiagnosisInput& input) {
  const auto fixed = fixed_parameters(input);
  std::vector<std::vector<Parameter>> candidates;
  std::map<std::tuple<std::string, std::string, double>, std::vector<Parameter>> alike;
  for (const auto& parameter : fixed) {
    if (candidates.size() < most_parameters) candidates.push_back({parameter});
    const std::string owner = parameter.of_connector() ? "" : parameter.owner;
    alike[{owner, kind_of(parameter), parameter.value}].push_back(parameter);
    if (!owner.empty()) alike[{"", kind_of(parameter), parameter.value}].push_back(parameter);
  }
  for (auto& [key, group] : alike) {
    const bool within = !std::get<0>(key).empty();
    std::set<std::string> owners;
    for (const auto& each : group) owners.insert(each.owner);
    if (group.size() > 1 && (within || owners.size() > 1)) candidates.push_back(group);
  }
  return candidates;
}

/// The problem and its parts with these parameters at `factor` times their values.
Correction with_parameters(const DiagnosisInput& given, const std::vector<Parameter>& parameters, double factor) {
  DiagnosisInput input = given;
  StructureModel structure = *given.problem->structure;
  for (const auto& parameter : parameters) {
    const double value = factor * parameter.value;
    set_parameter(structure.parts, parameter, value);
    if (set_parameter(input.parts, parameter, value)) continue;
    auto& before = input.of_elements;
    const auto same = std::ranges::find(before, parameter.name, [](const auto& each) { return each.first.name; });
    if (same == before.end())
      before.emplace_back(parameter, value);
    else
      same->second = value;
  }
  return about(std::move(input), std::move(structure));
}

Hypothesis wrong_parameter(const std::vector<Parameter>& parameters) {
  const Parameter& first = parameters.front();
  const std::string names = joined(parameters);
  return {.code = "fixed_parameter",
          .subject = names,
          .starts = {0.8, 1.25},
          .search = Search::factor,
          .step = 0.1,
          .fitted = 1,
          .correct = [parameters](const DiagnosisInput& given,
                                  double factor) { return with_parameters(given, parameters, factor); },
          .words =
              [names, first, several = parameters.size() > 1](double factor, const VectorXd&) {
                return fmt::format("the fixed parameter{} '{}' {} wrong: about {:.3g} {}, not {:.3g}",
                                   several ? "s" : "", names, several ? "are" : "is", factor * first.value, first.unit,
                                   first.value);
              },
          .remedy = "correct '" + names + "', or estimate it: add it to estimate.unknown"};
}

/// The same relative prior about another first guess. Where that is far off, a filter may end far off as well, as its
/// deviations shrink before the estimate has arrived.
Hypothesis wrong_first_guess(const Unknown& unknown, std::size_t i) {
  return {.code = "first_guess",
          .subject = unknown.name,
          .starts = {0.1, 0.3, 3.0, 10.0, 100.0},
          .search = Search::factor,
          .step = 0.7,
          .fitted = 1,
          .correct =
              [i](const DiagnosisInput& given, double factor) {
                auto changed = std::make_shared<EstimationProblem>(*given.problem);
                auto& moved = changed->settings.unknowns[i];
                moved.initial *= factor;
                moved.deviation *= factor;
                Correction made{given};
                made.input.problem = std::move(changed);
                return made;
              },
          .words =
              [unknown, i](double, const VectorXd& estimates) {
                return fmt::format(
                    "the first guess of '{}', {:.4g} {}, is too far off: the record asks for about "
                    "{:.3g}",
                    unknown.name, unknown.initial, unknown.unit(), estimates[static_cast<Index>(i)]);
              },
          .remedy =
              "begin near that value, or widen the prior; with `transform: log` a positive value is found over "
              "several powers of ten"};
}

/// Whether another first guess is possible. Between bounds the guess says little.
bool has_other_guesses(const Unknown& unknown) {
  return unknown.initial != 0.0 && unknown.transform.kind != TransformKind::logit;
}

/// Forces that make up most others together, as far as it takes to see which connector is in question: polynomials, one
/// that is even in the rate among them, and friction.
FurtherForces most_forces(const ConnectorDescription& connector, const ConnectorMotion& motion) {
  FurtherForces forces;
  const double d = motion.deformation, v = motion.rate, force = prior_of_law * motion.force;
  const auto polynomial = polynomial_law(3, 3);
  const auto friction = coulomb_law();
  const std::string name = connector.name + suffix, rubbing = connector.name + " (friction)";
  const auto unknown = [&](const std::string& owner, const ConnectorLaw& law, const std::string& parameter,
                           double deviation) {
    const auto& all = law.parameters();
    const auto at = std::ranges::find(all, parameter, &LawQuantity::name) - all.begin();
    forces.unknowns.push_back({.name = owner + "." + parameter,
                               .targets = {{owner + "." + parameter, owner, all[static_cast<std::size_t>(at)].unit, 0.0,
                                            ConnectorParameter{static_cast<Index>(at)}}},
                               .deviation = deviation});
  };
  forces.connectors.push_back({name, connector.from, connector.to, polynomial,
                               VectorXd::Zero(static_cast<Index>(polynomial->parameters().size()))});
  unknown(name, *polynomial, "k1", force / d);
  unknown(name, *polynomial, "k2", force / (d * d));
  unknown(name, *polynomial, "k3", force / (3.0 * d * d * d));
  unknown(name, *polynomial, "c1", force / v);
  unknown(name, *polynomial, "c2", force / (v * v));
  unknown(name, *polynomial, "c3", force / (3.0 * v * v * v));
  VectorXd of_friction = VectorXd::Zero(static_cast<Index>(friction->parameters().size()));
  for (std::size_t p = 0; p < friction->parameters().size(); ++p)
    if (friction->parameters()[p].name == "v_ref") of_friction[static_cast<Index>(p)] = 0.1 * v;
  forces.connectors.push_back({rubbing, connector.from, connector.to, friction, of_friction});
  unknown(rubbing, *friction, "f_c", force);
  return forces;
}

Hypothesis wrong_law(const DiagnosisInput& input, const ConnectorDescription& connector,
                     const ConnectorMotion& motion) {
  const std::size_t place = input.problem->settings.unknowns.size();
  return {.code = "wrong_law",
          .subject = connector.name,
          .fitted = 7,
          .correct = [connector, motion](const DiagnosisInput& given,
                                         double) { return with_forces(given, most_forces(connector, motion)); },
          .words =
              [connector, motion, place](double, const VectorXd& estimates) {
                const auto p = static_cast<Index>(place);
                const double d = motion.deformation, v = motion.rate;
                const std::vector<std::pair<double, const char*>> terms{
                    {std::abs(estimates[p]) * d, "linear in its deformation"},
                    {std::abs(estimates[p + 1]) * d * d, "quadratic in its deformation"},
                    {std::abs(estimates[p + 2]) * d * d * d, "cubic in its deformation"},
                    {std::abs(estimates[p + 3]) * v, "linear in its rate"},
                    {std::abs(estimates[p + 4]) * v * v, "quadratic in its rate"},
                    {std::abs(estimates[p + 5]) * v * v * v, "cubic in its rate"},
                    {std::abs(estimates[p + 6]), "of friction"}};
                const auto largest = std::ranges::max_element(terms);
                return fmt::format(
                    "connector '{}' does not follow its law '{}': the record asks for a further force, "
                    "mostly {} (about {:.0f} % of its force)",
                    connector.name, connector.law->name(), largest->second, 100.0 * largest->first / motion.force);
              },
          .remedy = "try another law for '" + connector.name + "', such as cubic, coulomb, bouc_wen or polynomial"};
}

/// The substructure with modes up to twice the highest one that it keeps.
Hypothesis missing_modes(const FiniteElementSubstructure& elements) {
  const auto& kept = elements.reduced->error_indicators.fixed_interface_frequencies;
  const double highest = kept.size() > 0 ? kept[kept.size() - 1] : 0.0;
  const std::string name = elements.part->name;
  return {.code = "missing_modes",
          .subject = name,
          .fitted = 2,
          .correct =
              [elements, name, highest](const DiagnosisInput& given, double) {
                ReductionRequest request = elements.reduction;
                request.modes = {};
                if (highest > 0.0)
                  request.modes.cutoff = 2.0 * highest;
                else
                  request.modes.count = 10;
                request.augmentation_vectors = true;
                auto finer = elements;
                finer.reduced = std::make_shared<const Superelement>(
                    reduce(*elements.part, request, std::numeric_limits<double>::infinity()));
                DiagnosisInput changed = given;
                StructureModel structure = *given.problem->structure;
                std::ranges::replace_if(
                    structure.finite_elements, [&](const auto& each) { return each.part->name == name; }, finer);
                structure.parts.finite_elements = structure.reduced_parts();
                changed.parts.finite_elements = structure.parts.finite_elements;
                return about(std::move(changed), std::move(structure));
              },
          .words =
              [name, highest](double, const auto&) {
                return fmt::format("the reduced model of '{}' misses modes above {:.4g} Hz that the record shows", name,
                                   highest);
              },
          .remedy = "raise reduction.up_to of '" + name + "', or low-pass the sensors below that frequency"};
}

}  // namespace

std::vector<Hypothesis> model_hypotheses(const DiagnosisInput& input, const std::vector<ConnectorMotion>& motion) {
  std::vector<Hypothesis> found;
  for (const auto& parameters : candidates_of(input)) found.push_back(wrong_parameter(parameters));
  const auto& unknowns = input.problem->settings.unknowns;
  for (std::size_t i = 0; i < unknowns.size() && i < most_parameters; ++i)
    if (has_other_guesses(unknowns[i])) found.push_back(wrong_first_guess(unknowns[i], i));
  const auto& connectors = input.parts.connectors;
  for (std::size_t j = 0; j < connectors.size() && j < motion.size(); ++j)
    if (motion[j].moves() && !contains(input.added, connectors[j].name))
      found.push_back(wrong_law(input, connectors[j], motion[j]));
  for (const auto& elements : input.problem->structure->finite_elements)
    if (elements.reduced) found.push_back(missing_modes(elements));
  return found;
}

}  // namespace kalfem
