#include "kalfem/pipeline/run_steps.hpp"

#include "casefile/damping_of_unknowns.hpp"

// A first guess and a prior that the record contradicts.

namespace kalfem::test {
namespace {

const std::string usual = "mu_k1: {initial: 10 N, std: 50 %}";

StudyResults results_of(const std::string& mu_k1) {
  const Study study = study_of(with(chain_case("4 s", ""), usual, mu_k1));
  return run_study(study, Step::estimate);
}

bool holds(const std::string& text, const std::string& piece) { return text.find(piece) != std::string::npos; }

/// 1 % of the truth, a deviation of half of that: the filter ends far off, with small deviations.
TEST(PriorConflicts, AFirstGuessOfOnePerCentOfTheTruthIsNotTrusted) {
  const StudyResults results = results_of("mu_k1: {initial: 0.2 N, std: 50 %}");
  ASSERT_FALSE(results.usable());
  for (const char* piece : {"'suspension.mu_k1'", "prior standard deviations from its initial value 0.2",
                            "(expected 4): do not trust the estimates", "transform: log"})
    EXPECT_TRUE(holds(results.why_unusable(), piece)) << piece << " in: " << results.why_unusable();
}

/// A tenth of the truth: found all the same, but the prior was wrong.
TEST(PriorConflicts, AnEstimateFarFromItsPriorWithARightNisIsNamedOnly) {
  const StudyResults results = results_of("mu_k1: {initial: 2 N, std: 50 %}");
  EXPECT_TRUE(results.usable()) << results.why_unusable();
  ASSERT_EQ(results.warnings.size(), 1u);
  EXPECT_TRUE(holds(results.warnings[0], "prior standard deviations from its initial value 2")) << results.warnings[0];
}

TEST(PriorConflicts, AnEstimateWithinItsPriorIsNoConflict) {
  for (const char* prior : {"mu_k1: {initial: 10 N, std: 50 %}", "mu_k1: {initial: 2 N, std: 18 N, transform: log}"}) {
    const StudyResults results = results_of(prior);
    EXPECT_TRUE(results.usable()) << results.why_unusable();
    EXPECT_EQ(results.warnings, std::vector<std::string>{});
  }
}

}  // namespace
}  // namespace kalfem::test
