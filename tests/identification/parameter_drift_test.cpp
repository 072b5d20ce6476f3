// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/parameter_drift.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "identification/changing_structures.hpp"
#include "kalfem/diagnosis/judge_estimation.hpp"
#include "kalfem/diagnosis/look_for_cause.hpp"
#include "kalfem/identification/change_levels.hpp"

// A stiffness that drifts is no jump, one that jumps no drift, and a spike neither.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using test::ChangingRecord;
using test::ChangingStructure;
using test::Course;
using test::StiffnessChange;

/// Forty values of unit variance about a course of that size.
StretchLevels levels_about(const StiffnessChange& change, double size, std::uint64_t seed) {
  constexpr Index count = 40;
  StretchLevels levels{.length = 10};
  levels.value.resize(count);
  levels.variance = VectorXd::Ones(count);
  RandomStream random(seed, "levels");
  for (Index k = 0; k < count; ++k) {
    levels.end.push_back(10 * (k + 1));
    const double t = (static_cast<double>(k) + 0.5) / count;
    levels.value[k] = size * change.factor(t) + random.normal();
  }
  return levels;
}

TEST(ChangeLevels, TellOneLevelFromTwoAndFromASlowCourse) {
  int alarms = 0, steps = 0, slow = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    alarms += fits_of(levels_about({}, 0.0, seed)).best() > 10.0 ? 1 : 0;
    const LevelFits step = fits_of(levels_about({Course::drop, 1.0, 0.4}, 5.0, seed));
    steps += !step.is_slow() && std::abs(static_cast<double>(step.place) - 16.0) <= 1.0 ? 1 : 0;
    for (const auto& change :
         {StiffnessChange{Course::line, 1.0, 0.0}, {Course::saturating, 1.0, 0.3}, {Course::sine, 1.0, 1.5}})
      slow += fits_of(levels_about(change, 8.0, seed)).is_slow() ? 1 : 0;
  }
  EXPECT_EQ(alarms, 0);
  EXPECT_GE(steps, 48);
  EXPECT_GE(slow, 144);
}

TEST(ChangeLevels, OfAWalkAreSmoothed) {
  const StretchLevels levels = levels_about({Course::line, 1.0, 0.0}, 20.0, 3);
  const WalkedCourse course = smoothed_walk(levels, fits_of(levels).walk, 1.0);
  const Index last = course.value.size() - 1;
  const double deviation = std::hypot(course.deviation[0], course.deviation[last]);
  EXPECT_NEAR(course.value[last] - course.value[0], -20.0 * 39.0 / 40.0, 3.0 * deviation);
  EXPECT_LT(deviation, 1.3);  // a single difference has 1.41
}

/// Three masses in a row with accelerometers on all.
ChangingStructure three_masses(const StiffnessChange& change) {
  ChangingStructure structure;
  structure.parent = {-1, 0, 1};
  structure.mass = Eigen::Vector3d(10.0, 8.0, 12.0);
  structure.stiffness = Eigen::Vector3d(40e3, 50e3, 30e3);
  structure.cubic = VectorXd::Zero(3);
  structure.damping = Eigen::Vector3d(40.0, 50.0, 30.0);
  structure.forced = 2;
  structure.sensed = {0, 1, 2};
  structure.changing = 1;
  structure.change = change;
  test::set_frequencies(structure);
  return structure;
}

struct Estimated {
  RecordEstimate estimate;
  std::vector<Reason> reasons;
  std::optional<Diagnosis> diagnosis;
};

Estimated estimate_of(const ChangingRecord& made) {
  const auto problem = test::shared(made.problem);
  IssueList issues;
  auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  Estimated estimated{estimate_record_thoroughly(problem, setup, made.record), {}, {}};
  estimated.reasons = verdict_of(estimated.estimate).reasons();
  estimated.diagnosis = look_for_cause(*problem, problem->structure->parts, made.record, estimated.estimate);
  return estimated;
}

