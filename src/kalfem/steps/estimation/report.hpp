// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "kalfem/identification/freed_numbers.hpp"
#include "kalfem/identification/frequency_course.hpp"
#include "kalfem/identification/held_out_sensors.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/result_series.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/verdict/verdict.hpp"

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

/// "Identified from 4 accelerations over 20 s: ...": the parameters and how well they are known.
std::string estimation_answer(const Study& study, const EstimationOutcome& outcome);

/// Parameters, consistency and errors as a person reads them on a terminal.
std::string console_estimation(const Study& study, const EstimationOutcome& outcome, const Verdict& verdict);
/// The parameters of the first answer, and that second thoughts follow.
std::string console_first_answer(const Study& study, const EstimationOutcome& outcome);

/// The series of results.h5: motions, unknowns, inputs, innovations, the record in open loop.
void write_estimate(SeriesWriter& file, const EstimationOutcome& outcome);

/// Unknowns with initial value, estimate, 95 % interval from the larger standard deviation and which one that is, both
/// standard deviations, truth and deviation from it.
Table parameter_table(const Study& study, const EstimationOutcome& outcome);
/// Excitations that were not measured: size, standard deviation and the error where the truth is known.
Table input_table(const EstimationOutcome& outcome);
/// Motions and forces that the sensors hardly show where inputs are unknown; empty if there are none.
std::string hardly_known_words(const EstimationOutcome& outcome);
/// Open-loop re-simulation against the record.
Table open_loop_table(const EstimationOutcome& outcome);

/// Into how many parts the filter's model divides a sample interval, and the bias that they leave in the estimates.
std::string substep_words(const EstimationOutcome& outcome);

/// The noise that a filter found along the record, for summary.json: of each sensor and of the process what was stated,
/// the last value and the range after settling. `estimate` has a course of its noise.
nlohmann::ordered_json adaptive_noise_summary(const RecordEstimate& estimate);
/// A line each for the terminal.
std::string adaptive_noise_words(const RecordEstimate& estimate);

/// What the estimates are with other process noise, for summary.json: an array of one object a factor.
nlohmann::ordered_json process_noise_summary(const RecordEstimate& estimate);
/// The same as a table: a row each unknown, a column each factor.
Table process_noise_table(const RecordEstimate& estimate);

/// The object "sensitivity": every number that was held fixed, what the record asks for, and d(estimate)/d(number).
nlohmann::ordered_json sensitivity_summary(const RecordEstimate& estimate);
/// The `most` numbers whose change by what is stated of them, or else by one per cent (a delay by a tenth of a sample
/// interval), moves a parameter furthest.
Table sensitivity_table(const RecordEstimate& estimate, std::size_t most);
/// "k: of +- 0.31 N, 0.09 are noise, 0.3 'm3'": a line each unknown; empty where nothing is stated of fixed numbers.
std::string considered_words(const RecordEstimate& estimate);

/// The object "freed": fixed numbers that the record asks to change, tried as unknowns, and what those kept move.
nlohmann::ordered_json freed_summary(const FreedNumbers& freed);
/// The same in sentences, a line each; empty where none was tried.
std::string freed_words(const FreedNumbers& freed);

/// The object "held_out": sensors predicted from the others as virtual ones, and the trial of adaptive process noise.
nlohmann::ordered_json held_out_summary(const HeldOutStudy& study);
/// The shares inside in a line; a table where a band does not hold.
std::string held_out_words(const HeldOutStudy& study);

/// The object "alternatives": every other law with its weight, evidence and parameters.
nlohmann::ordered_json alternatives_summary(const Study& study, const EstimationOutcome& outcome);
/// All laws, that of the case first.
Table alternatives_table(const Study& study, const EstimationOutcome& outcome);
/// A warning where another law is far more probable than that of the case; empty otherwise.
std::string unlikely_law_words(const Study& study, const EstimationOutcome& outcome);

/// Natural frequencies over the record for summary.json: each with its range and its last value.
nlohmann::ordered_json frequencies_summary(const FrequencyCourse& course);
/// The same as a table.
Table frequencies_table(const FrequencyCourse& course);

}  // namespace kalfem
