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
#include "kalfem/steps/updating/compute.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double impossible = -std::numeric_limits<double>::infinity();

CaseLikelihood by_filter(const Study& study, const Record& record, const VectorXd& first) {
  const auto& plan = *study.inference;
  const FilterLikelihood likelihood(study.problem, record, names_of(plan), {.first = first});
  const VectorXd scale = plan.prior.deviation();
  return {names_of(plan), [=](const VectorXd& theta) { return likelihood.log_likelihood(theta); },
          [=, threads = filter_threads(study.problem->settings)](const VectorXd& theta) {
            return fisher_information(likelihood, theta, {.scale = scale, .threads = threads});
          },
          fmt::format("the record of {} sensors by the filter, states and process noise integrated out",
                      record.channels.size())};
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
              " and of the size that fits each sensor best"};
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
          words};
}

}  // namespace kalfem
