// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/case_likelihood.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "kalfem/identification/channel_simulation.hpp"
#include "kalfem/identification/correlated_error.hpp"
#include "kalfem/identification/filter_likelihood.hpp"
#include "kalfem/identification/fisher_information.hpp"
#include "kalfem/identification/likelihood_substeps.hpp"
#include "kalfem/steps/updating/compute.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double impossible = -std::numeric_limits<double>::infinity();

constexpr double search_work = 2.5e10;     ///< operations of all searches for further maxima
constexpr double most_input_values = 1e8;  ///< numbers of the inputs at all substeps of a record

/// A filter's step takes some ten operations for each entry of its covariance.
double work_of_pass(Index samples, int substeps, Index states) {
  return 10.0 * static_cast<double>(samples) * substeps * static_cast<double>(states * states);
}

/// The same problem with substeps that are given.
EstimationProblemPtr with_substeps(const EstimationProblemPtr& problem, int substeps) {
  auto own = std::make_shared<EstimationProblem>(*problem);
  own->settings.substeps = substeps;
  return own;
}

CaseLikelihood by_filter(const Study& study, const Record& record, const VectorXd& first) {
  const auto& plan = *study.inference;
  const auto names = names_of(plan);
  const int substeps = likelihood_substeps(study.problem, record, names, first);
  const FilterLikelihood likelihood(with_substeps(study.problem, substeps), record, names, {.first = first});
  const VectorXd scale = plan.prior.deviation();
  const auto& augmented = *study.augmented_model;
  CaseLikelihood made{names, [=](const VectorXd& theta) { return likelihood.log_likelihood(theta); },
                      [=, threads = filter_threads(study.problem->settings)](const VectorXd& theta) {
                        return fisher_information(likelihood, theta, {.scale = scale, .threads = threads});
                      },
                      fmt::format("the record of {} sensors by the filter, states and process noise integrated out",
                                  record.channels.size()),
                      work_of_pass(record.samples(), substeps, 2 * augmented.model->system().size() + 1)};
  const auto inputs = std::max<std::size_t>(1, augmented.input_sources.size());
  if (2.0 * substeps * static_cast<double>(record.samples()) * static_cast<double>(inputs) < most_input_values)
    made.finer = [problem = with_substeps(study.problem, 2 * substeps), record, names, first](const VectorXd& theta) {
      return FilterLikelihood(problem, record, names, {.first = first}).log_likelihood(theta);
    };
  return made;
}

std::string errors_in_words(double correlation_time) {
  return correlation_time > 0.0 ? fmt::format("correlated over {:.3g} s", correlation_time)
                                : std::string("independent from sample to sample");
}

/// The structure starts at rest; errors of each sensor have the size that fits best.
CaseLikelihood by_simulation(const Study& study, const Record& record, const VectorXd& first) {
  const auto& plan = *study.inference;
  IssueList issues;
  auto bindings = bindings_of_unknowns(*study.problem, names_of(plan), issues);
  issues.raise();
  std::vector<std::string> sensors;
  for (const auto& sensor : study.problem->sensors) sensors.push_back(sensor.name);
  const auto simulation =
      std::make_shared<ChannelSimulation>(*study.problem, record, study.problem->sensors, std::move(bindings), first);
  if (!simulation->start(study.structure, first))
    throw InvalidInput(Issue{plan.location, "infer: the simulation fails at the first values of the parameters",
                             "the likelihood compares it with the record", "change the initial values"});
  const auto measured = std::make_shared<const Record>(select_channels(record, sensors));
  const CorrelatedError error{.correlation_time = plan.correlation_time};
  return {names_of(plan),
          [=](const VectorXd& theta) {
            const auto outputs = simulation->outputs(theta);
            if (!outputs) return impossible;
            double sum = 0.0;
            for (Index j = 0; j < outputs->rows(); ++j)
              sum += log_density_of_correlated_series(
                  (measured->values.row(j).head(outputs->cols()) - outputs->row(j)).transpose(),
                  1.0 / measured->sample_rate, error);
            return sum;
          },
          [](const VectorXd&) { return std::optional<MatrixXd>(); },
          "the record against its simulation from rest, errors " + errors_in_words(plan.correlation_time) +
              " and of the size that fits each sensor best",
          work_of_pass(record.samples(), 4, 2 * study.model->system().size() + 1)};
}

/// Assembly and modes of each model, and a solution for each number that is compared.
double work_of_comparisons(const Study& study, Index residuals) {
  Index dofs = study.model->system().size();
  for (const auto& elements : study.structure->finite_elements) dofs += elements.part->full.size();
  return 2e5 + (5e4 + 100.0 * static_cast<double>(residuals)) * static_cast<double>(dofs);
}

}  // namespace

long long search_likelihoods(const CaseLikelihood& likelihood, int samples) {
  constexpr double fewest = 100.0;
  const double allowed = std::min(4.0 * samples, search_work / std::max(1.0, likelihood.work));
  return allowed < fewest ? 0 : static_cast<long long>(allowed);
}

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

CaseLikelihood likelihood_of_record(const Study& study, const Record& record, const VectorXd& first) {
  return study.inference->likelihood == LikelihoodKind::filter ? by_filter(study, record, first)
                                                               : by_simulation(study, record, first);
}

// ln N(r; 0, I) of the weighted residuals in their standard deviations.
CaseLikelihood likelihood_of_comparisons(const Study& study, const StudyResults& results) {
  const auto comparisons = all_comparisons(study, results);
  std::vector<ResidualSum::Term> terms;
  for (const auto& comparison : comparisons) terms.push_back({comparison.continuation_steps.back(), comparison.weight});
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
          words, work_of_comparisons(study, sum->size())};
}

}  // namespace kalfem
