// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "casefile/case_run.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/judge.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

// Unknowns of the measurement in a case: gains, offsets, delays and noise of its sensors.

namespace kalfem::test {
namespace {

using Eigen::Index;

/// Two masses, of whose sensors one is not trusted.
const std::string two_masses = R"(kalfem: 1
substructures:
  s:
    masses: {1: 1 kg, 2: 1 kg}
    springs:
      - {name: k1, from: ground, to: 1, stiffness: 2 kN/m, damping: 2 N s/m}
      - {name: k2, from: 1, to: 2, stiffness: 3 kN/m, damping: 2 N s/m}
excitation:
  f: {force: s.1, random: {rms: 10 N, band: [1, 15 Hz], fade_in: 0.2 s, seed: 2}}
sensors:
  x1: {displacement: s.1, noise: 5 %}
  a2: {acceleration: s.2, noise: 5 %}
simulate: {duration: 5 s, sample_rate: 200 Hz, seed: 3}
estimate:
  diagnose: false
  unknown:
    s.k2.stiffness: {initial: 2.5 kN/m, std: 20 %}
    UNKNOWN
)";

std::string with(const std::string& unknown) { return changed(two_masses, "UNKNOWN", unknown); }

TEST(MeasurementUnknowns, AreEstimatedAndReported) {
  const Study study = study_of(
      with("sensors.a2.gain: {initial: 1.4, std: 50 %, truth: 1}\n    sensors.a2.delay: {initial: 0 s, std: 4 ms}\n"
           "    sensors.x1.offset: {initial: 0 mm, std: 2 mm}\n    sensors.x1.noise: {initial: 0.4 mm}"));
  const auto results = run_study(study, "predict");
  ASSERT_TRUE(results.has<EstimationOutcome>() && results.get<EstimationOutcome>().likelihood);
  const auto& found = *results.get<EstimationOutcome>().likelihood;
  ASSERT_EQ(found.unknowns.size(), 3U);
  const double noise = results.get<SimulationOutcome>().measurements.channels[0].noise;
  const double truth[] = {1.0, 0.0, noise};
  for (Index i = 0; i < 3; ++i)
    EXPECT_NEAR(found.values[i], truth[i], 4.0 * found.deviation[i])
        << found.unknowns[static_cast<std::size_t>(i)].name;

  const auto summary = summarise(study, results);
  const auto& gain = summary["parameters"]["sensors.a2.gain"];
  EXPECT_DOUBLE_EQ(gain["estimate"].get<double>(), found.values[0]);
  EXPECT_DOUBLE_EQ(gain["std"].get<double>(), found.deviation[0]);
  EXPECT_DOUBLE_EQ(gain["true"].get<double>(), 1.0);
  EXPECT_LT(gain["interval_95"][0].get<double>(), 1.0);
  EXPECT_GT(gain["interval_95"][1].get<double>(), 1.0);
  EXPECT_TRUE(gain["visible"].get<bool>());
  EXPECT_EQ(summary["parameters"]["sensors.a2.delay"]["unit"], "s");
  EXPECT_NEAR(summary["parameters"]["sensors.x1.offset"]["estimate"].get<double>(), 0.0,
              4.0 * summary["parameters"]["sensors.x1.offset"]["std"].get<double>());
  EXPECT_EQ(parameter_table(study, results.get<EstimationOutcome>()).rows.size(), 5U);

  const auto identified = identified_case_of(study, results);
  ASSERT_TRUE(identified);
  const Study again = study_of(identified->yaml);
  EXPECT_EQ(again.problem->settings.likelihood_unknowns[0].initial, found.values[0]);
  EXPECT_EQ(again.problem->settings.likelihood_unknowns[2].initial, found.values[2]);
}

// The stated noise is ten times too small: what is found brings NIS to its expectation.
TEST(MeasurementUnknowns, ProcessNoiseStandsForWhatTheModelLeavesOut) {
  const auto wrong = changed(with("process_noise: {initial: 0.01, std: 100 %}"), "  diagnose: false\n",
                             "  diagnose: false\n  process_noise: {acceleration: 0}\n");
  const auto results = results_of(wrong);
  ASSERT_TRUE(results.has<EstimationOutcome>() && results.get<EstimationOutcome>().likelihood);
  EXPECT_NEAR(results.get<EstimationOutcome>().consistency.mean_nis, 2.0, 0.2);
  EXPECT_GE(results.get<EstimationOutcome>().likelihood->values[0], 0.0);
}

TEST(MeasurementUnknowns, AreRefusedWhereTheyMakeNoSense) {
  const std::pair<std::string, std::string> cases[] = {
      {"sensors.a3.gain: {initial: 1}", "there is no sensor 'a3' (did you mean 'a2'?)"},
      {"sensors.a2.gain: {initial: 0}", "a gain of 0 is given"},
      {"sensors.a2.delay: {initial: 0}", "it has no `std`"},
      {"sensors.a2.delay: {initial: 0 m, std: 1 ms}", "delay.initial"},
      {"sensors.a2.drift: {initial: 0}", "give std in ppm"},
      {"sensors.a2.drift: {initial: 0, std: 50}", "a drift of 50 s/s is given"},
      {"sensors.a2.drift: {initial: 0, std: 50 ms}", "drift.std"},
      {"sensors.rack.drift: {initial: 0, std: 50 ppm}", "there is no sensor 'rack'"},
      {"sensors.rack.drift: {initial: 0, std: 50 ppm, applies_to: [sensors.a2.drift, sensors.a3.drift]}",
       "there is no sensor 'a3'"},
      {"sensors.rack.drift: {initial: 0, std: 50 ppm, applies_to: [sensors.a2.drift, sensors.x1.delay]}",
       "'sensors.x1.delay' is no drift of a sensor"},
      {"sensors.rack.noise: {initial: 1 mm, applies_to: [sensors.x1.noise]}", "a noise is given for several sensors"},
      {"sensors.a2.noise: {initial: 0}", "noise is searched by its logarithm"},
      {"sensors.a2.gain: {initial: 1, bounds: [0, 2]}", "gain.bounds has no meaning here"},
      {"sensors.a2.gain: {initial: 1, random_walk: 0.1}", "gain.random_walk has no meaning here"},
      {"sensors.a2.offset: {initial: 0}", "it has no `std`"},
      {"sensors.a2.colour: {initial: 1}", "there is no parameter 'sensors.a2.colour'"},
  };
  for (const auto& [unknown, part] : cases) {
    const std::string problems = problems_of(with(unknown));
    EXPECT_NE(problems.find(part), std::string::npos) << unknown << "\n" << problems;
  }
  EXPECT_EQ(problems_of(with("sensors.a2.offset: {initial: 0, std: 1, random_walk: 0.1}")), "");
}

}  // namespace
}  // namespace kalfem::test
