// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/diagnosis/diagnosis.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Lines of a case by its sections, each without its indent: "a7: {gain: -1}".
struct CaseEdit {
  std::vector<std::string> connectors = {}, sensors = {}, unknowns = {};

  [[nodiscard]] bool empty() const { return connectors.empty() && sensors.empty() && unknowns.empty(); }
  void add(const CaseEdit& other);
  /// As they stand in a case file.
  [[nodiscard]] std::string yaml() const;
};

/// The keys of the case that undo the mistake behind a run that contradicts itself: gain, offset, delay and drift of
/// channels, channels that are exchanged, a first guess, a force that a connector lacks. Empty where the mistake lies
/// outside of the case: a sensor that is cut off, the file of an excitation.
CaseEdit edit_against(const TestedHypothesis& cause, const Study& study, const EstimationOutcome& outcome);

}  // namespace kalfem
