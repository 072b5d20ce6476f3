#include "kalfem/updating/parameter_findings.hpp"

#include <fmt/format.h>

#include <cmath>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Parameters = std::vector<UpdatingParameter>;

constexpr double notable_inflation = 1.5;  // of variances: below it, mere chance or not worth a word

const UpdatingParameter& at(const Parameters& parameters, Index i) { return parameters[static_cast<std::size_t>(i)]; }

/// "a", "a and b", "a, b and c"
std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i)
    text += (i == 0 ? "" : i + 1 == items.size() ? " and " : ", ") + items[i];
  return text;
}

/// "rails.E by +10 %", or in units where a percentage has no meaning.
std::string change_in_words(const UpdatingParameter& p, double parts) {
  if (p.initial != 0.0) return fmt::format("{} by {:+.2g} %", p.name, 100.0 * parts);
  return fmt::format("{} by {:+.2g} {}", p.name, parts * p.scale(), p.unit);
}

std::string unidentifiable_in_words(const UnidentifiableCombination& combination, const Parameters& parameters) {
  constexpr double shown = 0.1;  // size of the greatest change in the sentence
  std::vector<std::string> names, changes;
  for (std::size_t k = 0; k < combination.parameters.size(); ++k) {
    const auto& parameter = at(parameters, combination.parameters[k]);
    names.push_back(parameter.name);
    changes.push_back(change_in_words(parameter, shown * combination.changes[k]));
  }
  return fmt::format(
      "{} cannot be told apart: to change {} at the same time hardly changes the residual; hold one of them, give it a "
      "narrow prior, or compare with measurements that tell them apart",
      listed(names), listed(changes));
}

bool is_unidentifiable(const ParameterStatistics& statistics, Index i) {
  for (const auto& combination : statistics.unidentifiable)
    for (const Index member : combination.parameters)
      if (member == i) return true;
  return false;
}

std::string poorly_in_words(const UpdatingParameter& p, const ParameterStatistics& statistics, Index i) {
  if (std::isfinite(p.deviation))
    return fmt::format(
        "{} is hardly informed by the residual: its deviation is {:.0f} % of that of its prior, so its value is mostly "
        "the prior's",
        p.name, 100.0 * statistics.to_prior[i]);
  return fmt::format("{} is hardly informed by the residual: its deviation is {:.2g} {}", p.name,
                     statistics.deviations[i], p.unit);
}

std::string bound_in_words(const UpdatingParameter& p, double value) {
  return fmt::format(
      "{} ended at its {} bound, {:g} {}: beyond it the residual would be smaller, and its deviation does not know of "
      "the bound",
      p.name, value == p.lower ? "lower" : "upper", value, p.unit);
}

}  // namespace

std::vector<std::string> parameter_findings(const Parameters& parameters, const Eigen::VectorXd& values,
                                            const ParameterStatistics& statistics) {
  std::vector<std::string> findings;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto index = static_cast<Index>(i);
    if (statistics.seen[i] == Seen::not_at_all)
      findings.push_back(parameters[i].name + " is not informed by the residual at all: it stays where it was");
    if (statistics.seen[i] == Seen::poorly && !is_unidentifiable(statistics, index))
      findings.push_back(poorly_in_words(parameters[i], statistics, index));
    if (statistics.at_bound[i]) findings.push_back(bound_in_words(parameters[i], values[index]));
  }
  for (const auto& combination : statistics.unidentifiable)
    findings.push_back(unidentifiable_in_words(combination, parameters));
  for (const auto& [first, second, correlation] : statistics.correlated)
    findings.push_back(fmt::format("{} and {} are correlated by {:.4f}: errors of one are made up for by the other",
                                   at(parameters, first).name, at(parameters, second).name, correlation));
  if (statistics.variance_inflation > notable_inflation)
    findings.push_back(fmt::format(
        "residuals are {:.2g} times as large as their stated deviations: the parameters' deviations are widened for it",
        std::sqrt(statistics.variance_inflation)));
  return findings;
}

std::vector<std::string> without_effect(const Parameters& parameters, const Eigen::MatrixXd& jacobian) {
  constexpr double rounding = 1e-10;  // of the largest column
  std::vector<std::string> names;
  Eigen::VectorXd effects = jacobian.colwise().norm();
  for (std::size_t i = 0; i < parameters.size(); ++i) effects[static_cast<Index>(i)] *= parameters[i].scale();
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].lower < parameters[i].upper && effects[static_cast<Index>(i)] <= rounding * effects.maxCoeff())
      names.push_back(parameters[i].name);
  return names;
}

}  // namespace kalfem
