// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/fisher_information.hpp"

#include <cmath>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/identification/filter_run.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

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

}  // namespace

VectorXd difference_steps(const std::vector<std::string>& names, const VectorXd& theta,
                          const FisherInformationOptions& options, IssueList& issues) {
  const auto count = static_cast<Index>(names.size());
  if (count == 0 || theta.size() != count || (options.scale.size() > 0 && options.scale.size() != count)) {
    issues.add({},
               std::to_string(theta.size()) + " values and " + std::to_string(options.scale.size()) + " scales for " +
                   std::to_string(count) + " unknowns",
               "every unknown needs its value", "give one value each, and no scales or one each");
    return {};
  }
  const VectorXd scale = options.scale.size() > 0 ? options.scale : theta.cwiseAbs().eval();
  for (Index i = 0; i < count; ++i)
    if (const double step = options.relative_step * scale[i];
        !(step > 0.0) || !std::isfinite(step) || !std::isfinite(theta[i]))
      issues.add({},
                 "the unknown '" + names[static_cast<std::size_t>(i)] + "' has the value " + shortest(theta[i]) +
                     " and the scale " + shortest(scale[i]),
                 "differences are taken over a part of its scale", "give it a finite value and a positive scale");
  return options.relative_step * scale;
}

std::optional<MatrixXd> fisher_information(const FilterLikelihood& likelihood, const VectorXd& theta,
                                           const FisherInformationOptions& options) {
  IssueList issues;
  const VectorXd step = difference_steps(likelihood.names(), theta, options, issues);
  issues.raise();
  const auto moments =
      moments_and_derivatives(likelihood, theta, step, options.threads > 0 ? options.threads : processors());
  if (!moments) return std::nullopt;
  MatrixXd information = MatrixXd::Zero(theta.size(), theta.size());
  for (Index k = 0; k < moments->back().value.cols(); ++k) add_sample(*moments, k, information);
  return information;
}

}  // namespace kalfem
