// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/steps/modes/compute.hpp"
#include "kalfem/steps/run_step.hpp"
#include "kalfem/steps/updating/checkpoint.hpp"
#include "kalfem/steps/updating/compute.hpp"
#include "kalfem/steps/updating/report.hpp"
#include "kalfem/steps/updating/updated_decks.hpp"

namespace kalfem {
namespace {

/// Final estimates of the filter's unknowns before the updating.
Eigen::VectorXd unknowns_at_start(const Study& study, const StudyResults& results) {
  const auto before = estimate_record(study.problem, *study.augmented_model, record_of(study, results));
  return before.result.failure ? Eigen::VectorXd() : Eigen::VectorXd(before.result.unknowns.mean.rightCols(1));
}

/// The updated structure for what comes after, and the filter's model of it.
void hand_on(const Study& study, const UpdatingOutcome& outcome, RunContext& context) {
  context.updated = study.updating_plan->structure->at(outcome.values).parts;
  IssueList issues;
  context.augmented_model = make_augmented_model_setup(*study.problem, *context.updated,
                                                       present_values(*study.updating, outcome.values), issues);
  issues.raise();
}

void update(RunContext& context) {
  const Study& study = context.study;
  auto& results = context.results;
  auto& outcome = results.put(run_updating(study, results, context.options_of("update"), results.failure));
  if (!results.complete()) return;
  run_alternatives(study, results, outcome);
  results.put(updated_decks(study, outcome.values));
  if (context.takes("modes")) results.put(modes_at(study, outcome.values, study.report.modes));
  if (!study.augmented_model) return;
  outcome.unknowns_before = unknowns_at_start(study, results);
  hand_on(study, outcome, context);
}

nlohmann::ordered_json summary_of(const Study& study, const StudyResults& results) {
  auto summary = updating_summary(study, results.get<UpdatingOutcome>());
  if (const auto* decks = results.find<UpdatedDecks>(); decks && !decks->decks.empty())
    summary["decks"] = updated_decks_summary(*decks);
  return summary;
}

std::string told(const Study& study, const StudyResults& results) {
  std::string text = console_updating(study, results);
  if (const auto* decks = results.find<UpdatedDecks>())
    if (const auto words = updated_decks_words(*decks); !words.empty()) text += words + "\n";
  return text;
}

std::vector<PlacedSection> sections_of(const Study& study, const StudyResults& results) {
  Section section = updating_section(study, results);
  if (const auto* decks = results.find<UpdatedDecks>()) {
    if (const auto words = updated_decks_words(*decks); !words.empty()) section.text += "\n\n" + words;
    if (auto table = updated_decks_table(*decks); !table.rows.empty()) section.items.emplace_back(std::move(table));
  }
  return {{PagePlace::updating, std::move(section)}};
}

/// Every iteration: the residual, the parameters tried, the parameters accepted last. Then the compared responses.
void write_updating(SeriesWriter& file, const Study& study, const UpdatingOutcome& outcome) {
  const auto iterations = static_cast<Eigen::Index>(outcome.trace.size());
  const auto column = [&](const auto& value) {
    Eigen::VectorXd values(iterations);
    for (Eigen::Index k = 0; k < iterations; ++k) values[k] = value(outcome.trace[static_cast<std::size_t>(k)]);
    return values;
  };
  file.write_column("/updating/residual", column([](const auto& step) { return step.residual; }), "-");
  file.write_column("/updating/accepted", column([](const auto& step) { return step.accepted ? 1.0 : 0.0; }), "-");
  for (std::size_t i = 0; i < study.updating->parameters.size(); ++i) {
    const auto& parameter = study.updating->parameters[i];
    const auto index = static_cast<Eigen::Index>(i);
    const std::string name = "/updating/parameters/" + parameter.name;
    file.write_column(name, column([&](const auto& step) { return step.parameters[index]; }), parameter.unit);
    file.write_column(name + "_tried", column([&](const auto& step) { return step.tried[index]; }), parameter.unit);
  }
  for (const auto& comparison : outcome.comparisons)
    for (std::size_t i = 0; i < comparison.responses.size(); ++i) {
      const auto& curve = comparison.responses[i];
      const std::string group = "/updating/responses/" + comparison.name + "/" + std::to_string(i + 1);
      file.write_column(group + "/frequency", curve.lines, "Hz");
      for (const auto& [name, values] :
           {std::pair{"measured", &curve.measured}, {"before", &curve.before}, {"after", &curve.after}}) {
        file.write_column(group + "/" + name, values->cwiseAbs(), curve.unit);
        if (!curve.magnitudes_only) file.write_column(group + "/" + name + "_phase", values->cwiseArg(), "rad");
      }
      if (curve.coherence.size() > 0) file.write_column(group + "/coherence", curve.coherence, "-");
    }
}

}  // namespace

RunStep updating_step() {
  return {.name = "update",
          .meaning = "update the linear substructures from measurements, running the steps this needs",
          .asked_for = [](const Study& study) { return study.updating.has_value(); },
          .with = {"predict", "correlate"},
          .phases =
              [](const Study&) {
                return std::vector<PlannedStep>{{"update", 6.0}};
              },
          .run = &update,
          .checkpoint = {.file = checkpoint_name},
          .ran = &has_outcome<UpdatingOutcome>,
          .seconds = &seconds_of<UpdatingOutcome>,
          .summarise = [](const Study& study, const StudyResults& results,
                          nlohmann::ordered_json& summary) { summary["updating"] = summary_of(study, results); },
          .tell = &told,
          .answer = [](const Study&,
                       const StudyResults& results) { return updating_answer(results.get<UpdatingOutcome>()); },
          .sections = &sections_of,
          .visit = [](const Study& study, const StudyResults& results,
                      SeriesWriter& file) { write_updating(file, study, results.get<UpdatingOutcome>()); },
          .write =
              [](const std::filesystem::path& folder, const Study&, const StudyResults& results) {
                if (const auto* decks = results.find<UpdatedDecks>()) write_updated_decks(folder, *decks);
              }};
}

}  // namespace kalfem
