// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/convergence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "kalfem/statistics/quantiles.hpp"

// Numbers of equations as in Vehtari et al. (2021).

namespace kalfem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The halves of every chain as chains of their own; the draw in the middle of an odd number is left out.
Eigen::MatrixXd split(const Eigen::Ref<const Eigen::MatrixXd>& draws) {
  const Eigen::Index half = draws.rows() / 2;
  Eigen::MatrixXd halves(half, 2 * draws.cols());
  halves << draws.topRows(half), draws.bottomRows(half);
  return halves;
}

Eigen::RowVectorXd variances(const Eigen::MatrixXd& chains) {
  const Eigen::MatrixXd centred = chains.rowwise() - Eigen::RowVectorXd(chains.colwise().mean());
  return centred.colwise().squaredNorm() / static_cast<double>(chains.rows() - 1);
}

/// Variance within chains W and the estimate var+ of the whole, equations 1 to 3.
struct Variances {
  double within = 0.0, whole = 0.0;

  explicit Variances(const Eigen::MatrixXd& chains) : within(variances(chains).mean()) {
    const auto draws = static_cast<double>(chains.rows());
    const double between = variances(chains.colwise().mean().transpose()).value();  // B / N
    whole = within * (draws - 1.0) / draws + between;
  }
};

/// Mean over chains of the autocovariance at a lag, divided by the number of draws.
double autocovariance(const Eigen::MatrixXd& centred, Eigen::Index lag) {
  const Eigen::Index pairs = centred.rows() - lag;
  return centred.topRows(pairs).cwiseProduct(centred.bottomRows(pairs)).sum() /
         static_cast<double>(centred.rows() * centred.cols());
}

double quantile(const Eigen::Ref<const Eigen::MatrixXd>& draws, double probability) {
  const auto values = draws.reshaped();
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const double place = probability * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

double quantile_size(const Eigen::Ref<const Eigen::MatrixXd>& draws, double probability) {
  return effective_sample_size((draws.array() <= quantile(draws, probability)).cast<double>().matrix());
}

}  // namespace

double split_r_hat(const Eigen::Ref<const Eigen::MatrixXd>& draws) {
  const Variances variances(split(draws));
  return variances.within > 0.0 ? std::sqrt(variances.whole / variances.within) : infinity;
}

double effective_sample_size(const Eigen::Ref<const Eigen::MatrixXd>& draws) {
  const Eigen::MatrixXd chains = split(draws);
  const Variances variances(chains);
  const auto total = static_cast<double>(chains.size());
  if (!(variances.whole > 0.0)) return 0.0;
  const Eigen::MatrixXd centred = chains.rowwise() - Eigen::RowVectorXd(chains.colwise().mean());
  const double bessel = static_cast<double>(chains.rows()) / static_cast<double>(chains.rows() - 1);
  const auto rho = [&](Eigen::Index lag) {  // equation 10
    return lag == 0 ? 1.0 : 1.0 - (variances.within - bessel * autocovariance(centred, lag)) / variances.whole;
  };
  double sum = 0.0, least = infinity;
  for (Eigen::Index lag = 0; lag + 1 < chains.rows(); lag += 2) {  // pairs are positive and fall (Geyer 1992)
    const double pair = rho(lag) + rho(lag + 1);
    if (pair < 0.0) break;
    least = std::min(least, pair);
    sum += least;
  }
  const double time = std::max(2.0 * sum - 1.0, 1.0 / std::log10(total));  // equation 11, bounded as Stan does
  return total / time;
}

Eigen::MatrixXd rank_normalised(const Eigen::Ref<const Eigen::MatrixXd>& draws) {
  const Eigen::VectorXd values = draws.reshaped();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return values[a] < values[b]; });
  Eigen::VectorXd scores(values.size());
  for (std::size_t first = 0; first < order.size();) {
    std::size_t last = first;
    while (last + 1 < order.size() && values[order[last + 1]] == values[order[first]]) ++last;
    const double rank = 1.0 + 0.5 * static_cast<double>(first + last);
    const double score = normal_quantile((rank - 0.375) / (static_cast<double>(order.size()) + 0.25));  // equation 14
    for (; first <= last; ++first) scores[order[first]] = score;
  }
  return scores.reshaped(draws.rows(), draws.cols());
}

Convergence convergence_of(const Eigen::Ref<const Eigen::MatrixXd>& draws) {
  const Eigen::MatrixXd scores = rank_normalised(draws);
  const Eigen::MatrixXd folded = (draws.array() - quantile(draws, 0.5)).abs();
  return {.r_hat = std::max(split_r_hat(scores), split_r_hat(rank_normalised(folded))),
          .bulk_ess = effective_sample_size(scores),
          .tail_ess = std::min(quantile_size(draws, 0.05), quantile_size(draws, 0.95))};
}

}  // namespace kalfem
