// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kalfem/steps/field_series.hpp"
#include "kalfem/steps/run_study.hpp"

#include "casefile/damping_of_unknowns.hpp"

// A first guess and a prior that the record contradicts.

namespace kalfem::test {
namespace {

const std::string usual = "mu_k1: {initial: 10 N, std: 50 %}";

StudyResults results_of(const std::string& mu_k1) {
  const Study study =
      study_of(with(with(chain_case("4 s", ""), usual, mu_k1), "estimate:\n", "estimate:\n  second_thoughts: full\n"));
  return run_study(study, "estimate");
}

bool holds(const std::string& text, const std::string& piece) { return text.find(piece) != std::string::npos; }

/// 1 % of the truth, a deviation of half of that: the filter ends far off, with small deviations.
TEST(PriorConflicts, AFirstGuessOfOnePerCentOfTheTruthIsNotTrusted) {
  const StudyResults results = results_of("mu_k1: {initial: 0.2 N, std: 50 %}");
  ASSERT_FALSE(results.usable());
  const auto reasons = results.verdict.reasons();
  EXPECT_EQ(reasons[0].code + " " + reasons[0].subject, "first_guess suspension.mu_k1") << reasons[0].text;
  for (const char* piece : {"the first guess of 'suspension.mu_k1', 0.2 N, is too far off", "transform: log"})
    EXPECT_TRUE(holds(results.why_unusable(), piece)) << piece << " in: " << results.why_unusable();
  const auto far = std::ranges::find(reasons, "far_from_prior", &Reason::code);
  ASSERT_NE(far, reasons.end());
  EXPECT_TRUE(holds(far->text, "prior standard deviations from its initial value 0.2")) << far->text;
}

/// A tenth of the truth: found all the same, but the prior was wrong.
TEST(PriorConflicts, AnEstimateFarFromItsPriorWithARightNisIsNamedOnly) {
  const StudyResults results = results_of("mu_k1: {initial: 2 N, std: 50 %}");
  EXPECT_TRUE(results.usable()) << results.why_unusable();
  EXPECT_EQ(results.verdict.state(), VerdictState::suspicious);
  ASSERT_EQ(results.warnings.size(), 2u);
  EXPECT_TRUE(holds(results.warnings[0], "the first guess of 'suspension.mu_k1', 2 N, is too far off"))
      << results.warnings[0];
  EXPECT_TRUE(holds(results.warnings[1], "prior standard deviations from its initial value 2")) << results.warnings[1];
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
