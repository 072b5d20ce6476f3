// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/api/sensors.hpp"
#include "kalfem/estimation/consistency.hpp"
#include "kalfem/estimation/filter.hpp"
#include "kalfem/verdict/checks.hpp"

namespace kalfem {

/// The innovations of the latest samples of a filter, and whether they are what it expects of them.
class InnovationWindow {
public:
  /// `length`: samples that it holds, the latest ones.
  InnovationWindow(const std::vector<SensorDescription>& sensors, double sample_rate, Eigen::Index length);

  /// The innovation of a sample at a time [s]; the verdict is formed anew after each twentieth part of the window.
  void add(double time, const Innovation& innovation);

  /// Reasons of innovation_reasons() for the samples that it holds.
  [[nodiscard]] const Verdict& verdict() const { return verdict_; }
  [[nodiscard]] ConsistencySummary consistency() const;

private:
  /// Its samples in the order of time.
  [[nodiscard]] InnovationRecord record() const;

  InnovationRecord ring_;
  Eigen::Index count_ = 0;  ///< samples that were added
  double latest_ = 0.0;     ///< time of the latest sample [s]
  Verdict verdict_;
};

}  // namespace kalfem
