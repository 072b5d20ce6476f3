// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/records/spectrum.hpp"
#include "kalfem/records/windowed_transform.hpp"

namespace kalfem {

/// nrmse_in_band() of many pairs of signals of one length. One thread.
class ErrorInBand {
public:
  ErrorInBand(Eigen::Index samples, double sample_rate, const FrequencyBand& band)
      : transform_(samples, 4), sample_rate_(sample_rate), band_(band) {}

  double operator()(const Eigen::VectorXd& estimate, const Eigen::VectorXd& reference);

private:
  double power_of(const Eigen::VectorXd& signal);

  WindowedTransform transform_;
  double sample_rate_;
  FrequencyBand band_;
};

}  // namespace kalfem
