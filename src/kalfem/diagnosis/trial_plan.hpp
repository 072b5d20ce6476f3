// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <optional>
#include <vector>

#include "kalfem/diagnosis/correction.hpp"

namespace kalfem {

/// What the search for one mistake may take. Without a limit every hypothesis sees the whole part. With one they are
/// raced (successive halving: Karnin, Koren and Somekh 2013, ICML, 1238-1246): all see a short part, a third of them a
/// longer one, and the best the whole; what is left goes into the search of their numbers.
struct TrialPlan {
  int substeps = 1;
  Eigen::Index samples = 0;    ///< of the record's first part
  std::size_t refined = 8;     ///< hypotheses whose number is searched
  int most_steps = 10;         ///< of such a search
  std::size_t laws = 3;        ///< connectors whose laws are looked into force by force
  std::size_t terms = 3;       ///< of one law
  std::size_t next_terms = 5;  ///< that are tried beside the best
  std::size_t finalists = 12;
  double raced = std::numeric_limits<double>::infinity();  ///< whole parts that each round before the last may take
  bool searches_early = false;  ///< numbers of the finalists are searched on short parts, too

  /// Hypotheses that see so many first samples of the part.
  struct Round {
    std::size_t hypotheses = 0;
    Eigen::Index samples = 0;
  };
  /// `starts`: first guesses of all hypotheses together.
  [[nodiscard]] std::vector<Round> rounds(std::size_t hypotheses, std::size_t starts) const;
};

/// The plan for the steps that are allowed: with as many substeps as leave the part long enough to tell anything.
/// Nothing where none do.
std::optional<TrialPlan> plan_for(const DiagnosisInput& input, const FilterRun& run);

/// The plan of the searches that follow one without a limit.
TrialPlan plan_of_next(TrialPlan plan);

}  // namespace kalfem
