// SPDX-License-Identifier: Apache-2.0
#include "casefile/case_run.hpp"

#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"

// Excitations that the filter does not know: their estimate against the signal that drives the simulation, and cases
// where nothing can be learned of them.

namespace kalfem::test {
namespace {

/// Rogers' Duffing oscillator; its force is known to the simulation only.
const std::string duffing = R"(kalfem: 1
substructures:
  body: {masses: {x: 1 kg}, springs: [{name: k, from: ground, to: x, stiffness: 10 kN/m, damping: 20 N s/m}]}
connectors:
  cubic: {from: body.x, to: body.ground, law: cubic, parameters: {k3: 1e9}}
excitation:
  push: {force: body.x, random: {rms: 10 N, band: [1, 100 Hz], seed: 3}, unknown: {std: 10 N, correlation_time: 8 ms, smoothness: 5/2}}
sensors:
  a: {acceleration: body.x, noise: 1 %}
  x: {displacement: body.x, noise: 1 %}
simulate: {duration: 3 s, sample_rate: 2048 Hz}
estimate: {settle: 0.5 s}
)";

/// Normalised mean square error [%].
double nmse(double nrmse) { return 100.0 * nrmse * nrmse; }

double error_of(const StudyResults& results, const std::string& point, ObservedQuantity quantity) {
  return find_quantity(results.get<EstimationOutcome>().points, point, quantity)->nrmse.value();
}

TEST(UnknownInputs, ForceOfADuffingOscillatorFollowsFromItsMotion) {
  const auto results = results_of(duffing);
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto& force = results.get<EstimationOutcome>().inputs.at(0);
  EXPECT_EQ(force.input.unit, "N");
  EXPECT_LT(nmse(force.nrmse.value()), 0.5);
  EXPECT_LT(nmse(error_of(results, "body.x", ObservedQuantity::displacement)), 0.5);
  EXPECT_LT(nmse(error_of(results, "body.x", ObservedQuantity::velocity)), 0.5);
  EXPECT_GT(force.coverage.value(), 0.85);
}

TEST(UnknownInputs, EveryFilterFindsTheSameForce) {
  const std::string shorter = changed(changed(duffing, "3 s", "1 s"), "0.5 s}", "0.5 s, filter: FILTER}");
  const auto force = [&](const std::string& filter) {
    return results_of(changed(shorter, "FILTER", filter)).get<EstimationOutcome>().inputs.at(0).mean;
  };
  const Eigen::VectorXd expected = force("partially_linear_ukf");
  for (const char* filter : {"partially_linear_ukf_square_root", "ukf", "ukf_square_root", "ekf"})
    EXPECT_LT(difference(force(filter), expected), 0.05) << filter;  // they differ in the cubic spring's moments
}

/// Two storeys on a ground; @ stands for the excitation.
const std::string frame = R"(kalfem: 1
substructures:
  s:
    masses: {1: 2 kg, 2: 1 kg}
    springs:
      - {name: low, from: ground, to: 1, stiffness: 8 kN/m, damping: 20}
      - {name: high, from: 1, to: 2, stiffness: 5 kN/m, damping: 10}
excitation:
  quake: {@}
sensors:
  a1: {acceleration: s.1, noise: 0.2 %}
  a2: {acceleration: s.2, noise: 0.2 %}
simulate: {duration: 4 s, sample_rate: 500 Hz, tolerance: 1e-4}
estimate: {settle: 1 s}
)";

TEST(UnknownInputs, GroundMotionsOfEveryKindAreEstimated) {
  const std::string signal = ", random: {rms: RMS, band: [1, 20 Hz], seed: 4}, unknown: {std: RMS, correlation_time: ";
  for (const auto& [target, rms, time, most] : {std::tuple{"base_displacement: s.ground", "2 mm", "20 ms", 0.25},
                                                std::tuple{"base_acceleration: s.ground", "3 m/s^2", "20 ms", 0.25},
                                                std::tuple{"base_acceleration: all", "3 m/s^2", "20 ms", 0.25}}) {
    const std::string excitation = changed(changed(std::string(target) + signal + time + "}", "RMS", rms), "RMS", rms);
    const auto results = results_of(changed(frame, "@", excitation));
    ASSERT_TRUE(results.complete()) << results.failure;
    const auto& ground = results.get<EstimationOutcome>().inputs.at(0);
    EXPECT_LT(ground.nrmse.value(), most) << target;
    EXPECT_GT(ground.coverage.value(), 0.8) << target;
    EXPECT_LT(error_of(results, "s.2", ObservedQuantity::acceleration), 0.05) << target;
  }
}

