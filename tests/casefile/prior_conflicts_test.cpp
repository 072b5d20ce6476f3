#include "kalfem/casefile/prior_conflicts.hpp"

#include "casefile/damping_of_unknowns.hpp"

// A first guess and a prior that the record contradicts.

namespace kalfem::test {
namespace {

const std::string usual = "mu_k1: {initial: 10 N, std: 50 %}";

std::vector<std::string> conflicts_of(const std::string& mu_k1) {
  const Study study = study_of(with(chain_case("4 s", ""), usual, mu_k1));
  return run_study(study, Stage::estimate).warnings;
}

bool holds(const std::string& text, const std::string& piece) { return text.find(piece) != std::string::npos; }

/// 1 % of the truth, a deviation of half of that: the filter ends far off, with small deviations.
TEST(PriorConflicts, AFirstGuessOfOnePerCentOfTheTruthIsNotTrusted) {
  const auto conflicts = conflicts_of("mu_k1: {initial: 0.2 N, std: 50 %}");
  ASSERT_EQ(conflicts.size(), 1u);
  for (const char* piece : {"'suspension.mu_k1'", "prior standard deviations from its first guess 0.2",
                            "(expected 4): do not trust the estimates", "transform: log"})
    EXPECT_TRUE(holds(conflicts[0], piece)) << piece << " in: " << conflicts[0];
}

/// A tenth of the truth: found all the same, but the prior was wrong.
TEST(PriorConflicts, AnEstimateFarFromItsPriorWithARightNisIsNamedOnly) {
  const auto conflicts = conflicts_of("mu_k1: {initial: 2 N, std: 50 %}");
  ASSERT_EQ(conflicts.size(), 1u);
  EXPECT_FALSE(holds(conflicts[0], "do not trust")) << conflicts[0];
}

TEST(PriorConflicts, AnEstimateWithinItsPriorIsNoConflict) {
  EXPECT_TRUE(conflicts_of(usual).empty());
  EXPECT_TRUE(conflicts_of("mu_k1: {initial: 2 N, std: 18 N, transform: log}").empty());
}

}  // namespace
}  // namespace kalfem::test
