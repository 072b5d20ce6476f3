// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/diagnosis/candidates.hpp"

namespace kalfem {

/// Every mistake that the run suggests, with first guesses of its number from what runs over the record say: each
/// sensor beside its prediction by the others, each excitation beside what it explains, the motion of connectors.
struct Candidates {
  std::vector<Hypothesis> hypotheses;
  std::vector<ConnectorMotion> motion;  ///< of each connector of the parts; empty: not known
};
Candidates all_candidates(const DiagnosisInput& input, const FilterRun& base, const EstimationOptions& options);

/// How many such runs there are.
Eigen::Index runs_for_hypotheses(const FilterRun& base);

}  // namespace kalfem
