// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/api/estimate.hpp"
#include "kalfem/api/infer.hpp"

namespace kalfem {

/// One of several structures that may have given a record, with unknowns of its own.
struct CandidateStructure {
  std::string name;
  Structure structure;
  std::vector<UnknownDescription> unknowns = {};                   ///< beside those of all candidates
  std::vector<std::pair<std::string, MarginalPrior>> priors = {};  ///< of these, see InferOptions
};

/// What a record says of one structure.
struct ComparedStructure {
  std::string name;
  double probability = 0.0;       ///< P(structure | y), of the candidates with an evidence
  double log_evidence = 0.0;      ///< ln Z
  double log_evidence_std = 0.0;  ///< of ln Z
  double log_likelihood = 0.0;    ///< the largest one found
  double occam = 0.0;             ///< ln Z less that: what the freedom of its parameters costs
  std::string words;              ///< the best one against this one, after Kass and Raftery; empty: the best
  std::vector<PosteriorParameter> parameters;  ///< in the order of the unknowns
  std::vector<std::string> warnings;           ///< why its evidence may not hold, in words
  std::string failure;                         ///< why it has none, in words; empty: it has
};

/// Which of several structures a record comes from, the most probable first: each by its evidence Z with equal prior
/// probabilities, P_i = Z_i / sum_j Z_j. `options`: of all; its unknowns and priors are common to the candidates. It is
/// what infer.compare_laws of a case gives. Throws InvalidInput with every argument that is wrong, by its place
/// ("candidates[1] 'cubic': unknowns[0] 'mount.k9': ...").
std::vector<ComparedStructure> compare(const std::vector<CandidateStructure>& candidates, const Record& record,
                                       const InferOptions& options);

/// Several estimates of one record, by structures that may all be right, as one.
struct EstimateMixture {
  Eigen::VectorXd weights;                 ///< probability of each, all being as probable before; of a stop 0
  std::vector<EstimatedQuantity> outputs;  ///< those that every estimate with a weight has, by name
};

/// Weighs estimates by their evidence, which is EstimateResult::log_likelihood, the filter's own with the unknowns
/// integrated out, w_i = L_i / sum_j L_j. Outputs are the mixture, mean = sum w_i m_i and std^2 = sum w_i (s_i^2 +
/// (m_i - mean)^2): their bands hold the spread between the structures. It is what estimate.alternatives of a case
/// gives. Throws InvalidInput where there is none, all of them stopped, or their records have different lengths.
EstimateMixture mixture(const std::vector<EstimateResult>& estimates);

}  // namespace kalfem
