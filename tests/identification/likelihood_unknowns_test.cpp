// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "identification/imperfect_sensors.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/records/fractional_shift.hpp"

// Gains, delays and noise of sensors, found beside the unknowns of the structure.

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

RecordEstimate estimated(const EstimationProblem& problem, const Record& record) {
  const auto given = shared(problem);
  IssueList issues;
  const auto setup = make_augmented_model_setup(*given, given->structure->parts, {}, issues);
  issues.raise();
  return estimate_record(given, setup, record);
}

double estimate_of(const RecordEstimate& estimate, Index i) { return estimate.result.unknowns.mean(i, Eigen::last); }
double deviation_of(const RecordEstimate& estimate, Index i) {
  return estimate.result.unknowns.deviation(i, Eigen::last);
}

TEST(LikelihoodUnknowns, GainOffsetAndDelayAreFoundBesideTheSuspension) {
  EstimationProblem problem = chain_problem();
  const std::vector<SensorFault> faults{{.gain = 1.3}, {.offset = 0.5}, {.delay = 28}, {}};
  const Record record = faulty_record(problem, fine_chain_signals(problem, 4.0), faults, 1);
  problem.offsets = {{.name = "sensors.a4.offset", .sensor = "a4", .deviation = 1.0}};
  problem.settings.likelihood_unknowns = {unknown_gain("a2", 0.3), unknown_delay("a6", 5e-3)};
  const auto estimate = estimated(problem, record);
  ASSERT_TRUE(estimate.likelihood);
  const auto& found = *estimate.likelihood;
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.values[0], 1.3, 3.0 * found.deviation[0]);
  EXPECT_NEAR(found.values[0], 1.3, 0.02 * 1.3);
  EXPECT_NEAR(found.values[1], 7e-3, 3.0 * found.deviation[1]);
  EXPECT_NEAR(found.values[1], 7e-3, 0.02 * 7e-3);
  EXPECT_NEAR(estimate_of(estimate, 2), 0.5, 3.0 * deviation_of(estimate, 2));
  for (const auto& [i, truth] : {std::pair{0, true_mu_k1}, {1, true_mu_c1}})
    EXPECT_NEAR(estimate_of(estimate, i), truth, 3.0 * deviation_of(estimate, i)) << i;
  EXPECT_NEAR(estimate.consistency.mean_nis, 4.0, 0.2);
}

// A rack of two sensors runs 2000 ppm fast, 8 samples at the end; its delay at the start is another unknown of one of
// them. The signals are those of the fine simulation at the motion's time, by a straight line: error 1e-4 of the
// motion.
TEST(LikelihoodUnknowns, DriftOfARackIsFoundBesideADelay) {
  EstimationProblem problem = chain_problem();
  constexpr double drift = 2e-3, delay = 3e-3;
  const auto fine = fine_chain_signals(problem, 4.0);
  Record record = faulty_record(problem, fine, {{}, {}, {}, {}}, 4);
  for (const auto& [row, late] : {std::pair{1, 0.0}, {2, delay}})
    for (Index k = 0; k < record.samples(); ++k) {
      const double at = std::max(0.0, 4.0 * chain_rate * (record.time(k) - late) / (1.0 + drift));
      const auto value = [&](double place) {
        const auto left = std::min(static_cast<Index>(place), fine.cols() - 2);
        return fine(row, left) + (place - static_cast<double>(left)) * (fine(row, left + 1) - fine(row, left));
      };
      record.values(row, k) += value(at) - fine(row, 4 * k);
    }
  problem.settings.likelihood_unknowns = {unknown_drift({"a4", "a6"}, 1e-3), unknown_delay("a6", 5e-3)};
  const auto estimate = estimated(problem, record);
  ASSERT_TRUE(estimate.likelihood);
  const auto& found = *estimate.likelihood;
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.values[0], drift, 4.0 * found.deviation[0]);
  EXPECT_LT(found.deviation[0], 0.02 * drift);
  EXPECT_NEAR(found.values[1], delay, 4.0 * found.deviation[1]);
  EXPECT_EQ(found.unknowns[0].since, record.start);
  EXPECT_NEAR(estimate.consistency.mean_nis, 4.0, 0.2);
}

