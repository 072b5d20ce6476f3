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

/// The problem with one unknown more for each of `unknowns`, in the place after its own.
std::shared_ptr<EstimationProblem> released(const EstimationProblem& problem, std::vector<Unknown> unknowns) {
  auto changed = std::make_shared<EstimationProblem>(problem);
  for (auto& unknown : unknowns) changed->settings.unknowns.push_back(std::move(unknown));
  return changed;
}

/// Parameters that neither the filter nor an updating found, at a value other than zero.
std::vector<Parameter> fixed_parameters(const DiagnosisInput& input) {
  const EstimationProblem& problem = *input.problem;
  auto fixed =
      kalfem::fixed_parameters(*problem.structure, input.parts, estimated_parameters(problem.settings, input.updated));
  std::erase_if(fixed, [](const Parameter& parameter) { return parameter.value == 0.0; });
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
CorrectedRun with_parameters(const DiagnosisInput& input, const std::vector<Parameter>& parameters, double factor) {
  StructureParts parts = input.parts;
  std::vector<StructureBinding> of_elements;
  auto structure = std::make_shared<StructureModel>(*input.problem->structure);
  for (const auto& parameter : parameters) {
    const double value = factor * parameter.value;
    if (!set_parameter(parts, parameter, value))
      of_elements.push_back({static_cast<Index>(of_elements.size()), parameter});
    set_parameter(structure->parts, parameter, value);
  }
  if (!of_elements.empty()) {
    VectorXd values(static_cast<Index>(of_elements.size()));
    for (const auto& [index, parameter] : of_elements) values[index] = factor * parameter.value;
    parts.finite_elements =
        ParameterisedStructure(input.problem->structure, of_elements, values.size()).at(values).parts.finite_elements;
  }
  auto changed = std::make_shared<EstimationProblem>(*input.problem);
  changed->structure = std::move(structure);
  return {input.run_of(changed, parts), 0.0};
}

Hypothesis wrong_parameter(const DiagnosisInput& input, std::vector<Parameter> parameters) {
  const Parameter first = parameters.front();
  const std::string names = joined(parameters);
  return {.code = "fixed_parameter",
          .subject = names,
          .starts = {0.8, 1.25},
          .search = Search::factor,
          .step = 0.1,
          .fitted = 1,
          .correct = [&input, parameters](double factor) { return with_parameters(input, parameters, factor); },
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
Hypothesis wrong_first_guess(const DiagnosisInput& input, std::size_t i) {
  const Unknown& unknown = input.problem->settings.unknowns[i];
  return {.code = "first_guess",
          .subject = unknown.name,
          .starts = {0.1, 0.3, 3.0, 10.0, 100.0},
          .search = Search::factor,
          .step = 0.7,
          .fitted = 1,
          .correct =
              [&input, i](double factor) {
                auto changed = std::make_shared<EstimationProblem>(*input.problem);
                auto& moved = changed->settings.unknowns[i];
                moved.initial *= factor;
                moved.deviation *= factor;
                return CorrectedRun{input.run_of(changed, input.parts), 0.0};
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
struct FurtherTerms {
  StructureParts parts;
  std::vector<Unknown> unknowns;
};

FurtherTerms further_terms(const StructureParts& given, const ConnectorDescription& connector,
                           const ConnectorMotion& motion) {
  FurtherTerms terms{given, {}};
  const double d = motion.deformation, v = motion.rate, force = prior_of_law * motion.force;
  const auto polynomial = polynomial_law(3, 3);
  const auto friction = coulomb_law();
  const std::string name = connector.name + suffix, rubbing = connector.name + " (friction)";
  const auto unknown = [&](const std::string& owner, const ConnectorLaw& law, const std::string& parameter,
                           double deviation) {
    const auto& all = law.parameters();
    const auto at = std::ranges::find(all, parameter, &LawQuantity::name) - all.begin();
    terms.unknowns.push_back({.name = owner + "." + parameter,
                              .targets = {{owner + "." + parameter, owner, all[static_cast<std::size_t>(at)].unit, 0.0,
                                           ConnectorParameter{static_cast<Index>(at)}}},
                              .deviation = deviation});
  };
  terms.parts.connectors.push_back({name, connector.from, connector.to, polynomial,
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
  terms.parts.connectors.push_back({rubbing, connector.from, connector.to, friction, of_friction});
  unknown(rubbing, *friction, "f_c", force);
  return terms;
}

Hypothesis wrong_law(const DiagnosisInput& input, const ConnectorDescription& connector,
                     const ConnectorMotion& motion) {
  const std::size_t place = input.problem->settings.unknowns.size();
  return {.code = "wrong_law",
          .subject = connector.name,
          .fitted = 7,
          .correct =
              [&input, connector, motion](double) {
                auto terms = further_terms(input.parts, connector, motion);
                const auto changed = released(*input.problem, terms.unknowns);
                auto structure = std::make_shared<StructureModel>(*input.problem->structure);
                structure->parts.connectors = terms.parts.connectors;
                changed->structure = structure;
                return CorrectedRun{input.run_of(changed, terms.parts), 0.0};
              },
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
Hypothesis missing_modes(const DiagnosisInput& input, const FiniteElementSubstructure& elements) {
  const auto& kept = elements.reduced->error_indicators.fixed_interface_frequencies;
  const double highest = kept.size() > 0 ? kept[kept.size() - 1] : 0.0;
  const std::string name = elements.part->name;
  return {.code = "missing_modes",
          .subject = name,
          .fitted = 2,
          .correct =
              [&input, elements, name, highest](double) {
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
                auto structure = std::make_shared<StructureModel>(*input.problem->structure);
                std::ranges::replace_if(
                    structure->finite_elements, [&](const auto& each) { return each.part->name == name; }, finer);
                structure->parts.finite_elements = structure->reduced_parts();
                StructureParts parts = input.parts;
                parts.finite_elements = structure->parts.finite_elements;
                auto changed = std::make_shared<EstimationProblem>(*input.problem);
                changed->structure = structure;
                return CorrectedRun{input.run_of(changed, parts), 0.0};
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
  for (auto& parameters : candidates_of(input)) found.push_back(wrong_parameter(input, std::move(parameters)));
  const auto& unknowns = input.problem->settings.unknowns;
  for (std::size_t i = 0; i < unknowns.size() && i < most_parameters; ++i)
    if (has_other_guesses(unknowns[i])) found.push_back(wrong_first_guess(input, i));
  const auto& connectors = input.parts.connectors;
  for (std::size_t j = 0; j < connectors.size() && j < motion.size(); ++j)
    if (motion[j].moves()) found.push_back(wrong_law(input, connectors[j], motion[j]));
  for (const auto& elements : input.problem->structure->finite_elements)
    if (elements.reduced) found.push_back(missing_modes(input, elements));
  return found;
}

}  // namespace kalfem
