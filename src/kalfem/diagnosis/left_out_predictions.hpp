// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "kalfem/diagnosis/clock_fit.hpp"
#include "kalfem/diagnosis/hypothesis.hpp"

namespace kalfem {

/// What a filter expects a sensor to show when it does not listen to it: the run is repeated with that sensor's noise a
/// thousand times as large, or its signal where this is larger, and starts as the other sensors ask for. Channels x
/// samples, not a number where nothing was measured; empty where the filter failed. With all sensors left out it is the
/// motion that the excitation alone gives. `run`: that of the input, or one with other excitations.
Eigen::MatrixXd predicted_without(const DiagnosisInput& input, const FilterRun& run, const EstimationOptions& options,
                                  const std::vector<Eigen::Index>& left_out);

/// How a channel follows its prediction, y(k) = gain prediction(k - lag).
struct Likeness {
  Eigen::Index lag = 0;      ///< of the largest correlation in size [samples]
  double correlation = 0.0;  ///< at that lag
  double gain = 0.0;         ///< least squares without lag
  double offset = 0.0;       ///< mean of y - prediction
  bool known = false;        ///< whether enough samples are there
  std::optional<ClockFit> clock = {};
};

/// Over pairs of samples that are both there, lags up to `most` on either side. Several rows share one lag and one
/// gain; each is weighed by the inverse of its size.
Likeness likeness(const Eigen::Ref<const Eigen::MatrixXd>& recorded, const Eigen::Ref<const Eigen::MatrixXd>& predicted,
                  Eigen::Index most);

}  // namespace kalfem
