// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/comparisons_likelihood.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/steps/updating/compute.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double impossible = -std::numeric_limits<double>::infinity();

/// Assembly and modes of each model, and a solution for each number that is compared.
double work_of_comparisons(const Study& study, Index residuals) {
  Index dofs = study.model->system().size();
  for (const auto& elements : study.structure->finite_elements) dofs += elements.part->full.size();
  return 2e5 + (5e4 + 100.0 * static_cast<double>(residuals)) * static_cast<double>(dofs);
}

}  // namespace

ParameterLikelihood likelihood_of_comparisons(const Study& study, const StudyResults& results) {
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
