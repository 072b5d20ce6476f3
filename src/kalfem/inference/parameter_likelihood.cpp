// SPDX-License-Identifier: Apache-2.0
#include "kalfem/inference/parameter_likelihood.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "kalfem/identification/channel_simulation.hpp"
#include "kalfem/identification/correlated_error.hpp"
#include "kalfem/identification/filter_likelihood.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/fisher_information.hpp"
#include "kalfem/identification/likelihood_substeps.hpp"

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

ParameterLikelihood by_filter(const InferenceProblem& inference, const Record& record, const VectorXd& first) {
  const auto& problem = inference.problem;
  const auto names = names_of(inference);
  const int substeps = likelihood_substeps(problem, record, names, first);
  const FilterLikelihood likelihood(with_substeps(problem, substeps), record, names, {.first = first});
  const VectorXd scale = inference.prior.deviation();
  ParameterLikelihood made{
      names, [=](const VectorXd& theta) { return likelihood.log_likelihood(theta); },
      [=, threads = inference.threads()](const VectorXd& theta) {
        return fisher_information(likelihood, theta, {.scale = scale, .threads = threads});
      },
      fmt::format("the record of {} sensors by the filter, states and process noise integrated out",
                  record.channels.size()),
      work_of_pass(record.samples(), substeps, 2 * inference.setup.model->system().size() + 1)};
  const auto inputs = std::max<std::size_t>(1, inference.setup.input_sources.size());
  if (2.0 * substeps * static_cast<double>(record.samples()) * static_cast<double>(inputs) < most_input_values)
    made.finer = [finer = with_substeps(problem, 2 * substeps), record, names, first](const VectorXd& theta) {
      return FilterLikelihood(finer, record, names, {.first = first}).log_likelihood(theta);
    };
  return made;
}

std::string errors_in_words(double correlation_time) {
  return correlation_time > 0.0 ? fmt::format("correlated over {:.3g} s", correlation_time)
                                : std::string("independent from sample to sample");
}

/// The structure starts at rest; errors of each sensor have the size that fits best.
ParameterLikelihood by_simulation(const InferenceProblem& inference, const Record& record, const VectorXd& first) {
  const auto& problem = *inference.problem;
  IssueList issues;
  auto bindings = bindings_of_unknowns(problem, names_of(inference), issues);
  issues.raise();
  std::vector<std::string> sensors;
  for (const auto& sensor : problem.sensors) sensors.push_back(sensor.name);
  const auto simulation =
      std::make_shared<ChannelSimulation>(problem, record, problem.sensors, std::move(bindings), first);
  if (!simulation->start(problem.structure, first))
    throw InvalidInput(Issue{inference.location, "infer: the simulation fails at the first values of the parameters",
                             "the likelihood compares it with the record", "change the initial values"});
  const auto measured = std::make_shared<const Record>(select_channels(record, sensors));
  const CorrelatedError error{.correlation_time = inference.correlation_time};
  return {names_of(inference),
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
          "the record against its simulation from rest, errors " + errors_in_words(inference.correlation_time) +
              " and of the size that fits each sensor best",
          work_of_pass(record.samples(), 4, 2 * inference.setup.model->system().size() + 1)};
}

}  // namespace

long long search_likelihoods(const ParameterLikelihood& likelihood, int samples) {
  constexpr double fewest = 100.0;
  const double allowed = std::min(4.0 * samples, search_work / std::max(1.0, likelihood.work));
  return allowed < fewest ? 0 : static_cast<long long>(allowed);
}

ParameterLikelihood likelihood_of_record(const InferenceProblem& problem, const Record& record, const VectorXd& first) {
  return problem.likelihood == LikelihoodKind::filter ? by_filter(problem, record, first)
                                                      : by_simulation(problem, record, first);
}

}  // namespace kalfem
