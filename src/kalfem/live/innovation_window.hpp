// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/estimation/consistency.hpp"
#include "kalfem/estimation/filter.hpp"
#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/verdict/checks.hpp"

namespace kalfem {

/// The innovations of the latest samples of a filter, and whether they are what it expects of them.
class InnovationWindow {
public:
  /// `length`: samples that it holds, the latest ones.
  InnovationWindow(const std::vector<Sensor>& sensors, double sample_rate, Eigen::Index length);

  /// The innovation of a sample at a time [s]. Returns whether the reasons were formed anew, as they are after each
  /// twentieth part of the window.
  bool add(double time, const Innovation& innovation);

  /// Those of innovation_reasons() for the samples that it holds.
  [[nodiscard]] const std::vector<Reason>& reasons() const { return reasons_; }
  /// Whether it holds enough samples for reasons.
  [[nodiscard]] bool judges() const { return judges_; }
  [[nodiscard]] ConsistencySummary consistency() const;

  /// All that changes, to an archive or from it.
  static void transfer(auto& self, auto& archive) {
    archive(self.ring_.innovation);
    archive(self.ring_.deviation);
    archive(self.ring_.nis);
    archive(self.ring_.measured);
    archive(self.count_);
    archive(self.latest_);
    archive(self.judges_);
    archive.each(self.reasons_, [&](auto& reason) {
      archive(reason.code);
      archive(reason.subject);
      archive(reason.text);
      archive(reason.remedy);
      archive(reason.state);
      archive(reason.weight);
    });
  }

private:
  /// Its samples in the order of time.
  [[nodiscard]] InnovationRecord record() const;

  InnovationRecord ring_;
  Eigen::Index count_ = 0;  ///< samples that were added
  double latest_ = 0.0;     ///< time of the latest sample [s]
  bool judges_ = false;
  std::vector<Reason> reasons_;
};

}  // namespace kalfem