TEST(LikelihoodUnknowns, ASensorThatIsTurnedHasANegativeGain) {
  EstimationProblem problem = chain_problem();
  const Record record = faulty_record(problem, fine_chain_signals(problem, 3.0), {{.gain = -1.0}, {}, {}, {}}, 2);
  problem.settings.likelihood_unknowns = {unknown_gain("a2", 0.3)};
  const auto estimate = estimated(problem, record);
  ASSERT_TRUE(estimate.likelihood);
  EXPECT_NEAR(estimate.likelihood->values[0], -1.0, 4.0 * estimate.likelihood->deviation[0]);
  const auto interval = estimate.likelihood->interval(0);
  EXPECT_LT(interval.lower, -1.0 + 4.0 * estimate.likelihood->deviation[0]);
  EXPECT_LT(interval.lower, interval.upper);
}

// A sensor that only shows its noise tells nothing of its clock.
TEST(LikelihoodUnknowns, AStillRecordDoesNotShowADelay) {
  EstimationProblem problem = chain_problem();
  auto still = std::make_shared<StructureData>(*problem.structure);
  still->signals = {make_random({.rms = 1e-9, .lower = 0.5, .upper = 30.0, .duration = 20.0, .seed = 7})};
  problem.structure = still;
  for (auto& sensor : problem.sensors) {
    sensor.relative_noise = false;
    sensor.noise = 0.1;
  }
  const Record record = faulty_record(problem, fine_chain_signals(problem, 2.0), {{}, {}, {}, {}}, 3);
  problem.settings.likelihood_unknowns = {unknown_delay("a6", 5e-3)};
  const auto estimate = estimated(problem, record);
  ASSERT_TRUE(estimate.likelihood);
  EXPECT_FALSE(estimate.likelihood->visible[0]);
  EXPECT_NEAR(estimate.likelihood->deviation[0], 5e-3, 1e-3);
}

TEST(LikelihoodUnknowns, NoiseThatIsStatedWrongIsFound) {
  EstimationProblem problem = chain_problem();
  Record record = faulty_record(problem, fine_chain_signals(problem, 2.0), {{}, {}, {}, {}}, 4);
  for (const double factor : {0.1, 10.0}) {
    Record stated = record;
    problem.settings.likelihood_unknowns.clear();
    for (auto& channel : stated.channels) {
      channel.noise *= factor;
      problem.settings.likelihood_unknowns.push_back({"sensors." + channel.name + ".noise",
                                                      LikelihoodUnknownKind::sensor_noise,
                                                      {channel.name},
                                                      channel.unit,
                                                      channel.noise,
                                                      3.0 * channel.noise});
    }
    const auto estimate = estimated(problem, stated);
    ASSERT_TRUE(estimate.likelihood) << factor;
    EXPECT_NEAR(estimate.consistency.mean_nis, 4.0, 0.4) << factor;
    for (std::size_t i = 0; i < record.channels.size(); ++i) {
      const auto row = static_cast<Index>(i);
      EXPECT_NEAR(estimate.likelihood->values[row], record.channels[i].noise, 4.0 * estimate.likelihood->deviation[row])
          << factor;
    }
  }
}

TEST(FractionalShift, MovesASineByItsPhaseAndKeepsWhiteNoiseWhite) {
  const Index samples = 1000;
  VectorXd sine(samples), moved_sine(samples), noise(samples);
  RandomStream random(1, "noise");
  for (Index k = 0; k < samples; ++k) {
    sine[k] = std::sin(0.3 * static_cast<double>(k));
    moved_sine[k] = std::sin(0.3 * (static_cast<double>(k) + 2.4));
    noise[k] = random.normal();
  }
  const VectorXd found = shifted(sine, 2.4);
  EXPECT_LT((found - moved_sine).segment(50, samples - 100).cwiseAbs().maxCoeff(), 2e-3);  // what the ends' bend leaves
  EXPECT_TRUE(std::isnan(found[samples - 1]));
  const VectorXd moved = shifted(noise, 0.5);
  EXPECT_NEAR(moved.head(samples - 1).squaredNorm() / noise.squaredNorm(), 1.0, 0.02);  // the last one is missing
  EXPECT_TRUE(shifted(noise, 3.0).head(samples - 3).isApprox(noise.tail(samples - 3), 1e-9));
}

}  // namespace
}  // namespace kalfem::test
