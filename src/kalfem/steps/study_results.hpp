// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <any>
#include <optional>
#include <stdexcept>
#include <string>
#include <typeindex>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kalfem/base/phase_times.hpp"
#include "kalfem/study/identified_case.hpp"
#include "kalfem/study/proposed_case.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// What the steps of a run found: at most one outcome of each type, each kept by value. A step that did not run has
/// left none. Who reads an outcome includes its header, steps/<step>/outcome.hpp.
class Outcomes {
public:
  template <class Outcome>
  [[nodiscard]] const Outcome* find() const {
    const auto found = outcomes_.find(typeid(Outcome));
    return found == outcomes_.end() ? nullptr : std::any_cast<Outcome>(&found->second);
  }
  template <class Outcome>
  [[nodiscard]] Outcome* find() {
    return const_cast<Outcome*>(std::as_const(*this).template find<Outcome>());
  }
  template <class Outcome>
  [[nodiscard]] bool has() const {
    return find<Outcome>() != nullptr;
  }

  /// Of a step that has run: throws std::logic_error where there is none.
  template <class Outcome>
  [[nodiscard]] const Outcome& get() const {
    if (const auto* outcome = find<Outcome>()) return *outcome;
    throw std::logic_error(std::string("the run has no ") + typeid(Outcome).name());
  }
  template <class Outcome>
  [[nodiscard]] Outcome& get() {
    return const_cast<Outcome&>(std::as_const(*this).template get<Outcome>());
  }

  /// Keeps an outcome in place of any other of its type.
  template <class Outcome>
  Outcome& put(Outcome outcome) {
    auto& place = outcomes_[typeid(Outcome)];
    return place.template emplace<Outcome>(std::move(outcome));
  }

private:
  std::unordered_map<std::type_index, std::any> outcomes_;
};

/// The results of a run: the outcome of each step, and what they are worth together.
struct StudyResults : Outcomes {
  std::vector<std::string> warnings;  ///< about the results, in addition to those of the study
  Verdict verdict;
  std::optional<IdentifiedCase> identified;  ///< of a usable run with an estimation or an updating
  std::optional<ProposedCase> proposed;      ///< an edit that the record asks for, tried on it
  std::string failure;                       ///< why a step failed, in words; empty if all ran to their end
  bool interrupted = false;                  ///< it was asked to stop
  PhaseTimes phases;  ///< "modes", "frequency_response", "diagnose", "validate", "verdict"; others have their `seconds`
  double total_seconds = 0.0;

  /// Whether every step ran to its end.
  [[nodiscard]] bool complete() const { return failure.empty(); }
  /// Whether the numbers can be used as well: nothing in them contradicts itself.
  [[nodiscard]] bool usable() const { return complete() && verdict.state() != VerdictState::unusable; }
  /// Why they cannot, in words: the failure, or the worst reason of the verdict. Empty if they can.
  [[nodiscard]] std::string why_unusable() const;
};

}  // namespace kalfem
