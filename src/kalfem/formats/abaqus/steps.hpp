// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <set>

#include "kalfem/formats/abaqus/placed_deck.hpp"

namespace kalfem::abaqus {

/// The step whose supports and temperatures the model has: the first *FREQUENCY, otherwise the first step that is not
/// static, otherwise the first one. nullptr without steps.
const RawDeck::Step* model_step(const RawDeck& raw);

/// The static step whose stress is in the stiffness of another step, nullptr where there is none or it is not loaded:
/// * CalculiX: of a *STEP, PERTURBATION the last static one before it, which may be a perturbation itself;
/// * Abaqus: of modes and static perturbations the last static one before them that is no perturbation, if large
///   displacements were on in it or earlier.
const RawDeck::Step* base_step(const RawDeck& raw, const RawDeck::Step& step);

/// The base_step() of the modes that the model is made for; nullptr where model_step() is a static one.
const RawDeck::Step* preload_step(const RawDeck& raw);

/// Whether a load case is made of the step: all static ones are wanted, or the preload rests on it.
bool wants_case(const RawDeck& raw, const RawDeck::Step& step);

/// Tells what steps ask for and the model does not have: loads, large displacements, the stress of earlier steps.
void note_steps(const RawDeck& raw, DeckNotes& notes, const Problems& problems);

/// A motion that *BOUNDARY prescribes.
struct Hold {
  std::string name;     ///< of the node set, otherwise "boundary"
  double value = 0.0;   ///< at the end of the step
  bool frozen = false;  ///< FIXED: it stays where the step before left it
  Where where;
};

/// What is prescribed at one time, by node and direction along the node's own axes.
using Holds = std::map<NodalDof, Hold>;

/// What *BOUNDARY prescribes in every step. Lines of a step are added to what holds before; a line gives a motion that
/// is held already its new value. OP=NEW in the first *BOUNDARY of a step lifts everything before it. A perturbation
/// starts without earlier values; in Abaqus, the step behind it goes on from the one before.
class SupportHistory {
public:
  SupportHistory(const RawDeck& raw, PlacedDeck& deck);

  [[nodiscard]] const Holds& of_model() const { return *model_; }  ///< those of model_step()
  /// `number` counts from 1.
  [[nodiscard]] const Holds& of_step(int number) const { return *steps_[static_cast<std::size_t>(number - 1)]; }
  /// Motions that a static load case moves, holds beside those of the model, or does not hold.
  [[nodiscard]] const std::set<NodalDof>& varying() const { return varying_; }

private:
  using Shared = std::shared_ptr<const Holds>;
  void read_lines(const Block& block, int place, Holds& holds);
  void find_varying(const RawDeck& raw);

  PlacedDeck& deck_;
  bool load_cases_;  ///< values are imposed by load cases
  Shared model_;
  std::vector<Shared> steps_;
  std::set<NodalDof> varying_;
};

/// Whether OP=NEW removes what earlier steps gave; a problem where OP is neither NEW nor MOD.
bool removes_earlier(PlacedDeck& deck, const Keyword& keyword);

/// Factor of a load or motion at the end of a static step: the value of the *AMPLITUDE that its keyword names, 1
/// without one. Problems where it is none of a table.
double amplitude_at_end(PlacedDeck& deck, const Keyword& keyword, const RawDeck& raw, const RawDeck::Step& step);

}  // namespace kalfem::abaqus
