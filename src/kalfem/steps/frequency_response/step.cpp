// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>

#include "kalfem/steps/frequency_response/outcome.hpp"
#include "kalfem/steps/frequency_response/report.hpp"
#include "kalfem/steps/run_step.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

namespace kalfem {
namespace {

/// What cannot be computed is told at the case's frequencies.
FrequencyResponses responses_of(const FrequencyResponsePlan& plan, const Progress& progress) try {
  return frequency_responses(plan, progress);
} catch (const InvalidInput& error) {
  IssueList issues;
  issues.add(error, plan.lines_at);
  throw InvalidInput(issues.issues());
}

void respond(RunContext& context) {
  auto& results = context.results;
  const auto& outcome = results.put(results.phases.measure("frequency_response", [&] {
    return responses_of(*context.study.frequency_response, context.job.begin("frequency responses"));
  }));
  std::ranges::copy(outcome.warnings, std::back_inserter(results.warnings));
}

/// H by input, output and quantity: magnitude and phase of each model.
void write_frequency_response(SeriesWriter& file, const FrequencyResponseOutcome& outcome) {
  file.write_column("/frequency_response/frequency", outcome.frequencies, "Hz");
  for (const auto& response : outcome.responses)
    for (const auto& [name, values] : {std::pair{"full", &response.full}, {"reduced", &response.reduced}}) {
      const std::string path =
          "/frequency_response/" + response.input + "/" + response.output + "/" + response.quantity + "/" + name;
      file.write_column(path, values->cwiseAbs(), response.unit);
      file.write_column(path + "_phase", values->cwiseArg(), "rad");
    }
}

}  // namespace

RunStep frequency_response_step() {
  return {.name = "frf",
          .meaning = "frequency responses of the structure, linear about rest",
          .section = "frequency_response",
          .asked_for = [](const Study& study) { return study.frequency_response.has_value(); },
          .phases =
              [](const Study&) {
                return std::vector<PlannedStep>{{"frequency responses", 3.0}};
              },
          .run = &respond,
          .ran = &has_outcome<FrequencyResponseOutcome>,
          .summarise =
              [](const Study&, const StudyResults& results, nlohmann::ordered_json& summary) {
                summary["frequency_response"] = frequency_response_summary(results.get<FrequencyResponseOutcome>());
              },
          .tell =
              [](const Study&, const StudyResults& results) {
                return console_frequency_responses(results.get<FrequencyResponseOutcome>());
              },
          .answer =
              [](const Study&, const StudyResults& results) {
                return results.has<SimulationOutcome>()
                           ? ""
                           : frequency_response_answer(results.get<FrequencyResponseOutcome>());
              },
          .sections = [](const Study&, const StudyResults& results) -> std::vector<PlacedSection> {
            return {{PagePlace::linear_analyses, frequency_response_section(results.get<FrequencyResponseOutcome>())}};
          },
          .visit = [](const Study&, const StudyResults& results,
                      SeriesWriter& file) { write_frequency_response(file, results.get<FrequencyResponseOutcome>()); },
          .write =
              [](const std::filesystem::path& folder, const Study&, const StudyResults& results) {
                write_frequency_responses(folder, results.get<FrequencyResponseOutcome>());
              }};
}

}  // namespace kalfem
