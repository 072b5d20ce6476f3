// SPDX-License-Identifier: Apache-2.0
#include "kalfem/placement/expected_information.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::optional<CandidateMatrices> information_at(const PlacementProblem& problem, const VectorXd& values) {
  FisherInformationOptions options{
      .relative_step = 1e-4, .scale = values.cwiseAbs(), .threads = problem.options.threads};
  for (Index i = 0; i < values.size(); ++i)
    if (values[i] == 0.0) options.scale[i] = problem.prior.deviation()[i];
  return candidate_information(problem.problem, problem.drive, problem.candidates, problem.unknowns, values, options);
}

ExpectedInformation::ExpectedInformation(const PlacementProblem& problem, std::vector<CandidateMatrices> at_values)
    : counted_(static_cast<Index>(problem.counted)),
      prior_(problem.prior.deviation().cwiseAbs2().cwiseInverse()),
      at_values_(std::move(at_values)) {}

std::vector<MatrixXd> ExpectedInformation::of_all(const Set& set) const {
  std::vector<MatrixXd> sums;
  for (const auto& matrices : at_values_) {
    MatrixXd sum = MatrixXd::Zero(prior_.size(), prior_.size());
    for (const auto i : set) sum += matrices[i];
    sums.push_back(std::move(sum));
  }
  return sums;
}

std::vector<MatrixXd> ExpectedInformation::of_counted(const Set& set) const {
  const Index others = prior_.size() - counted_;
  std::vector<MatrixXd> information = of_all(set);
  if (others == 0) return information;
  for (auto& matrix : information) {
    const MatrixXd across = matrix.topRightCorner(counted_, others);
    MatrixXd own = matrix.bottomRightCorner(others, others);
    own.diagonal() += prior_.tail(others);
    const MatrixXd left = matrix.topLeftCorner(counted_, counted_) - across * own.ldlt().solve(across.transpose());
    matrix = 0.5 * (left + left.transpose());
  }
  return information;
}

VectorXd ExpectedInformation::deviation(const Set& set) const {
  VectorXd variance = VectorXd::Zero(counted_);
  for (MatrixXd& matrix : of_counted(set)) {
    matrix.diagonal() += prior_.head(counted_);
    variance += matrix.ldlt().solve(MatrixXd::Identity(counted_, counted_)).diagonal();
  }
  return (variance / static_cast<double>(at_values_.size())).cwiseMax(0.0).cwiseSqrt();
}

bool ExpectedInformation::moves(std::size_t candidate) const {
  return std::ranges::any_of(at_values_, [&](const auto& matrices) { return !matrices[candidate].isZero(0.0); });
}

}  // namespace kalfem
