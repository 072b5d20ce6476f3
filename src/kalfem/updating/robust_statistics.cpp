// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/robust_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double chance = 0.01;           ///< that the scatter between parts is as large with independent parts
constexpr double least_share = 1e-8;      ///< of a score's variance that the fit leaves: less, and it tells nothing
constexpr double parzen_freedom = 3.709;  ///< degrees of freedom of a Parzen estimate: 3.709 N / S (Priestley 1981)

/// The linearised problem of the free parameters in parts of their scales.
struct FreeProblem {
  std::vector<Index> free;
  VectorXd scale;
  MatrixXd jacobian;
  MatrixXd prior;        ///< P
  MatrixXd information;  ///< H = J^T J + P

  FreeProblem(const std::vector<UpdatingParameter>& parameters, const MatrixXd& all,
              const ParameterStatistics& statistics) {
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (statistics.seen[i] != Seen::held) free.push_back(static_cast<Index>(i));
    scale.resize(std::ssize(free));
    VectorXd precision(scale.size());
    for (Index k = 0; k < scale.size(); ++k) {
      const auto& parameter = parameters[static_cast<std::size_t>(free[static_cast<std::size_t>(k)])];
      scale[k] = parameter.scale();
      precision[k] = scale[k] / parameter.deviation;
    }
    jacobian = all(Eigen::all, free) * scale.asDiagonal();
    prior = precision.cwiseAbs2().asDiagonal();
    information = jacobian.transpose() * jacobian + prior;
  }
};

/// Rows of each group, by its number.
std::vector<std::vector<Index>> rows_by(const std::vector<Index>& group, Index first) {
  std::vector<std::vector<Index>> rows;
  for (std::size_t i = 0; i < group.size(); ++i) {
    const auto number = static_cast<std::size_t>(group[i]);
    if (rows.size() <= number) rows.resize(number + 1);
    rows[number].push_back(first + static_cast<Index>(i));
  }
  std::erase_if(rows, [](const auto& each) { return each.empty(); });
  return rows;
}

/// J_g^T (I - J_g H^-1 J_g^T)^(-1/2) r_g, by the R of J_g = Q R: only the part of r_g in the range of J_g counts.
/// Directions in which the fit follows the group leave no residual and are left out.
VectorXd adjusted_score(const MatrixXd& jacobian, const VectorXd& values, const MatrixXd& inverse) {
  const Index count = jacobian.cols(), rows = std::min(count, jacobian.rows());
  const Eigen::HouseholderQR<MatrixXd> qr(jacobian);
  const MatrixXd R = qr.matrixQR().topRows(rows).triangularView<Eigen::Upper>();
  const VectorXd rotated = (qr.householderQ().adjoint() * values).head(rows);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> left(MatrixXd::Identity(rows, rows) - R * inverse * R.transpose());
  const VectorXd& share = left.eigenvalues();
  const VectorXd root = (share.array() > least_share).select(share.array().max(least_share).rsqrt(), 0.0);
  return R.transpose() * (left.eigenvectors() * (root.asDiagonal() * (left.eigenvectors().transpose() * rotated)));
}

/// B over groups of rows with CR2's adjustment.
class GroupedScores {
public:
  GroupedScores(const FreeProblem& problem, const VectorXd& values)
      : problem_(problem),
        values_(values),
        inverse_(sandwich(problem.information, problem.information).covariance),  // H^+ H H^+ = H^+
        of_sum(MatrixXd::Zero(problem.scale.size(), problem.scale.size())) {}

  void add(const std::vector<Index>& rows) {
    const VectorXd score = adjusted_score(problem_.jacobian(rows, Eigen::all), values_(rows), inverse_);
    of_sum += score * score.transpose();
    ++groups;
  }

private:
  const FreeProblem& problem_;
  const VectorXd& values_;
  MatrixXd inverse_;

public:
  MatrixXd of_sum;
  Index groups = 0;
};

/// Scores along the steps of a block, p x steps.
MatrixXd scores_of(const FreeProblem& problem, const VectorXd& values, const ResidualBlock& block) {
  const auto& step = block.layout.step;
  MatrixXd scores = MatrixXd::Zero(problem.scale.size(), step.empty() ? 0 : *std::ranges::max_element(step) + 1);
  for (std::size_t i = 0; i < step.size(); ++i) {
    const Index row = block.first + static_cast<Index>(i);
    scores.col(step[i]) += problem.jacobian.row(row).transpose() * values[row];
  }
  return scores;
}

std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i)
    text += (i == 0 ? "" : i + 1 == items.size() ? " and " : ", ") + items[i];
  return text;
}

/// Adds up the comparisons' covariances of scores, with what they were made from.
class Filling {
public:
  Filling(const FreeProblem& problem, const VectorXd& values)
      : problem_(problem), values_(values), unordered_(problem, values) {
    of_sum = MatrixXd::Zero(problem.scale.size(), problem.scale.size());
  }

  void add(const ResidualBlock& block) { block.layout.ordered ? add_ordered(block) : add_unordered(block); }

  /// Of all blocks.
  [[nodiscard]] MatrixXd sum() const { return of_sum + unordered_.of_sum; }
  [[nodiscard]] double pieces() const { return pieces_; }
  [[nodiscard]] double bandwidth() const { return bandwidth_; }

