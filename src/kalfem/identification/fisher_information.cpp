#include "kalfem/identification/fisher_information.hpp"

#include <cmath>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/named_unknowns.hpp"
#include "kalfem/identification/open_loop.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void check_size(Index count, const VectorXd& theta, const VectorXd& scale) {
  if (theta.size() != count || (scale.size() > 0 && scale.size() != count))
    throw InvalidInput(std::to_string(theta.size()) + " values and " + std::to_string(scale.size()) + " scales for " +
                           std::to_string(count) + " named unknowns",
                       "there must be one value each, and no scale or one each", "");
}

/// h of every parameter.
VectorXd steps(const FilterLikelihood& likelihood, const VectorXd& theta, const FisherInformationOptions& options) {
  const auto count = static_cast<Index>(likelihood.names().size());
  check_size(count, theta, options.scale);
  const VectorXd scale = options.scale.size() > 0 ? options.scale : theta.cwiseAbs().eval();
  IssueList issues;
  for (Index i = 0; i < count; ++i)
    if (const double step = options.relative_step * scale[i]; !(step > 0.0) || !std::isfinite(step))
      issues.add({}, "the step of '" + likelihood.names()[static_cast<std::size_t>(i)] + "' would be " + shortest(step),
                 "a difference needs a positive one", "give the parameter a scale");
  issues.raise();
  return options.relative_step * scale;
}

/// [v; S] of every sample, or a derivative of it.
struct Moments {
  MatrixXd value, covariance;
};

/// The passes of one difference each, beside each other, the pass at theta last. Empty where one fails.
std::optional<std::vector<Moments>> moments_and_derivatives(const FilterLikelihood& likelihood, const VectorXd& theta,
                                                            const VectorXd& step, int threads) {
  const auto count = static_cast<std::size_t>(theta.size());
  std::vector<std::optional<Moments>> all(count + 1);
  for_each_index(count + 1, threads, [&](std::size_t i) {
    const auto at = [&](double move) {
      VectorXd there = theta;
      if (i < count) there[static_cast<Index>(i)] += move * step[static_cast<Index>(i)];
      return likelihood.innovations(there);
    };
    const auto above = at(1.0);
    if (above && i == count) all[i] = {above->value, above->covariance};
    if (!above || i == count) return;
    const auto below = at(-1.0);
    if (!below) return;
    const double width = 2.0 * step[static_cast<Index>(i)];
    all[i] = {(above->value - below->value) / width, (above->covariance - below->covariance) / width};
  });
  std::vector<Moments> found;
  for (auto& each : all) {
    if (!each) return std::nullopt;
    found.push_back(std::move(*each));
  }
  return found;
}

/// The measured channels' part of S of one sample, from its rows.
MatrixXd covariance_of(const MatrixXd& rows, Index k, const std::vector<Index>& channels) {
  const auto l = static_cast<Index>(channels.size());
  MatrixXd covariance(l, l);
  for (Index i = 0; i < l; ++i)
    for (Index j = 0; j <= i; ++j) {
      const Index a = channels[static_cast<std::size_t>(i)], b = channels[static_cast<std::size_t>(j)];
      covariance(i, j) = covariance(j, i) = rows(a * (a + 1) / 2 + b, k);
    }
  return covariance;
}

/// Adds what a sample tells. With S = L L^T a column x_i = [vec(L^-1 dS_i L^-T) / sqrt(2); L^-1 dv_i] gives I_ij =
/// x_i^T x_j.
void add_sample(const std::vector<Moments>& moments, Index k, MatrixXd& information) {
  const auto& here = moments.back();
  std::vector<Index> channels;
  for (Index i = 0; i < here.value.rows(); ++i)
    if (std::isfinite(here.value(i, k))) channels.push_back(i);
  if (channels.empty()) return;
  const auto l = static_cast<Index>(channels.size());
  const Eigen::LLT<MatrixXd> factor(covariance_of(here.covariance, k, channels));
  MatrixXd columns(l * l + l, information.cols());
  for (Index i = 0; i < information.cols(); ++i) {
    const auto& slope = moments[static_cast<std::size_t>(i)];
    MatrixXd whitened = factor.matrixL().solve(covariance_of(slope.covariance, k, channels));
    whitened = factor.matrixL().solve(whitened.transpose().eval());
    columns.col(i).head(l * l) = whitened.reshaped() / std::sqrt(2.0);
    columns.col(i).tail(l) = factor.matrixL().solve(VectorXd(slope.value.col(k)(channels)));
  }
  information.noalias() += columns.transpose() * columns;
}

