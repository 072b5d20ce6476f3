// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/consistency.hpp"

#include <cmath>
#include <map>

#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

ConsistencySummary summarise_consistency(const Eigen::VectorXd& nis, const Eigen::VectorXi& measured,
                                         const Eigen::MatrixXd& innovation, const Eigen::VectorXd& noise_deviation,
                                         Eigen::Index first) {
  ConsistencySummary summary{0.0, 0.0, 0.0, Eigen::VectorXd::Zero(noise_deviation.size())};
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(noise_deviation.size());
  std::map<int, std::pair<double, double>> bands;
  double samples = 0.0;
  for (Eigen::Index k = first; k < nis.size(); ++k) {
    if (!std::isfinite(nis[k])) continue;
    const int channels = measured[k];
    const auto [band, added] = bands.try_emplace(channels);
    if (added) band->second = {chi_squared_quantile(0.025, channels), chi_squared_quantile(0.975, channels)};
    samples += 1.0;
    summary.mean_nis += nis[k];
    summary.expected_nis += channels;
    summary.fraction_in_95 += nis[k] >= band->second.first && nis[k] <= band->second.second ? 1.0 : 0.0;
    for (Eigen::Index i = 0; i < counts.size(); ++i)
      if (std::isfinite(innovation(i, k))) {
        counts[i] += 1.0;
        summary.innovation_to_noise[i] += innovation(i, k) * innovation(i, k);
      }
  }
  const double scale = 1.0 / samples;  // without samples nothing is computed: not a number, rather than zero
  summary.mean_nis *= scale;
  summary.expected_nis *= scale;
  summary.fraction_in_95 *= scale;
  summary.innovation_to_noise = (summary.innovation_to_noise.array() / counts.array()).sqrt() / noise_deviation.array();
  return summary;
}

}  // namespace kalfem
