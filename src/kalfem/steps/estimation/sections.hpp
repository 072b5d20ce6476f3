// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/held_out_sensors.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Force of every connector with an unknown parameter: over deformation at rest and over rate at zero deformation
/// (identified with its 95 % band, and true) where the law has no memory, and the path that it went.
Section connectors_section(const Study& study, const EstimationOutcome& outcome);
/// The force over time, with its 95 % band, of connectors with an unknown parameter and of those to the ground, and a
/// table of its smallest and largest value and rms; the preload between the same points is its static share.
void add_connector_forces(const Study& study, const EstimationOutcome& outcome, Section& section);

/// Of the connector with an unknown parameter that has the largest force, for the first screen.
struct LawOverview {
  std::optional<Chart> force = {};       ///< over velocity: points, and the law with its 95 % band
  std::optional<Listing> equation = {};  ///< with its numbers
};
LawOverview law_overview(const Study& study, const EstimationOutcome& outcome);

/// The filter's unknowns: table, course over time, correlation, and what the record does not determine.
Section parameters_section(const Study& study, const EstimationOutcome& outcome);

/// Motion at points without a sensor: estimate with its band, beside the simulation where there is one, and the error.
Section motion_section(const Study& study, const EstimationOutcome& outcome);
/// "NRMSE 0.31 % in the band of the excitation, 0.5 to 30 Hz; 59.9 % of the whole signal, after 2 s."
/// Empty where the truth of the point is not known.
std::string error_words(const EstimationOutcome& outcome, const std::vector<PointQuantity>& points,
                        const PointQuantity& point);

/// Every sensor: measured beside what the filter expected, innovations with their band, and their autocorrelation.
Section sensors_section(const Study& study, const EstimationOutcome& outcome);

/// Inputs that were not measured, as they were estimated.
Section inputs_section(const EstimationOutcome& outcome);
/// The normalised innovation squared over the record.
Section consistency_section(const EstimationOutcome& outcome);
/// The record simulated from the estimates.
Section open_loop_section(const EstimationOutcome& outcome);
/// What was wrong with the record or missing in it.
Section events_section(const std::vector<SensorEvent>& events);

/// The noise that a filter found over time, beside what was stated.
Section adaptive_noise_section(const RecordEstimate& estimate);
/// The estimates with other process noise.
Section process_noise_section(const RecordEstimate& estimate);
/// Numbers that were held fixed, and what they do to the estimates.
Section sensitivity_section(const RecordEstimate& estimate);
/// Fixed numbers that were tried as unknowns, and the estimates before and after.
Section freed_section(const FreedNumbers& freed);
/// Sensors predicted from the others as virtual ones.
Section held_out_section(const HeldOutStudy& study);
/// The laws of the case with their evidence.
Section alternatives_section(const Study& study, const EstimationOutcome& outcome);
/// Natural frequencies over the record: a table, and each over time with its 95 % band.
Section frequencies_section(const FrequencyCourse& course);

}  // namespace kalfem