void check_excitation(const EstimationProblem& problem) {
  IssueList issues;
  const auto refuse = [&](const std::string& name, const SourceLocation& location) {
    issues.add(location, "the excitation '" + name + "' is unknown", "a record can be expected only under a known one",
               "state the excitation that is expected");
  };
  for (const auto& input : problem.settings.unknown_inputs) refuse(input.name, input.location);
  const auto& [parts, finite_elements, signals] = *problem.structure;
  for (std::size_t i = 0; i < signals.size(); ++i)
    if (!signals[i]) refuse(parts.inputs[i].name, parts.inputs[i].location);
  issues.raise();
}

/// The record with the sensors' channels from the simulation, new ones behind the others.
Record with_channels(Record record, const std::vector<Sensor>& sensors, const MatrixXd& simulated) {
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    Index row = record.find(sensors[i].name);
    if (row < 0) {
      row = record.values.rows();
      record.values.conservativeResize(row + 1, Eigen::NoChange);
      record.channels.push_back({sensors[i].name});
    }
    record.values.row(row) = simulated.row(static_cast<Index>(i));
    record.channels[static_cast<std::size_t>(row)].unit = sensors[i].unit;
  }
  return record;
}

/// The whole structure, whatever part of it the filter models.
EstimationProblemPtr whole(const EstimationProblemPtr& problem) {
  auto own = std::make_shared<EstimationProblem>(*problem);
  own->settings.local.reset();
  return own;
}

}  // namespace

std::optional<MatrixXd> fisher_information(const FilterLikelihood& likelihood, const VectorXd& theta,
                                           const FisherInformationOptions& options) {
  const VectorXd step = steps(likelihood, theta, options);
  const auto moments =
      moments_and_derivatives(likelihood, theta, step, options.threads > 0 ? options.threads : processors());
  if (!moments) return std::nullopt;
  MatrixXd information = MatrixXd::Zero(theta.size(), theta.size());
  for (Index k = 0; k < moments->back().value.cols(); ++k) add_sample(*moments, k, information);
  return information;
}

std::optional<Record> expected_record(const EstimationProblemPtr& problem, const Record& drive,
                                      const std::vector<std::string>& names, const VectorXd& theta) {
  check_excitation(*problem);
  const NamedUnknowns unknowns(whole(problem), names);
  check_size(static_cast<Index>(names.size()), theta, {});
  if (!unknowns.admissible(theta)) return std::nullopt;
  AugmentedModelSetup setup;
  try {
    const auto at = unknowns.problem_at(theta);
    IssueList issues;
    setup = make_augmented_model_setup(*at, at->structure->parts, {}, issues);
    issues.raise();
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
  const auto solution =
      simulate_open_loop({setup.model->system(), *setup.model, setup.sensors, problem->structure->signals},
                         setup.options.prior.mean, drive);
  if (solution.simulation.failure || !solution.sensors.allFinite()) return std::nullopt;
  Record record = with_channels(drive, setup.sensors, solution.sensors);
  for (const auto& sensor : setup.sensors) {
    const Index row = record.find(sensor.name);
    record.channels[static_cast<std::size_t>(row)].noise = sensor.deviation(rms(record.values.row(row).transpose()));
  }
  return unknowns.as_recorded(theta, std::move(record));
}

}  // namespace kalfem
