// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/output_correlations.hpp"

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/parallel.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

OutputCorrelations output_correlations(const MatrixXd& outputs, const std::vector<Index>& references, Index lags,
                                       Index blocks, int threads) {
  const Index channels = outputs.rows(), count = static_cast<Index>(references.size());
  OutputCorrelations found{
      .lags = lags, .block_length = (outputs.cols() - lags) / blocks, .mean = {}, .deviations = {}};
  found.deviations.resize(static_cast<std::size_t>(blocks));
  for_each_index(found.deviations.size(), threads, [&](std::size_t block) {
    stop_if_asked();
    const Index first = static_cast<Index>(block) * found.block_length;
    const MatrixXd reference = outputs.middleCols(first, found.block_length)(references, Eigen::all).transpose();
    auto& sums = found.deviations[block];
    sums.resize(channels, count * (lags + 1));
    for (Index lag = 0; lag <= lags; ++lag)
      sums.middleCols(lag * count, count).noalias() = outputs.middleCols(first + lag, found.block_length) * reference;
    sums /= static_cast<double>(found.block_length);
  });
  found.mean = MatrixXd::Zero(channels, count * (lags + 1));
  for (const auto& each : found.deviations) found.mean += each / static_cast<double>(blocks);
  for (auto& each : found.deviations) each -= found.mean;
  return found;
}

}  // namespace kalfem
