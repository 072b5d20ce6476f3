#pragma once

#include <map>
#include <memory>

#include "kalfem/formats/deck.hpp"
#include "kalfem/identification/updating_setup.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/study/record_source.hpp"

namespace kalfem {

/// What the reader of a finite-element substructure has to say beside its model.
struct ElementNotes {
  std::string substructure;
  std::vector<DeckNote> notes;  ///< the cards of its deck that were not used
};

/// A case that was read and understood: everything that the steps of a run need. Immutable.
struct Study {
  description::Case given;
  std::string file;
  StructurePtr structure;
  std::vector<ElementNotes> element_notes;  ///< one a finite-element substructure
  double reduce_seconds = 0.0;
  std::shared_ptr<const CoupledModel> model;  ///< the structure as the case gives it
  std::vector<Sensor> sensors;
  std::optional<MeasuredRecord> record;                ///< where the case reads one
  std::optional<UpdatingSetup> updating;               ///< where the case updates
  EstimationProblemPtr problem;                        ///< where the case estimates
  std::optional<AugmentedModelSetup> augmented_model;  ///< where the case estimates; of what the updating starts from
  std::vector<std::string> warnings;                   ///< what is allowed but probably not meant

  [[nodiscard]] double sample_rate() const;
};

/// Reads a case file. Throws InvalidInput with every problem found in it and in the files it names.
Study load_study(const std::string& file);
/// The same of a case that was read from `file`.
Study make_study(description::Case given, const std::string& file);

}  // namespace kalfem
