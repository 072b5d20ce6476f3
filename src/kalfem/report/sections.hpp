// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/formats/deck.hpp"
#include "kalfem/model/checks/model_check.hpp"
#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/page.hpp"
#include "kalfem/study/finite_element_part.hpp"

namespace kalfem {

/// Health of a substructure: of its elements, or of matrices of another code, whose nodes have no places.
ModelCheckReport model_check_of(const FiniteElementPart& part, const ModelCheckOptions& options = {});

/// What was found, worst first: severity, fact, what follows, what to do.
Table findings_table(const ModelCheckReport& report);
/// Mass, centre of gravity, inertia, box, grounding, matrices.
Table properties_table(const ModelCheckReport& report);
/// Regions with what they are made of, how large and how heavy they are.
Table regions_table(const ModelCheckReport& report);
/// Materials with their values and what they resemble.
Table materials_table(const ModelCheckReport& report);
/// Shapes of the cells of each region: the worst value of each measure, and how many cells are beyond its limit.
Table quality_table(const ModelCheckReport& report);
/// The named nodes of a substructure: number, place, and how far it lies from the place that the case gives.
Table places_table(const FiniteElementPart& part);
/// The element under each strain gauge, and what it measures there.
Table gauges_table(const FiniteElementPart& part);
/// What a deck holds that was not used, what may change the model first.
Table notes_table(const std::vector<DeckNote>& notes);

/// As a person reads it on a terminal: findings and notes as sentences, then the tables.
std::string model_check_text(const ModelCheckReport& report, const std::vector<DeckNote>& notes);
/// All tables that have rows as a section of a page, below a picture of the mesh (where there is one).
Section model_check_section(const std::string& name, const FiniteElementModel& model, const ModelCheckReport& report,
                            const std::vector<DeckNote>& notes);

/// Force of every connector with an unknown parameter: over deformation at rest and over rate at zero deformation
/// (identified with its 95 % band, and true) where the law has no memory, and the path that it went.
Section connectors_section(const Study& study, const EstimationOutcome& outcome);

/// The filter's unknowns: table, course over time, correlation, and what the record does not determine.
Section parameters_section(const Study& study, const EstimationOutcome& outcome);

/// Motion at points without a sensor: estimate with its band, beside the simulation where there is one, and the error.
Section motion_section(const Study& study, const EstimationOutcome& outcome);

/// The linear substructure driven by its estimated boundary motion.
Section prediction_section(const Study& study, const EstimationOutcome& estimation, const PredictionOutcome& outcome);

/// Every sensor: measured beside what the filter expected, innovations with their band, and their autocorrelation.
Section sensors_section(const Study& study, const EstimationOutcome& outcome);

/// The updating on the page: parameters, what they rest on, the course of the search, measured and model responses.
Section updating_section(const Study& study, const StudyResults& results);

/// What was read, with its hashes, how it was prepared, which method and why, time, versions, and the resolved case.
Section provenance_section(const Study& study, const StudyResults& results);

/// The entries of a vector, as a series of a chart holds them.
inline std::vector<double> series_values(const Eigen::VectorXd& vector) { return {vector.begin(), vector.end()}; }

/// The times of a record's samples, as the abscissae of a chart.
std::vector<double> times(const Record& record);
/// A curve with the 95 % band of a normal distribution; without a deviation, the curve alone.
Series with_band(const std::string& label, const Eigen::VectorXd& mean, const Eigen::VectorXd& deviation, Role role);
/// The chart with its ordinates in the unit that people read, "displacement [mm]": that of its largest value.
/// `unit`: SI; `own`: the one that the user wrote, which then stays.
Chart with_readable_ordinates(Chart chart, const std::string& quantity, const std::string& unit,
                              const std::string& own = {});
/// The same of the abscissae.
Chart with_readable_abscissae(Chart chart, const std::string& quantity, const std::string& unit);

}  // namespace kalfem
