// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>

#include "identification/changing_structures.hpp"
#include "kalfem/diagnosis/judge_estimation.hpp"
#include "kalfem/identification/parameter_drift.hpp"
#include "kalfem/identification/stated_interval.hpp"

// Heavy: chains and trees of one to six masses, of one to four sensors, whose records hold a spike, a stiffness that
// drops, one that drifts, or nothing of the kind. KALFEM_RECORDS: so many of each kind in the place of all.

namespace kalfem {
namespace {

using Eigen::Index;
using test::ChangingRecord;
using test::ChangingStructure;
using test::Course;

int records(int all) {
  const char* some = std::getenv("KALFEM_RECORDS");
  return some ? std::min(all, std::atoi(some)) : all;
}

/// `part` of what is asked of all records, of those that run.
int required(int part, int all) { return records(all) - (all - part) * records(all) / all; }

RecordEstimate estimate_of(const ChangingRecord& made) {
  const auto problem = test::shared(made.problem);
  IssueList issues;
  auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  return estimate_record_thoroughly(problem, setup, made.record);
}

bool is_first(const RecordEstimate& estimate, const std::string& code, const std::string& subject) {
  const auto reasons = verdict_of(estimate).reasons();
  return !reasons.empty() && reasons.front().code == code && reasons.front().subject == subject;
}

/// The largest error of an unknown in the deviations of its stated interval.
double largest_error(const RecordEstimate& estimate, const std::vector<double>& truth) {
  double largest = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const auto interval = stated_interval(estimate, row);
    const double found = estimate.result.unknowns.mean(row, estimate.result.unknowns.mean.cols() - 1);
    largest = std::max(largest, std::abs(found - truth[i]) / ((interval.upper - interval.lower) / (2.0 * 1.96)));
  }
  return largest;
}

TEST(ChangingRecords, OneSpikeAnywhereBendsNoEstimate) {
  int good = 0;
  const int all = records(100);
  for (int seed = 0; seed < all; ++seed) {
    ChangingStructure structure = test::random_structure(static_cast<std::uint64_t>(seed));
    structure.duration = std::floor(12000.0 / static_cast<double>(structure.sensed.size())) / structure.sample_rate;
    ChangingRecord made = changing_record(structure, static_cast<std::uint64_t>(seed));
    RandomStream random(static_cast<std::uint64_t>(seed), "spike");
    const double size = 5.0 * std::pow(200.0, random.uniform());
    const bool early = random.uniform() < 0.3;
    const auto at = static_cast<Index>(random.uniform() * (early ? 20.0 : static_cast<double>(made.record.samples())));
    const auto channel = static_cast<Index>(random.uniform() * static_cast<double>(structure.sensed.size()));
    const double noise = made.record.channels[static_cast<std::size_t>(channel)].noise;
    made.record.values(channel, at) += (random.uniform() < 0.5 ? -size : size) * noise;
    const RecordEstimate estimate = estimate_of(made);
    const bool usable = !estimate.result.failure && verdict_of(estimate).state() != VerdictState::unusable;
    if (usable && !estimate.jump && largest_error(estimate, made.truth) < 3.0)
      ++good;
    else
      std::printf("record %d: spike of %.0f deviations at sample %d\n", seed, size, static_cast<int>(at));
  }
  std::printf("one spike: %d of %d usable, errors below 3 deviations\n", good, all);
  EXPECT_GE(good, required(98, 100));
}

TEST(ChangingRecords, DropsAreNamedFirstWithTheirTimes) {
  int good = 0;
  const int all = records(100);
  for (int seed = 0; seed < all; ++seed) {
    ChangingStructure structure = test::random_structure(static_cast<std::uint64_t>(seed));
    RandomStream random(static_cast<std::uint64_t>(seed), "change");
    const double size = 0.02 * std::pow(20.0, random.uniform());
    structure.change = {Course::drop, size, 0.2 + 0.6 * random.uniform()};
    const ChangingRecord made = changing_record(structure, static_cast<std::uint64_t>(seed));
    const RecordEstimate estimate = estimate_of(made);
    bool found = is_first(estimate, "parameter_jump", made.changing);
    if (found) {
      const auto time = [&](Index sample) { return estimate.measurements.time(sample); };
      const double true_time = structure.change.place * structure.duration;
      const double earliest = time(estimate.jump->earliest), latest = time(estimate.jump->latest);
      found = std::abs(time(estimate.jump->sample) - true_time) < 0.1 ||
              (earliest <= true_time && true_time <= latest && latest - earliest <= 1.0);
    }
    if (found)
      ++good;
    else
      std::printf("record %d: drop of %.1f %% of %s\n", seed, 100.0 * size, made.changing.c_str());
  }
  std::printf("drops: %d of %d named first, with their time\n", good, all);
  EXPECT_GE(good, required(95, 100));
}

TEST(ChangingRecords, DriftsAreNamedFirstAndAreNoJumps) {
  int named = 0, jumps = 0;
  const int all = records(40);
  for (int seed = 0; seed < all; ++seed) {
    ChangingStructure structure = test::random_structure(static_cast<std::uint64_t>(seed));
    RandomStream random(static_cast<std::uint64_t>(seed), "change");
    const double size = 0.05 * std::pow(6.0, random.uniform()), kind = random.uniform(), place = random.uniform();
    structure.change = kind < 0.4   ? test::StiffnessChange{Course::line, size, 0.0}
                       : kind < 0.7 ? test::StiffnessChange{Course::saturating, size, 0.2 + 0.6 * place}
                                    : test::StiffnessChange{Course::sine, size, 1.0 + place};
    const ChangingRecord made = changing_record(structure, static_cast<std::uint64_t>(seed));
    const RecordEstimate estimate = estimate_of(made);
    const bool drift = is_first(estimate, "parameter_drift", made.changing);
    named += drift ? 1 : 0;
    jumps += estimate.jump && !estimate.jump->is_drift() ? 1 : 0;
    if (!drift) std::printf("record %d: drift of %.1f %% of %s\n", seed, 100.0 * size, made.changing.c_str());
  }
  std::printf("drifts: %d of %d named first, %d as a jump\n", named, all, jumps);
  EXPECT_GE(named, required(36, 40));
  EXPECT_LE(jumps, 2);
}

TEST(ChangingRecords, NothingIsSeenInConstants) {
  int alarms = 0;
  const int all = records(100);
  for (int seed = 100; seed < 100 + all; ++seed) {
    const auto structure = test::random_structure(static_cast<std::uint64_t>(seed));
    const RecordEstimate estimate = estimate_of(changing_record(structure, static_cast<std::uint64_t>(seed)));
    if (estimate.jump) ++alarms, std::printf("record %d: %s\n", seed, estimate.events.back().text.c_str());
  }
  std::printf("constants: %d alarms in %d records\n", alarms, all);
  EXPECT_EQ(alarms, 0);
}

}  // namespace
}  // namespace kalfem