  [[nodiscard]] std::string method() const {
    std::vector<std::string> how;
    if (!ordered_.empty())
      how.push_back("the long-run covariance of the scores along " + listed(ordered_) +
                    " (Parzen kernel, Andrews' bandwidth; Driscoll and Kraay 1998)");
    if (!clusters_.empty())
      how.push_back("the scores of " + listed(clusters_) + " (CR2 for few of them, Bell and McCaffrey 2002)");
    return "sandwich of the information and " + listed(how);
  }

private:
  void add_ordered(const ResidualBlock& block) {
    const MatrixXd scores = scores_of(problem_, values_, block);
    const LongRunCovariance found = long_run_covariance(scores);
    of_sum += found.of_sum;
    bandwidth_ = std::max(bandwidth_, found.bandwidth);
    const auto steps = static_cast<double>(scores.cols());
    pieces_ += std::min(steps, parzen_freedom * steps / found.bandwidth);
    note(ordered_, block.layout.steps);
  }

  void add_unordered(const ResidualBlock& block) {
    for (const auto& rows : rows_by(block.layout.step, block.first)) {
      unordered_.add(rows);
      pieces_ += 1.0;
    }
    note(clusters_, block.layout.steps);
  }

  static void note(std::vector<std::string>& words, const std::string& word) {
    if (std::ranges::find(words, word) == words.end()) words.push_back(word);
  }

  const FreeProblem& problem_;
  const VectorXd& values_;
  GroupedScores unordered_;
  MatrixXd of_sum;
  double pieces_ = 0.0, bandwidth_ = 1.0;
  std::vector<std::string> ordered_, clusters_;
};

/// Sensors, inputs and whole comparisons as the groups. An unordered comparison is one group beside others.
GroupedScores scores_of_parts(const FreeProblem& problem, const VectorXd& values,
                              const std::vector<ResidualBlock>& blocks) {
  GroupedScores parts(problem, values);
  for (const auto& block : blocks) {
    const std::vector<Index> whole(static_cast<std::size_t>(block.size), 0);
    for (const auto& rows : rows_by(block.layout.part.empty() ? whole : block.layout.part, block.first))
      parts.add(rows);
  }
  return parts;
}

/// Widens the variances to those of the parts where chance does not explain the difference.
void widen_by_parts(const MatrixXd& of_parts, MatrixXd& covariance, RobustStatistics& robust) {
  const double freedom = static_cast<double>(robust.parts - 1);
  const double excess = chi_squared_quantile(1.0 - chance, freedom) / freedom;
  VectorXd widening = VectorXd::Ones(covariance.rows());
  for (Index i = 0; i < covariance.rows(); ++i) {
    if (!(covariance(i, i) > 0.0) || !(of_parts(i, i) > excess * covariance(i, i))) continue;
    widening[i] = std::sqrt(of_parts(i, i) / covariance(i, i));
    robust.parts_count = true;
  }
  covariance = widening.asDiagonal() * covariance * widening.asDiagonal();
}

}  // namespace

RobustStatistics robust_statistics(const std::vector<UpdatingParameter>& parameters, const ResidualValue& value,
                                   const std::vector<ResidualBlock>& blocks, const ParameterStatistics& statistics) {
  RobustStatistics robust;
  robust.deviations.setConstant(std::ssize(parameters), std::numeric_limits<double>::quiet_NaN());
  const FreeProblem problem(parameters, value.jacobian, statistics);
  const auto count = static_cast<double>(problem.free.size());
  if (problem.free.empty()) {
    robust.none = "no parameter is free";
    return robust;
  }
  Filling filling(problem, value.values);
  for (const auto& block : blocks) filling.add(block);
  robust.method = filling.method();
  robust.bandwidth = filling.bandwidth();
  robust.degrees_of_freedom = filling.pieces() - count;
  if (robust.degrees_of_freedom < 1.0) {
    robust.none =
        fmt::format("{:.0f} parameters leave too little scatter in {:.0f} independent values", count, filling.pieces());
    return robust;
  }
  const RobustCovariance sides = sandwich(problem.information, filling.sum());
  robust.rank = sides.rank;
  robust.condition = sides.condition;
  MatrixXd covariance = sides.covariance;
  const GroupedScores parts = scores_of_parts(problem, value.values, blocks);
  robust.parts = parts.groups;
  if (robust.parts > 1) widen_by_parts(sandwich(problem.information, parts.of_sum).covariance, covariance, robust);
  if (robust.parts_count)
    robust.method += fmt::format(
        "; for some parameters the larger scatter between {} sensors, inputs or comparisons "
        "(clusters, Cameron and Miller 2015)",
        robust.parts);
  covariance += sandwich(problem.information, problem.prior).covariance;
  for (Index k = 0; k < covariance.rows(); ++k) {
    const Index i = problem.free[static_cast<std::size_t>(k)];
    if (std::isfinite(statistics.deviations[i])) robust.deviations[i] = problem.scale[k] * std::sqrt(covariance(k, k));
  }
  return robust;
}

}  // namespace kalfem
