#pragma once

#include <map>
#include <memory>

#include "kalfem/formats/deck.hpp"
#include "kalfem/identification/updating_setup.hpp"
#include "kalfem/records/record_preparation.hpp"
#include "kalfem/records/spectrum.hpp"
#include "kalfem/study/run_plan.hpp"

namespace kalfem {

/// What the reader of a finite-element substructure has to say beside its model.
struct ElementNotes {
  std::string substructure;
  std::vector<DeckNote> notes;  ///< the cards of its deck that were not used
};

/// A case that was read and understood: everything that the steps of a run need, as the library's own types. Immutable.
struct Study {
  std::string title, file;
  std::string resolved_case;  ///< the case with all its defaults, as YAML
  StructurePtr structure;
  std::vector<ElementNotes> element_notes;  ///< one a finite-element substructure
  double reduce_seconds = 0.0;
  std::shared_ptr<const CoupledModel> model;  ///< the structure as the case gives it
  std::vector<Sensor> sensors;
  std::optional<FrequencyBand> excitation_band;        ///< nothing where no excitation has one
  std::optional<SimulationPlan> simulation;            ///< where the case simulates
  std::optional<PreparedRecord> record;                ///< where the case reads one
  std::optional<UpdatingSetup> updating;               ///< where the case updates
  std::optional<UpdatingPlan> updating_plan;           ///< there too
  EstimationProblemPtr problem;                        ///< where the case estimates
  std::optional<AugmentedModelSetup> augmented_model;  ///< there too; of what the updating starts from
  std::optional<PredictionPlan> prediction;            ///< where the case predicts
  std::vector<StructuralModification> modifications;
  ReportPlan report;
  std::vector<std::string> warnings;  ///< what is allowed but probably not meant

  [[nodiscard]] double sample_rate() const;
};

/// Reads a case file. Throws InvalidInput with every problem found in it and in the files it names.
Study load_study(const std::string& file);

}  // namespace kalfem
