// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/study/study.hpp"

namespace kalfem {

/// A channel of the record beside what the model of the case, before any estimation, makes of the same excitation.
struct ChannelExpectation {
  double rms = 0.0;          ///< of the model's channel about its mean [SI]
  double ratio = 0.0;        ///< rms of the record / rms of the model
  double correlation = 0.0;  ///< of the two, -1 to 1
};

/// Each sensor's expectation, in their order, or why there is none.
struct RecordExpectation {
  std::vector<ChannelExpectation> channels = {};
  std::string reason = {};  ///< in words, where there are no channels
  double duration = 0.0;    ///< of the part that was simulated [s]
};

/// Simulates the structure as the case states it over its measured record, from rest, or over the first part of it
/// where the model is large. Nothing is estimated: signs, units and sizes show, not parameters.
RecordExpectation expectation_of_record(const Study& study);

}  // namespace kalfem