/// The force acts on the lower mass; the stiffness above it is in the equation of the upper one, where no force is
/// unknown.
TEST(UnknownInputs, ParametersAreEstimatedBeside) {
  const std::string force =
      "force: s.1, random: {rms: 10 N, band: [1, 50 Hz], seed: 3}, unknown: {std: 10 N, correlation_time: 8 ms}";
  const auto results = results_of(changed(changed(frame, "@", force), "settle: 1 s",
                                          "settle: 1 s, unknown: {s.high.stiffness: {initial: 6 kN/m, std: 20 %}}"));
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto& [mean, deviation] = results.get<EstimationOutcome>().result.unknowns;
  const double stiffness = mean(0, mean.cols() - 1), band = 3.0 * deviation(0, mean.cols() - 1);
  EXPECT_NEAR(stiffness, 5e3, std::max(50.0, band));
  EXPECT_LT(band, 150.0);
  EXPECT_LT(results.get<EstimationOutcome>().inputs.at(0).nrmse.value(), 0.2);
}

/// Each with what it must say.
TEST(UnknownInputs, CasesThatCannotWorkAreRefused) {
  const auto quake = [](const std::string& text) { return changed(frame, "@", text); };
  const std::string sine = "sine: {amplitude: 1 mm, frequency: 3}, ";
  const auto said = [](const std::string& text, const std::string& expected) {
    const std::string found = problems_of(text);
    EXPECT_NE(found.find(expected), std::string::npos) << "expected: " << expected << "\nfound: " << found;
  };
  said(quake("base_displacement: s.ground"), "no signal");
  said(quake("base_displacement: s.ground, unknown: {std: 1 mm}"), "has no signal, but the case has `simulate`");
  said(quake("base_displacement: s.ground, " + sine + "unknown: {std: 1 mm, smoothness: 1/2}"), "has no rate");
  said(quake("base_displacement: s.ground, " + sine + "unknown: {random_walk: 1 mm}"), "a random walk has no rate");
  said(quake("base_displacement: s.ground, " + sine + "unknown: {std: 1 mm, correlation_time: 1 ms}"),
       "shorter than the sample interval");
  said(quake("base_displacement: s.ground, " + sine + "unknown: {std: 0 mm}"), "standard deviation is 0");
  said(quake("base_displacement: s.ground, " + sine + "unknown: {}"), "has no size");
  said(quake("base_displacement: s.ground, " + sine + "unknown: {random_walk: 1 mm, smoothness: 1/2}"),
       "no smoothness");
  const std::string force = "force: s.1, sine: {amplitude: 1 N, frequency: 3}, unknown: {std: 1 N}";
  said(quake(force + "}\n  twin: {" + force), "cannot tell the unknown excitations apart");
  const std::string other = "force: s.2, sine: {amplitude: 1 N, frequency: 3}, unknown: {std: 1 N}";
  said(quake(force + "}\n  two: {" + other + "}\n  three: {" + other), "3 excitations are unknown");
  said(changed(quake(force), "estimate: {settle: 1 s}\n", ""), "the case has no `estimate`");
  said(quake(force + "}\n  late: {force: s.2, delayed: {input: quake, delay: 0.1}"), "its repetition is too");
  // Two sensors and two forces that differ can be told apart.
  EXPECT_EQ(problems_of(quake(force + "}\n  two: {" + other)), "");
}

TEST(UnknownInputs, OneThatNoSensorAnswersToIsRefused) {
  const std::string text = changed(
      changed(frame, "@", "force: far.x, sine: {amplitude: 1 N, frequency: 3}, unknown: {std: 1 N}"), "excitation:",
      "  far: {masses: {x: 1 kg}, springs: [{name: k, from: ground, to: x, stiffness: 10}]}\nexcitation:");
  EXPECT_NE(problems_of(text).find("no sensor answers to this input"), std::string::npos) << problems_of(text);
}

TEST(UnknownInputs, MeansThatAccelerationsDoNotShowAreTold) {
  const std::string force = "force: s.1, sine: {amplitude: 1 N, frequency: 3}, unknown: ";
  const auto warned = [&](const std::string& process, const std::string& sensor) {
    const auto study = study_of(changed(changed(frame, "@", force + process), "a1: {acceleration", "a1: {" + sensor));
    for (const auto& warning : study.warnings)
      if (warning.find("see only its changes") != std::string::npos) return warning;
    return std::string();
  };
  EXPECT_NE(warned("{random_walk: 1 N}", "acceleration").find("drifts without limit"), std::string::npos);
  EXPECT_NE(warned("{std: 1 N}", "acceleration").find("only as well as its std"), std::string::npos);
  EXPECT_EQ(warned("{std: 1 N}", "displacement"), "");
}

/// A force that hardly reaches its sensor through the noise is named in the verdict.
TEST(UnknownInputs, OneThatDrownsInNoiseIsNamed) {
  const auto results = results_of(
      changed(changed(changed(duffing, "noise: 1 %", "noise: 2000 %"), "noise: 1 %", "noise: 2000 %"), "3 s", "1 s"));
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto reasons = results.verdict.reasons();
  EXPECT_TRUE(std::ranges::any_of(
      reasons, [](const auto& reason) { return reason.code == "input_not_identified" && reason.subject == "push"; }));
  EXPECT_FALSE(results.get<EstimationOutcome>().hardly_known.empty());
}

}  // namespace
}  // namespace kalfem::test
