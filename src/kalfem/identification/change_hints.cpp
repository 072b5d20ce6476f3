// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/change_hints.hpp"

#include <algorithm>
#include <functional>

#include "kalfem/linalg/scaled_inverse.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double trimmed = 0.02;  ///< of an unknown's information at either end

}  // namespace

std::vector<ChangeHint> change_hints(const UnknownsHistory& history, Index first) {
  if (history.empty()) return {};
  const MatrixXd last = history.covariance_at(history.last()), prior = scaled_inverse(history.covariance_at(0));
  const VectorXd whole = (scaled_inverse(last) - prior).diagonal();
  const VectorXd estimate = history.mean.col(history.last()), start = prior * (history.mean.col(0) - estimate);
  std::vector<ChangeHint> hints;
  for (const Index unknown : history.unknowns) hints.push_back({.unknown = unknown});
  ScaledInverse inverse;
  MatrixXd gained;
  VectorXd score, variance;
  for (Index k = 1; k < history.last(); ++k) {
    const Index sample = k * history.stride;
    if (sample <= first) continue;
    const MatrixXd& information = inverse(history.covariance_at(k));
    gained = information - prior;
    score = information * (history.mean.col(k) - estimate) - start;
    variance = (gained - gained * last * gained).diagonal();
    for (std::size_t i = 0; i < hints.size(); ++i) {
      const auto row = static_cast<Index>(i);
      const double share = gained(row, row) / whole[row];
      if (!(share > trimmed && share < 1.0 - trimmed && variance[row] > 0.0)) continue;
      const double statistic = score[row] * score[row] / variance[row];
      if (statistic > hints[i].statistic) hints[i] = {hints[i].unknown, sample, statistic};
    }
  }
  std::ranges::sort(hints, std::greater{}, &ChangeHint::statistic);
  return hints;
}

}  // namespace kalfem
