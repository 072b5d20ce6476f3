// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kalfem/live/live_state.hpp"

namespace kalfem {

/// The estimate of an earlier sample from all samples so far.
struct SmoothedEstimate {
  double time = 0.0;  ///< of that sample, the first one at 0 [s]
  std::vector<PresentParameter> parameters;
  /// By the names of the filter's own estimates: motions, strains, unknown inputs and the outputs that were asked for.
  std::vector<std::pair<std::string, PresentEstimate>> outputs;

  /// Look-up by name; throw InvalidInput if there is none.
  [[nodiscard]] const PresentParameter& parameter(const std::string& name) const;
  [[nodiscard]] const PresentEstimate& output(const std::string& name) const;
};

}  // namespace kalfem
