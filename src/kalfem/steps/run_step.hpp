// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/steps/result_series.hpp"
#include "kalfem/steps/run_study.hpp"

namespace kalfem {

struct RunStep;

/// A run on its way, as its steps see it: what it is of, what it has found, and what steps hand to later ones.
struct RunContext {
  Study& study;  ///< as given; with `estimate.free: auto` its estimation may add unknowns
  const RunOptions& options;
  StudyResults& results;
  JobProgress& job;
  std::vector<const RunStep*> taken;                   ///< the steps that the run takes
  std::optional<AugmentedModelSetup> augmented_model;  ///< of the filter: the case's, then as steps have changed it
  std::optional<StructureParts> updated;               ///< the structure after an updating that a filter follows

  [[nodiscard]] bool takes(std::string_view step) const;
  /// The run's options with the progress of one step.
  [[nodiscard]] RunOptions options_of(const std::string& step) const;
};

/// Where a section stands on the page, from top to bottom. Sections of one place follow the order of the steps.
enum class PagePlace {
  measured,  ///< sensors of a measured record: what was measured is what people know
  parameters,
  updating,
  events,
  modifications,
  placement,
  linear_analyses,
  inference,
  sensors,
  validation,
  motion,
  prediction,
  consistency,
  other,  ///< of a step without a place of its own
  model
};

struct PlacedSection {
  PagePlace place = PagePlace::other;
  Section section;
};

/// File that a step keeps in the folder of the results, from which an interrupted run goes on.
struct StepCheckpoint {
  std::string_view file = {};
  /// An interrupted run keeps it although the step has ended, as nothing else holds the step's outcome.
  bool outlives_step = false;
};

/// One step of a run: what it is called, when a run takes it, what it computes, and what it adds to what a run writes.
/// All that is optional may be left out. What it adds is asked for only after the step has `ran`.
struct RunStep {
  std::string_view name;          ///< of its verb, of its time: "estimate"
  std::string_view meaning = {};  ///< of the verb, for its help; empty: it has no verb
  std::string_view section = {};  ///< of the case, where its name is not that of the verb: "frequency_response"

  /// @name When a run takes it
  ///@{
  bool (*asked_for)(const Study&) = nullptr;  ///< whether the case asks for it
  std::vector<std::string_view> with = {};    ///< other steps that its verb takes
  std::vector<std::string_view> after = {};   ///< a step without a verb is taken where one of these is
  bool always = false;                        ///< its `run` is called in every run, also where it is not taken
  ///@}

  /// @name What it computes
  ///@{
  std::vector<PlannedStep> (*phases)(const Study&) = nullptr;  ///< its words and shares on the progress bar
  /// Puts its outcome into the results; in `failure` of the results why there is none, in words.
  void (*run)(RunContext&) = nullptr;
  StepCheckpoint checkpoint = {};
  bool (*ran)(const StudyResults&) = nullptr;
  std::optional<double> (*seconds)(const StudyResults&) = nullptr;  ///< [s]; without it the step is one of the `phases`
  ///@}

  /// @name What it adds to summary.json, to the console, to the answer on the page, to its sections, to results.h5
  ///@{
  void (*summarise)(const Study&, const StudyResults&, nlohmann::ordered_json& summary) = nullptr;
  std::string (*tell)(const Study&, const StudyResults&) = nullptr;
  std::string (*answer)(const Study&, const StudyResults&) = nullptr;
  std::vector<PlacedSection> (*sections)(const Study&, const StudyResults&) = nullptr;
  void (*visit)(const Study&, const StudyResults&, SeriesWriter&) = nullptr;
  ///@}

  /// @name Files of its own
  ///@{
  void (*write)(const std::filesystem::path& folder, const Study&, const StudyResults&) = nullptr;
  std::vector<std::string> (*files)(const Study&) = nullptr;  ///< names whose places must be free
  ///@}

  [[nodiscard]] bool has_verb() const { return !meaning.empty(); }
  [[nodiscard]] std::string_view section_name() const { return section.empty() ? name : section; }
};

/// @name Entries of a step with one outcome
///@{
template <class Outcome>
bool has_outcome(const StudyResults& results) {
  return results.has<Outcome>();
}
template <class Outcome>
std::optional<double> seconds_of(const StudyResults& results) {
  const auto* outcome = results.find<Outcome>();
  return outcome ? std::optional(outcome->seconds) : std::nullopt;
}
///@}

}  // namespace kalfem
