// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

namespace kalfem {

/// How late a channel is behind its prediction along the record,
///     y(k) = gain prediction(k - delay - drift k) + noise,
/// in samples and in samples per sample.
struct ClockFit {
  double delay = 0.0, drift = 0.0;
  double delay_deviation = 0.0, drift_deviation = 0.0;  ///< of white noise as large as what the fit leaves
};

/// Fits the clock that rows share: the cross-correlations of twelve parts of the record give the delay at either end to
/// a sample, within `most` of zero; Gauss-Newton on the prediction at these times does the rest. Rows are weighed by
/// the inverse of their size; a sample that is missing in either does not count. Nothing where a part is too short, or
/// prediction and channel have nothing in common.
std::optional<ClockFit> fit_clock(const Eigen::Ref<const Eigen::MatrixXd>& recorded,
                                  const Eigen::Ref<const Eigen::MatrixXd>& predicted, Eigen::Index most);

}  // namespace kalfem
