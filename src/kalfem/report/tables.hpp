// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// Unknowns with initial value, estimate, 95 % interval from the larger standard deviation and which one that is, both
/// standard deviations, truth and deviation from it.
Table parameter_table(const Study& study, const EstimationOutcome& outcome);
/// Excitations that were not measured: size, standard deviation and the error where the truth is known.
Table input_table(const EstimationOutcome& outcome);
/// Motions and forces that the sensors hardly show where inputs are unknown; empty if there are none.
std::string hardly_known_words(const EstimationOutcome& outcome);
/// Everything of lumped parts and connectors; of finite elements the points and gauges that the case wants shown, if it
/// names some.
bool shown(const Study& study, const PointQuantity& quantity);
/// NRMSE of a step's points against the reference after the sample `settled`; "at rest" for points that do not move.
/// Of finite-element substructures only the points that the case wants shown, where it names some.
Table error_table(const std::string& title, const Study& study, const std::vector<PointQuantity>& points,
                  Eigen::Index settled);
/// Open-loop errors on the validation part, beside those on the part that is estimated from, and the noise.
Table validation_table(const ValidationOutcome& outcome);
/// "Validation: 2 s to 4 s of record.csv".
std::string validation_part_words(const ValidationPlan& plan);
/// The same, with how the simulation starts, or why there is none.
std::string validation_words(const Study& study, const ValidationOutcome& outcome);
/// Open-loop re-simulation against the record.
Table open_loop_table(const EstimationOutcome& outcome);

/// Into how many parts the filter's model divides a sample interval, and the bias that they leave in the estimates.
std::string substep_words(const EstimationOutcome& outcome);

/// Parameters, consistency and errors as a person reads them on a terminal.
std::string console_report(const Study& study, const StudyResults& results);

/// The parameters of the first answer, and that second thoughts follow.
std::string console_first_answer(const Study& study, const StudyResults& results);

/// Mass of a substructure with its unit, and the part that is free to move where some of it is held:
/// "15.7 kg (11.8 kg of it free to move)".
std::string mass_text(const FiniteElementPart& part);

/// A table as text with aligned columns.
std::string to_text(const Table& table);

/// "12 times faster than real time": of a filter, by the time of the record over that of its computation.
std::string speed_in_words(double ratio);

/// Four significant digits.
std::string four_digits(double value);
/// "1 connector", "4 connectors".
std::string counted(Eigen::Index count, const std::string& noun);
/// Without columns, other than the first, of which every row has only a dash.
Table without_empty_columns(Table table);
/// A ratio with two decimals, "-" where it is not finite.
std::string per_cent(double ratio);

/// Tells points that move from those that do not: the rms of their reference is below a millionth (120 dB) of the
/// largest of its kind (displacements, forces, ...), which is rounding of the mesh and of the solution. An error
/// relative to it says nothing.
class RestingPoints {
public:
  /// `settled`: first sample that counts, as for the errors.
  RestingPoints(const std::vector<PointQuantity>& points, Eigen::Index settled);
  [[nodiscard]] bool rests(const PointQuantity& point) const;

private:
  [[nodiscard]] double moved(const PointQuantity& point) const;

  Eigen::Index settled_;
  std::map<ObservedQuantity, double> largest_;
};

}  // namespace kalfem
