// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>

#include "kalfem/base/phase_times.hpp"
#include "kalfem/base/progress.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/identification/updating_setup.hpp"
#include "kalfem/records/record_preparation.hpp"
#include "kalfem/records/spectrum.hpp"
#include "kalfem/study/frequency_response_plan.hpp"
#include "kalfem/study/inference_plan.hpp"
#include "kalfem/study/placement_plan.hpp"
#include "kalfem/study/run_plan.hpp"
#include "kalfem/study/statics_plan.hpp"
#include "kalfem/study/validation_plan.hpp"
#include "kalfem/yaml/case_changes.hpp"

namespace kalfem {

namespace description {
struct Case;
}

/// Notes of the reader on the deck of a finite-element substructure.
struct ElementNotes {
  std::string substructure;
  std::vector<DeckNote> notes;  ///< cards that kalfem ignores, and choices that it made
};

/// A case that has been read and checked. Holds all that the steps of a run need, as types of the library. Immutable.
struct Study {
  std::string title, file;
  std::string resolved_case;                             ///< the case with all its defaults, as YAML
  std::shared_ptr<const description::Case> description;  ///< the case as it was read
  std::vector<std::filesystem::path> files;              ///< that the case names: records, decks, tables
  std::map<std::string, std::string> units;              ///< in which it states its parameters, see written_units()
  StructurePtr structure;
  std::vector<ElementNotes> element_notes;    ///< one per finite-element substructure
  double reduce_seconds = 0.0;                ///< reading, assembly and reduction of the finite-element substructures
  PhaseTimes reduce_phases;                   ///< parts of them
  double load_seconds = 0.0;                  ///< all of the reading and checking, with these
  std::shared_ptr<const CoupledModel> model;  ///< the structure as the case gives it
  std::vector<Sensor> sensors;
  std::optional<FrequencyBand> excitation_band;        ///< nothing if no excitation has one
  std::optional<SimulationPlan> simulation;            ///< if the case has `simulate`
  std::optional<PreparedRecord> record;                ///< if the case has `record`
  std::optional<UpdatingSetup> updating;               ///< if the case has `update`
  std::optional<UpdatingPlan> updating_plan;           ///< likewise
  EstimationProblemPtr problem;                        ///< if the case has `estimate`
  std::optional<AugmentedModelSetup> augmented_model;  ///< likewise; at the initial values of the updating
  std::vector<LawAlternative> alternatives;            ///< of `estimate`: the same case with other laws
  std::optional<ValidationPlan> validation;            ///< if the case has `validate`
  std::optional<PredictionPlan> prediction;            ///< if the case has `predict`
  std::vector<StructuralModification> modifications;
  std::optional<InferencePlan> inference;                   ///< if the case has `infer`
  std::optional<PlacementPlan> placement;                   ///< if the case has `place`
  std::optional<StaticsPlan> statics;                       ///< if the case has `static`
  std::optional<FrequencyResponsePlan> frequency_response;  ///< if the case has it
  ReportPlan report;
  std::vector<std::string> warnings;  ///< settings that are allowed but are probably a mistake

  [[nodiscard]] double sample_rate() const;
  /// The unit in which the case states a parameter; empty where it states none.
  [[nodiscard]] std::string written_unit(const std::string& parameter) const;
};

/// Reads a case file, with some of its keys changed. Throws InvalidInput with every problem found in it and in the
/// files it names. Only finite-element substructures take time: `progress` shows them, "reduce 1 of 4".
Study load_study(const std::string& file, const std::vector<CaseChange>& changes = {}, const Progress& progress = {});

}  // namespace kalfem
