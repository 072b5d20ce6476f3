// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/diagnosis/diagnosis.hpp"
#include "kalfem/identification/frequency_course.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/steps/field_series.hpp"
#include "kalfem/steps/reported_quantities.hpp"

namespace kalfem {

/// The estimation with what a run reports of it. After a failure its series end with the last sample that was computed.
struct EstimationOutcome : RecordEstimate {
  /// Displacement, velocity, acceleration of points; deformation, rate, force of connectors; strain of gauges.
  std::vector<PointQuantity> points;
  std::vector<PointQuantity> smoothed_points;  ///< the same from the whole record, where the case asks for it
  /// With unknown inputs: motions and forces whose standard deviation is more than half of their size.
  std::vector<std::string> hardly_known;
  std::optional<FrequencyCourse> frequencies;  ///< over time, where the report asks for them
  std::optional<FrequencyBand> band;           ///< of the excitation, if it has one
  std::optional<Diagnosis> diagnosis;          ///< where the numbers contradict themselves: which mistake explains it
  double seconds = 0.0;
  double first_answer_seconds = 0.0;     ///< of these, until the first answer
  std::vector<FieldSeries> fields = {};  ///< for pictures, where the case asks for them
  /// With the other laws of the case, if it has such; `points` and `smoothed_points` are then the mixture of all.
  std::vector<std::shared_ptr<const EstimationOutcome>> alternatives = {};
  double log_evidence = 0.0, weight = 1.0;  ///< of this law among them
};

}  // namespace kalfem
