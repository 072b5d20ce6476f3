// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "casefile/case_run.hpp"
#include "casefile/small_cases.hpp"

#include "kalfem/steps/simulation/outcome.hpp"

// Motion that no finer step brings together: a mass that rattles between stops.

namespace kalfem::test {
namespace {

const std::string rattle =
    rattling_mass +
    R"(simulate: {duration: 60 s, sample_rate: 100 Hz, integrator: newmark, first_substeps: 8, max_substeps: 128}
)";

TEST(SensitiveMotion, IsSaidWhereRefiningTheStepDoesNotHelp) {
  const auto results = results_of(rattle, "simulate");
  ASSERT_FALSE(results.complete());
  for (const char* part :
       {"chaotic or very sensitive", "refining the step does not reduce the difference", "simulate.substeps: 128"})
    EXPECT_NE(results.failure.find(part), std::string::npos) << results.failure;
  EXPECT_EQ(results.failure.find("raise simulate.max_substeps"), std::string::npos);
  // of five solutions; by rounding the coarsest may stop at an impact, which leaves those behind it
  ASSERT_GE(results.get<SimulationOutcome>().reference.changes.size(), 3U);
}

/// Where the step is only too long, a finer one is what helps.
TEST(SensitiveMotion, IsNotSaidWhereTheStepIsTooLong) {
  const auto results = results_of(changed(changed(rattle, "duration: 60 s", "duration: 0.5 s"), "max_substeps: 128",
                                          "max_substeps: 128, tolerance: 1e-9"),
                                  "simulate");
  ASSERT_FALSE(results.complete());
  EXPECT_NE(results.failure.find("raise simulate.max_substeps or simulate.tolerance"), std::string::npos)
      << results.failure;
}

TEST(SensitiveMotion, AFixedStepGivesOneOfTheMotions) {
  const auto fixed = results_of(changed(rattle, "first_substeps: 8, max_substeps: 128", "substeps: 16"), "simulate");
  ASSERT_TRUE(fixed.complete()) << fixed.failure;
  EXPECT_EQ(fixed.get<SimulationOutcome>().reference.substeps, 16);
  EXPECT_TRUE(fixed.get<SimulationOutcome>().reference.changes.empty());
  EXPECT_EQ(fixed.get<SimulationOutcome>().measurements.samples(), 6001);
  // it is the plain solution with that step
  const auto study = study_of(changed(rattle, "first_substeps: 8, max_substeps: 128", "substeps: 16"));
  const auto once =
      simulate(study.model->system(), study.structure->signals, at_rest(1, 0),
               {.integrator = Integrator::newmark, .step = 1.0 / 1600, .duration = 60.0, .keep_every = 16});
  EXPECT_EQ(once.trajectory.displacement.row(0), fixed.get<SimulationOutcome>().reference.sensors.row(0));
}

TEST(SensitiveMotion, AFixedStepIsNotHalvedAsWell) {
  const auto found = problems_of(changed(rattle, "max_substeps: 128", "max_substeps: 128, substeps: 16"));
  EXPECT_NE(found.find("case.yaml:10: simulate.substeps fixes the step"), std::string::npos) << found;
  EXPECT_EQ(problems_of(changed(rattle, "first_substeps: 8, max_substeps: 128", "substeps: 16")), "");
}

}  // namespace
}  // namespace kalfem::test
