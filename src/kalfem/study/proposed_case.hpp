// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/freed_numbers.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// An edit of a case.
struct ProposedCase {
  std::string yaml;
  std::vector<std::string> edits;  ///< "estimate.unknown.body.3.mass: {initial: 1 kg, std: 0.1 kg}"
};

/// The study of the case with these numbers as unknowns of its filter, instead of what it states of them. Throws
/// InvalidInput where the case cannot have them.
Study study_with(const Study& study, const std::vector<TriedNumber>& freed);

/// The same as a case file, of which only the keys that the user gave and those edited are written. Nothing where the
/// case cannot have them.
std::optional<ProposedCase> propose(const Study& study, const std::vector<TriedNumber>& freed);

/// The case with process noise of this density [m/s^2/sqrt(Hz)] that the filter adapts.
std::optional<ProposedCase> propose_adapted_process(const Study& study, double density);

}  // namespace kalfem