class Drifts : public testing::TestWithParam<StiffnessChange> {};

TEST_P(Drifts, AreNamedFirst) {
  const auto made = changing_record(three_masses(GetParam()), 1);
  const auto [estimate, reasons, diagnosis] = estimate_of(made);
  ASSERT_FALSE(reasons.empty());
  EXPECT_EQ(reasons.front().code, "parameter_drift");
  EXPECT_EQ(reasons.front().subject, made.changing);
  EXPECT_NE(reasons.front().remedy.find("random_walk: "), std::string::npos) << reasons.front().remedy;
  EXPECT_FALSE(diagnosis.has_value());  // nothing else is to be explained
  ASSERT_EQ(estimate.events.size(), 1U);
  EXPECT_EQ(estimate.events[0].kind, EventKind::drift);
  ASSERT_TRUE(estimate.jump.has_value());
  const auto& [event, drift] = std::pair(estimate.events[0], *estimate.jump);
  const auto truth = [&](double time) { return 50e3 * GetParam().factor(time / 20.0); };
  EXPECT_NEAR(drift.before, truth(event.from), 0.02 * 50e3);
  EXPECT_NEAR(drift.after, truth(event.to), 0.02 * 50e3);
  EXPECT_NEAR(drift.after - drift.before, truth(event.to) - truth(event.from), 4.0 * drift.deviation);
  EXPECT_GT(std::abs(drift.after - drift.before), 0.8 * GetParam().size * 50e3);
  EXPECT_NEAR(random_walk_of(event, drift), std::abs(drift.after - drift.before) / std::sqrt(event.to - event.from),
              1e-9 * drift.before);
}

INSTANTIATE_TEST_SUITE_P(Courses, Drifts,
                         testing::Values(StiffnessChange{Course::line, 0.2, 0.0},
                                         StiffnessChange{Course::saturating, 0.1, 0.3},
                                         StiffnessChange{Course::sine, 0.2, 1.5},
                                         StiffnessChange{Course::line, 0.03, 0.0}));

TEST(ParameterDrift, IsWhatADropIsNot) {
  const auto made = changing_record(three_masses({Course::drop, 0.2, 0.4}), 1);
  const auto [estimate, reasons, diagnosis] = estimate_of(made);
  ASSERT_FALSE(reasons.empty());
  EXPECT_EQ(reasons.front().code, "parameter_jump");
  EXPECT_EQ(reasons.front().subject, made.changing);
  ASSERT_TRUE(estimate.jump.has_value());
  EXPECT_FALSE(estimate.jump->is_drift());
  EXPECT_NEAR(estimate.measurements.time(estimate.jump->sample), 8.0, 0.1);
  EXPECT_EQ(estimate.events[0].kind, EventKind::jump);
}

/// A spike of 900 deviations among good samples throws the filter away for long; it is an event and no reason.
TEST(ParameterDrift, IsNotWhatASpikeLeaves) {
  for (const Index at : {3, 163, 2000}) {
    auto made = changing_record(three_masses({}), 2);
    made.problem.settings.substeps = 8;
    made.record.values(1, at) += 900.0 * made.record.channels[1].noise;
    const auto [estimate, reasons, diagnosis] = estimate_of(made);
    EXPECT_FALSE(estimate.jump.has_value()) << at;
    EXPECT_TRUE(reasons.empty()) << reasons.front().text;
    ASSERT_EQ(estimate.events.size(), 1U) << at;
    EXPECT_EQ(estimate.events[0].kind, EventKind::outliers) << at;
    const VectorXd found = estimate.result.unknowns.mean.rightCols(1);
    for (Index i = 0; i < found.size(); ++i)
      EXPECT_NEAR(found[i], made.truth[static_cast<std::size_t>(i)], 0.01 * found[i]) << at;
  }
}

}  // namespace
}  // namespace kalfem
