// SPDX-License-Identifier: Apache-2.0
#include "kalfem/inference/output_sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "kalfem/identification/expected_record.hpp"
#include "kalfem/identification/filter_likelihood.hpp"
#include "kalfem/identification/named_unknowns.hpp"
#include "kalfem/system/linearised.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

using Output = SensitivityOptions::Output;

std::string unit_of(const Output& output) {
  switch (output.kind) {
    case SensitivityOutput::frequency:
      return "Hz";
    case SensitivityOutput::largest_force:
      return "N";
    case SensitivityOutput::mean_nis:
      break;
  }
  return "-";
}

/// All outputs at some parameters. What one output needs is made once.
class Outputs {
public:
  Outputs(const InferenceProblem& problem, const Record& record)
      : outputs_(problem.sensitivity->outputs),
        names_(names_of(problem)),
        unknowns_(problem.problem, names_, start_of(problem)),
        record_(record),
        force_problem_(with_force_sensors(*problem.problem)) {
    if (wants(SensitivityOutput::mean_nis))
      likelihood_.emplace(problem.problem, record, names_, FilterLikelihoodOptions{.first = start_of(problem)});
  }

  [[nodiscard]] VectorXd at(const VectorXd& theta) const try {
    VectorXd frequencies, forces;
    if (wants(SensitivityOutput::frequency)) frequencies = natural_frequencies(theta);
    if (wants(SensitivityOutput::largest_force)) forces = largest_forces(theta);
    VectorXd values(std::ssize(outputs_));
    Index force = 0;
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      double& value = values[static_cast<Index>(i)];
      if (outputs_[i].kind == SensitivityOutput::frequency) value = frequencies[outputs_[i].mode];
      if (outputs_[i].kind == SensitivityOutput::largest_force) value = forces[force++];
      if (outputs_[i].kind == SensitivityOutput::mean_nis) value = mean_nis(theta);
    }
    return values;
  } catch (const InvalidInput&) {
    return VectorXd::Constant(std::ssize(outputs_), unknown);
  }

private:
  [[nodiscard]] bool wants(SensitivityOutput kind) const {
    return std::ranges::any_of(outputs_, [&](const Output& output) { return output.kind == kind; });
  }

  /// The problem with a force sensor in place of its own for every force.
  [[nodiscard]] EstimationProblemPtr with_force_sensors(const EstimationProblem& given) const {
    auto problem = std::make_shared<EstimationProblem>(given);
    problem->sensors.clear();
    for (const auto& output : outputs_)
      if (output.kind == SensitivityOutput::largest_force)
        problem->sensors.push_back({.name = output.name,
                                    .output = {.name = output.name,
                                               .quantity = ObservedQuantity::connector_force,
                                               .points = {{output.connector, 1.0}}},
                                    .noise = 1.0,
                                    .unit = "N"});
    return problem;
  }

  [[nodiscard]] VectorXd natural_frequencies(const VectorXd& theta) const {
    const auto problem = unknowns_.problem_at(theta);
    Index count = 0;
    for (const auto& output : outputs_)
      if (output.kind == SensitivityOutput::frequency) count = std::max<Index>(count, output.mode + 1);
    return lowest_normal_modes(linearised_at_rest(couple(problem->structure->reference_parts())), {count}).frequencies;
  }

  [[nodiscard]] VectorXd largest_forces(const VectorXd& theta) const {
    const auto simulated = expected_record(force_problem_, record_, names_, theta);
    VectorXd forces = VectorXd::Constant(std::ssize(force_problem_->sensors), unknown);
    for (Index i = 0; simulated && i < forces.size(); ++i) {
      const auto& name = force_problem_->sensors[static_cast<std::size_t>(i)].name;
      forces[i] = simulated->values.row(simulated->find(name)).cwiseAbs().maxCoeff();
    }
    return forces;
  }

  [[nodiscard]] double mean_nis(const VectorXd& theta) const {
    const auto innovations = likelihood_->innovations(theta);
    if (!innovations) return unknown;
    const Index sensors = innovations->value.rows();
    double sum = 0.0, count = 0.0;
    for (Index k = 0; k < innovations->value.cols(); ++k) {
      const VectorXd value = innovations->value.col(k);
      if (!value.allFinite()) continue;
      MatrixXd covariance = MatrixXd::Zero(sensors, sensors);
      for (Index i = 0, entry = 0; i < sensors; ++i)
        for (Index j = 0; j <= i; ++j, ++entry) covariance(i, j) = innovations->covariance(entry, k);
      sum += value.dot(covariance.selfadjointView<Eigen::Lower>().llt().solve(value));
      count += 1.0;
    }
    return count > 0.0 ? sum / count : unknown;
  }

  std::vector<Output> outputs_;
  std::vector<std::string> names_;
  NamedUnknowns unknowns_;
  const Record& record_;
  EstimationProblemPtr force_problem_;
  std::optional<FilterLikelihood> likelihood_;
};

}  // namespace

std::vector<OutputSensitivity> output_sensitivity(const InferenceProblem& problem, const Record& record) {
  const auto& asked = *problem.sensitivity;
  const Outputs outputs(problem, record);
  const auto found = sobol_indices(problem.prior, [&](const VectorXd& theta) { return outputs.at(theta); },
                                   {.samples = asked.samples, .seed = problem.seed, .threads = problem.threads()});
  std::vector<OutputSensitivity> all;
  for (std::size_t i = 0; i < found.size(); ++i)
    all.push_back({asked.outputs[i].name, unit_of(asked.outputs[i]), found[i]});
  return all;
}

}  // namespace kalfem
