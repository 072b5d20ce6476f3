// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/record/record_report.hpp"
#include "kalfem/steps/run_step.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

// The record of a run, measured or simulated. It is there before the run, or comes from the simulation: nothing is
// computed here.

namespace kalfem {
namespace {

/// The record of a run, if it has one.
const Record* measured_of(const StudyResults& results) {
  if (const auto* estimation = results.find<EstimationOutcome>()) return &estimation->measurements;
  const auto* simulation = results.find<SimulationOutcome>();
  return simulation ? &simulation->measurements : nullptr;
}

void write_record(const Study& study, const StudyResults& results, SeriesWriter& file) {
  const Record* record = measured_of(results);
  if (!record) return;
  const auto* simulation = results.find<SimulationOutcome>();
  const Eigen::Index samples = simulation ? simulation->reference.simulation.trajectory.samples() : record->samples();
  file.write("/time",
             Eigen::VectorXd::LinSpaced(samples, record->start,
                                        record->start + static_cast<double>(samples - 1) / study.sample_rate()),
             "s");
  const Record& measurements = simulation ? simulation->measurements : *record;
  for (std::size_t i = 0; i < measurements.channels.size(); ++i)
    file.write("/measurements/" + measurements.channels[i].name,
               measurements.values.row(static_cast<Eigen::Index>(i)).transpose(), measurements.channels[i].unit);
}

std::string told(const Study& study, const StudyResults& results) {
  const std::string words = record_words(study, results);
  return words.empty() ? "" : words + "\n";
}

}  // namespace

RunStep record_step() {
  return {.name = "record",
          .ran = [](const StudyResults&) { return true; },
          .summarise =
              [](const Study& study, const StudyResults& results, nlohmann::ordered_json& summary) {
                if (study.record) summary["record"] = record_summary(study, results);
              },
          .tell = &told,
          .visit = &write_record};
}

}  // namespace kalfem
