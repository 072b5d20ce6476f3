// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// Correlations of outputs with reference channels,
///     R_tau = 1/N sum_k y_{k+tau} r_k^T,    tau = 0 ... lags,
/// side by side [R_0 R_1 ...]: channels x references (lags + 1), and what each block of the record adds to them.
struct OutputCorrelations {
  Eigen::Index lags = 0;
  Eigen::Index block_length = 0;            ///< samples of r_k in a block
  Eigen::MatrixXd mean;                     ///< over all blocks
  std::vector<Eigen::MatrixXd> deviations;  ///< a block's correlations less the mean

  /// R_tau.
  [[nodiscard]] auto at(Eigen::Index lag) const { return lag_of(mean, lag); }
  /// Deviation of a block's R_tau.
  [[nodiscard]] auto deviation(std::size_t block, Eigen::Index lag) const { return lag_of(deviations[block], lag); }

private:
  [[nodiscard]] Eigen::Block<const Eigen::MatrixXd> lag_of(const Eigen::MatrixXd& all, Eigen::Index lag) const {
    const Eigen::Index references = all.cols() / (lags + 1);
    return all.block(0, lag * references, all.rows(), references);
  }
};

/// Of outputs without mean, channels x samples; `references` are rows of them. Blocks are equally long and follow each
/// other; y_{k+tau} may lie in the next one, so that nothing is lost at their ends. Up to `blocks` - 1 samples at the
/// end of the record are left out. `samples` > lags + blocks.
OutputCorrelations output_correlations(const Eigen::MatrixXd& outputs, const std::vector<Eigen::Index>& references,
                                       Eigen::Index lags, Eigen::Index blocks, int threads);

}  // namespace kalfem
