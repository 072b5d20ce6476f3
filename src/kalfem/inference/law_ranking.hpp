// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/inference/posterior_of_data.hpp"

namespace kalfem {

/// A part of a record that is not inferred from.
struct HeldBackRecord {
  EstimationProblemPtr problem;  ///< with the excitation over its time
  Record record;
  bool from_rest = false;  ///< the structure is at rest at its first sample
};

/// One of several models of the same record: a law, with the inference of its own unknowns.
struct LawCandidate {
  std::string name, law;
  InferenceProblem problem;
  std::optional<HeldBackRecord> held_back = {};
  RememberLikelihood remember = {};
};

/// Computes the posterior and the evidence of each candidate on the same record, and tries its posterior on the record
/// that is held back, if there is one. With equal prior probabilities,
///     P(law_i | y) = Z_i / sum_j Z_j.
/// The most probable first; those without evidence, with the reason, last.
std::vector<RankedLaw> rank_laws(const std::vector<LawCandidate>& candidates, const Record& record,
                                 const Progress& progress);

}  // namespace kalfem
