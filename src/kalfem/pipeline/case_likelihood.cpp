#include "kalfem/pipeline/case_likelihood.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "kalfem/identification/filter_likelihood.hpp"
#include "kalfem/identification/fisher_information.hpp"
#include "kalfem/identification/simulation_likelihood.hpp"
#include "kalfem/identification/simulation_residual.hpp"
#include "kalfem/pipeline/run_updating.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double impossible = -std::numeric_limits<double>::infinity();

CaseLikelihood by_filter(const Study& study, const Record& record) {
  const auto& plan = *study.inference;
  const FilterLikelihood likelihood(study.problem, record, names_of(plan), {.first = start_of(plan)});
  const VectorXd scale = plan.prior.deviation();
  return {names_of(plan), [=](const VectorXd& theta) { return likelihood.log_likelihood(theta); },
          [=, threads = filter_threads(study.problem->settings)](const VectorXd& theta) {
            return fisher_information(likelihood, theta, {.scale = scale, .threads = threads});
          },
          fmt::format("the record of {} sensors by the filter, states and process noise integrated out",
                      record.channels.size())};
}

/// The plan's parameters as those of a simulation that is compared with the record.
struct SimulatedParameters {
  std::vector<UpdatingParameter> parameters;
  std::vector<StructureBinding> bindings;
};

SimulatedParameters simulated_parameters(const Study& study) {
  const auto& plan = *study.inference;
  SimulatedParameters simulated;
  IssueList issues;
  for (std::size_t i = 0; i < plan.parameters.size(); ++i) {
    const auto& [name, unit, start, truth] = plan.parameters[i];
    const auto [lower, upper] = support(plan.prior.marginals()[i].second);
    simulated.parameters.push_back({name, unit, start, lower, upper});
    const auto& unknowns = study.problem->settings.unknowns;
    const auto unknown = std::ranges::find(unknowns, name, &Unknown::name);
    if (unknown == unknowns.end())
      issues.add(plan.location, "infer: '" + name + "' is no parameter of the structure",
                 "a simulation knows no gains, delays and noise of sensors", "use likelihood: filter");
    else
      for (const auto& target : unknown->targets) simulated.bindings.push_back({static_cast<Index>(i), target});
  }
  issues.raise();
  return simulated;
}

CaseLikelihood by_simulation(const Study& study, const Record& record) {
  const auto& plan = *study.inference;
  const auto [parameters, bindings] = simulated_parameters(study);
  const auto structure = std::make_shared<const ParameterisedStructure>(study.structure, bindings, std::ssize(parameters));
  const auto residual = std::make_shared<SimulationResidual>(
      study.structure, study.sensors, record, structure, parameters,
      SimulationResidual::Options{.name = "record", .initial = study.simulation ? study.simulation->initial : InitialMotion{}});
  const std::vector<CorrelatedError> errors(study.sensors.size(), {.correlation_time = plan.correlation_time});
  const SimulationLikelihood likelihood(residual, errors, 1.0 / record.sample_rate);
  const std::string kind = plan.correlation_time > 0.0
                               ? fmt::format("correlated over {:.3g} s", plan.correlation_time)
                               : std::string("independent from sample to sample");
  return {names_of(plan), [=](const VectorXd& theta) { return likelihood.log_likelihood(theta); },
          [](const VectorXd&) { return std::optional<MatrixXd>(); },
          "the record against its simulation, errors " + kind + " and of the size that fits each sensor best"};
}

/// ln N(r; 0, I) of the weighted residuals in their standard deviations.
CaseLikelihood by_comparisons(const Study& study, const StudyResults& results) {
  const auto comparisons = all_comparisons(study, results);
  std::vector<ResidualSum::Term> terms;
  for (const auto& comparison : comparisons)
    terms.push_back({comparison.continuation_steps.back(), comparison.weight});
  const auto sum = std::make_shared<const ResidualSum>(std::move(terms));
  const double normalisation = 0.5 * static_cast<double>(sum->size()) * std::log(2.0 * std::numbers::pi);
  std::string words = "the comparisons of `update`: ";
  for (std::size_t i = 0; i < comparisons.size(); ++i) words += (i == 0 ? "" : ", ") + comparisons[i].kind;
  return {names_of(*study.inference),
          [=](const VectorXd& theta) {
            const auto value = sum->evaluate(theta, false);
            return value ? -0.5 * value->values.squaredNorm() - normalisation : impossible;
          },
          [=](const VectorXd& theta) -> std::optional<MatrixXd> {
            const auto value = sum->evaluate(theta, true);
            if (!value) return std::nullopt;
            return MatrixXd(value->jacobian.transpose() * value->jacobian);
          },
          words};
}

}  // namespace

std::vector<std::string> names_of(const InferencePlan& plan) {
  std::vector<std::string> names;
  for (const auto& parameter : plan.parameters) names.push_back(parameter.name);
  return names;
}

VectorXd start_of(const InferencePlan& plan) {
  VectorXd start(std::ssize(plan.parameters));
  for (std::size_t i = 0; i < plan.parameters.size(); ++i) start[static_cast<Index>(i)] = plan.parameters[i].start;
  return start;
}

CaseLikelihood likelihood_of(const Study& study, const Record& record) {
  return study.inference->likelihood == LikelihoodKind::filter ? by_filter(study, record) : by_simulation(study, record);
}

CaseLikelihood likelihood_of(const Study& study, const StudyResults& results) {
  if (study.inference->likelihood == LikelihoodKind::comparisons) return by_comparisons(study, results);
  return likelihood_of(study, record_of(study, results));
}

}  // namespace kalfem
