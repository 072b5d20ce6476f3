// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/tables.hpp"

namespace kalfem {

/// The object "parameters" of summary.json.
nlohmann::ordered_json parameters_summary(const Study& study, const EstimationOutcome& outcome);

/// The object "inputs": inputs that the filter estimated. `settled`: samples from which on errors count.
nlohmann::ordered_json inputs_summary(const std::vector<EstimatedInput>& estimated, Eigen::Index settled);

/// The object "estimation", without what has a report of its own.
nlohmann::ordered_json estimation_summary(const EstimationOutcome& outcome);

/// The object "smoothed".
nlohmann::ordered_json smoothed_summary(const EstimationOutcome& outcome);

/// The list "events": what was wrong with the record or missing in it, and a change of an unknown, with their times.
nlohmann::ordered_json events_summary(const RecordEstimate& estimate);

/// The object "diagnosis": every mistake that was tested, best explanation first.
nlohmann::ordered_json diagnosis_summary(const Diagnosis& diagnosis);

/// Adds the errors of a point's estimate against its truth, where that is known.
void add_errors(nlohmann::ordered_json& errors, const PointQuantity& point, const RestingPoints& resting);

}  // namespace kalfem
