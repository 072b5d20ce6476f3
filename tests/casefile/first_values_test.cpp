// SPDX-License-Identifier: Apache-2.0
#include "casefile/damping_of_unknowns.hpp"
#include "kalfem/steps/updating/compute.hpp"

// What an updating finds at the first values of its parameters, before it searches.

namespace kalfem::test {
namespace {

/// Two frames, of which the modes of the first alone are compared.
std::string frames(const std::string& parameters) {
  return R"(kalfem: 1
substructures:
  frame:
    masses: {1: 5 kg}
    springs: [{name: a, from: ground, to: 1, stiffness: 50 kN/m}]
  other:
    masses: {1: 5 kg}
    springs: [{name: b, from: ground, to: 1, stiffness: 50 kN/m}]
update:
  parameters:
    )" + parameters +
         R"(
  compare: {tap: {modes: frame, frequencies: [15 Hz]}}
)";
}

std::string refusal_of(const Study& study) {
  try {
    check_first_values(study);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(FirstValues, AParameterThatNoComparisonDependsOnIsRefusedByCheckAsByRun) {
  const Study study = study_of(frames("{frame.a.stiffness: {}, other.b.stiffness: {}}"));
  const std::string refusal = refusal_of(study);
  EXPECT_NE(refusal.find("chain.yaml:11: update.parameters.other.b.stiffness: no comparison depends on this parameter"),
            std::string::npos)
      << refusal;
  try {
    run_study(study, "update");
    ADD_FAILURE() << "the run accepts it";
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.what(), refusal);
  }
  EXPECT_EQ(refusal_of(study_of(frames("{frame.a.stiffness: {}}"))), "");
}

/// A filter that fails at the first values is an outcome, as it takes the record to find out.
TEST(FirstValues, WhereTheFilterFailsTheResultsAreNotUsable) {
  const std::string text = chain_case("3 s", "") +
                           "\nupdate:\n  parameters: {body.7-8.stiffness: {}}\n"
                           "  compare: {record: {time_history: body}}\n";
  const Study study = study_of(with(text, "mu_k1: {initial: 10 N, std: 50 %}", "mu_k1: {initial: 10 N, std: 1e90 N}"));
  check_first_values(study);
  const StudyResults results = run_study(study, "update");
  EXPECT_FALSE(results.complete());
  EXPECT_NE(results.failure.find("at the initial values of the updated parameters"), std::string::npos)
      << results.failure;
}

}  // namespace
}  // namespace kalfem::test
