// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <fstream>
#include <numbers>

#include "base/scratch_folder.hpp"
#include "casefile/case_run.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/steps/updating/outcome.hpp"
#include "kalfem/system/signals/deterministic.hpp"
#include "kalfem/system/signals/random_signal.hpp"

// Supports that are accelerated one by one, against supports that are displaced by the same motion and against a base
// that is accelerated as a whole.

namespace kalfem::test {
namespace {

using enum ObservedQuantity;

/// Two masses between two supports, with a nonlinear connector from one of the supports; @ stands for the excitation.
const std::string bridge = R"(kalfem: 1
substructures:
  beam:
    masses: {1: 2 kg, 2: 1 kg}
    grounds: [left, right]
    springs:
      - {name: l, from: left, to: 1, stiffness: 8 kN/m, damping: 20}
      - {name: m, from: 1, to: 2, stiffness: 5 kN/m, damping: 10}
      - {name: r, from: right, to: 2, stiffness: 9 kN/m, damping: 15}
    damping: {modal: 1 %}
connectors:
  stop: {from: beam.left, to: beam.2, law: cubic, parameters: {k: 1 kN/m, k3: 1e8}}
excitation:
@
sensors:
  a1: {acceleration: beam.1, noise: 1 %}
  a2: {acceleration: beam.2, noise: 1 %}
  d1: {displacement: {beam.1: 1, beam.left: -1}, noise: 1 %}
simulate: {duration: 4 s, sample_rate: 500 Hz, tolerance: 1e-4}
)";

std::string driven_by(const std::string& excitation) { return changed(bridge, "@", excitation); }

/// Largest difference of all that is simulated of points and connectors.
double difference_of_all(const StudyResults& found, const StudyResults& expected) {
  EXPECT_TRUE(found.complete()) << found.failure;
  EXPECT_TRUE(expected.complete()) << expected.failure;
  double largest = 0.0;
  for (const auto& quantity : expected.get<SimulationOutcome>().points)
    largest = std::max(largest, difference(simulated(found, quantity.point, quantity.quantity), quantity.mean));
  return largest;
}

/// A table of a derivative of signals, the second if not told otherwise, with an offset, 1 kHz.
void write_accelerations(const std::filesystem::path& file, const std::vector<SignalPtr>& motions, double offset,
                         int derivative = 2) {
  std::ofstream table(file);
  table.precision(17);
  table << "time";
  for (std::size_t i = 0; i < motions.size(); ++i) table << ",a" << i + 1;
  for (int k = 0; k <= 4000; ++k) {
    table << "\n" << 1e-3 * k;
    for (const auto& motion : motions) table << "," << motion->sample(1e-3 * k, 1.0, 1)(0, derivative) + offset;
  }
}

TEST(MultiSupport, AcceleratedSupportsAreDisplacedOnes) {
  const double w1 = 2.0 * std::numbers::pi * 3.0, w2 = 2.0 * std::numbers::pi * 5.0;
  const auto amplitude = [](double r, double w) { return std::to_string(-r * w * w) + " m/s^2"; };
  const auto displaced =
      results_of(driven_by("  a: {base_displacement: beam.left, sine: {amplitude: 2 mm, frequency: 3, fade_in: 0.5}}\n"
                           "  b: {base_displacement: beam.right, sine: {amplitude: 3 mm, frequency: 5, phase: 1}}"));
  const auto accelerated = results_of(driven_by(
      "  a: {base_acceleration: beam.left, sine: {amplitude: " + amplitude(2e-3, w1) +
      ", frequency: 3, fade_in: 0.5}}\n" +
      "  b: {base_acceleration: beam.right, sine: {amplitude: " + amplitude(3e-3, w2) + ", frequency: 5, phase: 1}}"));
  // the amplitudes are written with six digits behind the point
  EXPECT_LT(difference_of_all(accelerated, displaced), 1.5e-6);
  EXPECT_GT(simulated(displaced, "beam.2", acceleration).cwiseAbs().maxCoeff(), 1.0);
}

TEST(MultiSupport, OneIsAcceleratedBesideOneThatIsDisplaced) {
  const double w = 2.0 * std::numbers::pi * 3.0;
  const std::string right = "  b: {base_displacement: beam.right, random: {rms: 1 mm, band: [0.5, 20 Hz]}}\n";
  const auto displaced =
      results_of(driven_by(right + "  a: {base_displacement: beam.left, sine: {amplitude: 2 mm, frequency: 3}}"));
  const auto mixed = results_of(driven_by(right + "  a: {base_acceleration: beam.left, sine: {amplitude: " +
                                          std::to_string(-2e-3 * w * w) + " m/s^2, frequency: 3}}"));
  // the amplitude is written with six digits behind the point
  EXPECT_LT(difference_of_all(mixed, displaced), 1.2e-6);
}

/// Records of two supports: one swings and comes back, the other ends at another place.
TEST(MultiSupport, RecordedAccelerationsMoveTheSupportsAsTheyMoved) {
  const ScratchFolder folder("multi-support");
  write_accelerations(folder / "a.csv",
                      {make_pulse({.amplitude = 4e-3, .start = 0.5, .duration = 0.4, .shape = PulseShape::smooth}),
                       make_pulse({.amplitude = -3e-3, .start = 0.6, .duration = 0.5, .shape = PulseShape::smooth})},
                      0.0);
  const std::string file = "file: " + (folder / "a.csv").string() + ", drift: keep, channel: ";
  const auto recorded = results_of(driven_by("  a: {base_acceleration: beam.left, " + file + "a1}\n" +
                                             "  b: {base_acceleration: beam.right, " + file + "a2}"));
  const auto displaced = results_of(driven_by(
      "  a: {base_displacement: beam.left, impulse: {amplitude: 4 mm, start: 0.5, duration: 0.4, shape: smooth}}\n"
      "  b: {base_displacement: beam.right, impulse: {amplitude: -3 mm, start: 0.6, duration: 0.5, shape: smooth}}"));
  // the spline through 400 samples of the pulse's acceleration; the records converge to 1e-4
  EXPECT_LT(difference_of_all(recorded, displaced), 1e-6);
}

TEST(MultiSupport, AGeophoneMovesItsSupport) {
  const ScratchFolder folder("multi-support-velocity");
  const auto motion = make_random({.rms = 2e-3, .lower = 2.0, .upper = 20.0, .duration = 4.0});
  write_accelerations(folder / "v.csv", {motion}, 0.02, 1);  // 0.08 m after 4 s
  const std::string left =
      "  a: {base_velocity: beam.left, file: " + (folder / "v.csv").string() + ", channel: a1, unit: m/s";
  const auto found = study_of(driven_by(left + "}")).structure->signals[0]->sample(0.0, 1e-2, 401);
  const auto expected = motion->sample(0.0, 1e-2, 401);
  for (const int i : {0, 1, 2})
    EXPECT_LT((found - expected).col(i).abs().maxCoeff(), 0.01 * expected.col(i).abs().maxCoeff()) << i;
  // An input that refers to it has its motion.
  const auto both = study_of(driven_by(left + "}\n  b: {base_velocity: beam.right, delayed: {input: a, delay: 0}}"));
  EXPECT_LT((both.structure->signals[1]->sample(1.0, 1e-2, 201) - both.structure->signals[0]->sample(1.0, 1e-2, 201))
                .abs()
                .maxCoeff(),
            1e-12);
}

TEST(MultiSupport, AnAccelerometersOffsetDoesNotPullTheSupportsApart) {
  const ScratchFolder folder("multi-support-offset");
  const auto motion = make_random({.rms = 2e-3, .lower = 2.0, .upper = 20.0, .duration = 4.0});
  write_accelerations(folder / "a.csv", {motion}, 0.05);  // 0.4 m after 4 s
  const std::string left = "  a: {base_acceleration: beam.left, file: " + (folder / "a.csv").string() + ", channel: a1";
  const auto study = study_of(driven_by(left + "}"));
  ASSERT_EQ(study.warnings.size(), 1U);
  EXPECT_NE(study.warnings[0].find("excitation 'a': its acceleration is assumed to have an offset of 0.05"),
            std::string::npos)
      << study.warnings[0];
  EXPECT_NE(study.warnings[0].find("drift: keep"), std::string::npos);
  const auto found = study.structure->signals[0]->sample(0.0, 1e-2, 401), expected = motion->sample(0.0, 1e-2, 401);
  // found .0037: taking the offset out takes some of the motion
  EXPECT_LT((found - expected).col(0).abs().maxCoeff(), 0.01 * expected.col(0).abs().maxCoeff());
  const auto kept = study_of(driven_by(left + ", drift: keep}"));
  EXPECT_TRUE(kept.warnings.empty());
  EXPECT_NEAR(kept.structure->signals[0]->sample(4.0, 1.0, 1)(0, 0) - motion->sample(4.0, 1.0, 1)(0, 0), 0.4, 2e-6);
}

TEST(MultiSupport, SupportsThatMoveAlikeAreAnAcceleratedBase) {
  const std::string signal = "impulse: {amplitude: 3 m/s^2, start: 0.3, duration: 0.2, shape: smooth}}";
  const auto uniform = results_of(driven_by("  a: {base_acceleration: all, " + signal));
  const auto one = results_of(driven_by("  a: {base_acceleration: {beam.left: 1, beam.right: 1}, " + signal));
  const auto two = results_of(driven_by("  a: {base_acceleration: beam.left, " + signal + "\n" +
                                        "  b: {base_acceleration: beam.right, delayed: {input: a, delay: 0}}"));
  for (const auto* alike : {&one, &two}) {
    ASSERT_TRUE(alike->complete()) << alike->failure;
    for (const char* point : {"beam.1", "beam.2"})
      // the same equations by absolute and by relative motion, with their own references: found 2e-8
      EXPECT_LT(difference(simulated(*alike, point, acceleration), simulated(uniform, point, acceleration)), 2e-7);
    for (const auto quantity : {connector_deformation, connector_force})
      EXPECT_LT(difference(simulated(*alike, "stop", quantity), simulated(uniform, "stop", quantity)), 2e-7);
    // motion is absolute with grounds by name, and relative to the base with `all`
    EXPECT_GT(simulated(*alike, "beam.1", displacement).tail(1)[0], 0.5);
    // at rest again
    EXPECT_LT(std::abs(simulated(uniform, "beam.1", displacement).tail(1)[0]), 1e-12);
    EXPECT_LT(difference(alike->get<SimulationOutcome>().reference.sensors.row(2).transpose(),
                         uniform.get<SimulationOutcome>().reference.sensors.row(2).transpose()),
              2e-7);
  }
  const auto half = results_of(driven_by("  a: {base_acceleration: {beam.left: 1, beam.right: 0.5}, " + signal));
  EXPECT_GT(difference(simulated(half, "beam.2", acceleration), simulated(uniform, "beam.2", acceleration)), 0.1);
}

/// The filter and the open loop are driven by the same motion of the supports.
TEST(MultiSupport, TheFilterFindsAStiffnessUnderAcceleratedSupports) {
  const std::string estimate = R"(estimate:
  unknown: {stop.k: {initial: 2 kN/m, std: 1 kN/m}, beam.l.stiffness: {initial: 7 kN/m, std: 1 kN/m}}
  settle: 0.5 s
  estimate_initial_state: true
  substeps: 16  # at 500 Hz four parts a sample leave a bias of several of these small deviations
)";
  const auto results =
      results_of(driven_by("  a: {base_acceleration: beam.left, random: {rms: 4 m/s^2, band: [1, 20 Hz], seed: 2}}\n"
                           "  b: {base_acceleration: beam.right, random: {rms: 4 m/s^2, band: [1, 20 Hz], seed: 3}}") +
                 estimate);
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto& unknowns = results.get<EstimationOutcome>().result.unknowns;
  const Eigen::Index last = unknowns.mean.cols() - 1;
  // four deviations of one record; found 2.0 and .8 of one
  EXPECT_NEAR(unknowns.mean(0, last), 1000.0, 4.0 * unknowns.deviation(0, last));
  EXPECT_NEAR(unknowns.mean(1, last), 8000.0, 4.0 * unknowns.deviation(1, last));
  EXPECT_GT(unknowns.deviation(1, last), 0.3);
  EXPECT_LT(unknowns.deviation(1, last), 1.3);  // found .66
  // 1750 samples of three channels: two standard errors are .12
  EXPECT_NEAR(results.get<EstimationOutcome>().consistency.mean_nis, 3.0, 0.13);
  // found .010
  for (const double error : results.get<EstimationOutcome>().open_loop_nrmse) EXPECT_LT(error, 0.03);
}

/// An updating by the simulation of the whole is driven as the record is.
TEST(MultiSupport, TheSimulationOfAnUpdatingIsDrivenAlike) {
  const auto results = results_of(
      changed(driven_by("  a: {base_acceleration: beam.left, sweep: {amplitude: 4 m/s^2, from: 2, to: 20}}\n"
                        "  b: {base_acceleration: beam.right, sine: {amplitude: 2 m/s^2, frequency: 4, fade_in: 0.5}}"),
              "duration: 4 s", "duration: 2 s") +
          "update: {parameters: {beam.m.stiffness: {initial: 4 kN/m, std: 20 %}}, compare: {record: {simulation: "
          "all}}}\n",
      "update");
  ASSERT_TRUE(results.complete()) << results.failure;
  EXPECT_NEAR(results.get<UpdatingOutcome>().values[0], 5000.0, 10.0);    // found 3
  EXPECT_NEAR(results.get<UpdatingOutcome>().residual_final, 1.0, 0.05);  // found .005
}

/// A sensor of the motion against a ground does not tell where the structure is, but for the ground's own motion.
TEST(MultiSupport, AStartFromTheRecordAddsTheGroundsMotion) {
  const auto text = changed(
      changed(driven_by("  a: {base_displacement: beam.left, sine: {amplitude: 5 mm, frequency: 2, phase: 1.5707963}}"),
              "sensors:\n", "sensors:\n  d2: {displacement: {beam.2: 1, beam.left: -1}, noise: 1 %}\n"),
      "duration: 4 s,", "duration: 1 s, initial: {beam.1: {displacement: 4 mm}, beam.2: {displacement: 3 mm}},");
  const auto results = results_of(
      text +
      "estimate: {unknown: {stop.k: {initial: 900, std: 100}}, initial_state_from_record: true, settle: 0.2 s}\n");
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto& start = results.get<EstimationOutcome>().augmented_model->options().prior.mean;
  // found 5e-6 and 7e-6: the noise of one sample, 1 %
  EXPECT_NEAR(start.displacement[0], 4e-3, 2e-5);
  EXPECT_NEAR(start.displacement[1], 3e-3, 2e-5);
}

struct Contradiction {
  const char* name;
  std::string excitation;
  std::string message;  ///< "" where the case is right
};

void PrintTo(const Contradiction& each, std::ostream* out) { *out << each.excitation; }

class Excitations : public testing::TestWithParam<Contradiction> {};

TEST_P(Excitations, AreReportedWithTheirLine) {
  const std::string found = problems_of(driven_by(GetParam().excitation));
  if (GetParam().message.empty()) {
    EXPECT_EQ(found, "");
  } else {
    EXPECT_NE(found.find(GetParam().message), std::string::npos) << found;
  }
}

const std::string sine = "sine: {amplitude: 1 m/s^2, frequency: 3}";
const std::string sine_v = "sine: {amplitude: 1 mm/s, frequency: 3}";
const std::string sine_m = "sine: {amplitude: 1 mm, frequency: 3}";
const std::string left = "  a: {base_acceleration: beam.left, " + sine;

INSTANTIATE_TEST_SUITE_P(
    MultiSupport, Excitations,
    testing::Values(
        Contradiction{"two_accelerations", left + "}\n  b: {base_acceleration: beam.left, " + sine + "}",
                      "case.yaml:15: excitation.b.base_acceleration: the ground 'beam.left' is driven twice"},
        Contradiction{"acceleration_and_displacement", left + "}\n  b: {base_displacement: beam.left, " + sine_m + "}",
                      "case.yaml:15: excitation.b.base_displacement: the ground 'beam.left' is driven twice"},
        Contradiction{"in_a_sum", left + "}\n  b: {base_acceleration: {beam.right: 1, beam.left: 1}, " + sine + "}",
                      "case.yaml:15: excitation.b.base_acceleration: the ground 'beam.left' is driven twice"},
        Contradiction{"different_grounds", left + "}\n  b: {base_displacement: beam.right, " + sine_m + "}", ""},
        Contradiction{"gravity_beside", left + "}\n  g: {base_acceleration: all, constant: 9.81 m/s^2}", ""},
        Contradiction{"grounds_and_masses", "  a: {base_acceleration: {beam.left: 1, beam.1: 1}, " + sine + "}",
                      "case.yaml:14: excitation.a.base_acceleration lists both grounds and degrees of freedom"},
        Contradiction{"no_such_ground", "  a: {base_acceleration: beam.lift, " + sine + "}",
                      "case.yaml:14: excitation.a.base_acceleration: there is no point 'beam.lift' (did you mean "
                      "'beam.left'?)"},
        Contradiction{"a_mass_is_displaced", "  a: {base_displacement: beam.1, " + sine_m + "}",
                      "case.yaml:14: excitation.a.base_displacement: 'beam.1' is not a ground"},
        Contradiction{"nothing_attached", "  a: {base_acceleration: beam.ground, " + sine + "}",
                      "case.yaml:14: excitation.a.base_acceleration: nothing is attached to the ground 'beam.ground'"},
        Contradiction{"nothing_named", "  a: {base_acceleration: {}, " + sine + "}",
                      "case.yaml:14: excitation.a.base_acceleration lists no ground"},
        Contradiction{"weight_of_all", "  a: {base_acceleration: {all: 2}, " + sine + "}",
                      "case.yaml:14: excitation.a.base_acceleration: the weight of 'all' is 2"},
        Contradiction{"no_weight", "  a: {base_acceleration: {beam.left: 0}, " + sine + "}",
                      "case.yaml:14: excitation.a.base_acceleration: the weight of 'beam.left' is 0"},
        Contradiction{"unit", "  a: {base_acceleration: beam.left, " + sine_m + "}", "case.yaml:14"},
        Contradiction{"drift_of_a_displacement", "  a: {base_displacement: beam.left, drift: keep, " + sine_m + "}",
                      "case.yaml:14: excitation.a.drift has no effect here"},
        Contradiction{"drift_of_the_whole_base", "  a: {base_acceleration: all, drift: keep, " + sine + "}",
                      "case.yaml:14: excitation.a.drift has no effect here"},
        Contradiction{"drift_of_an_impulse",
                      "  a: {base_acceleration: beam.left, drift: remove, impulse: {amplitude: 1 m/s^2}}",
                      "case.yaml:14: excitation.a.drift has no effect here"},
        Contradiction{"drift_of_a_follower",
                      left + "}\n  b: {base_acceleration: beam.right, drift: keep, delayed: {input: a, delay: 0.1}}",
                      "case.yaml:15: excitation.b.drift has no effect here"},
        Contradiction{"drift_kept", left + ", drift: keep}", ""},
        Contradiction{"follows_another_unit",
                      left + "}\n  b: {base_displacement: beam.right, delayed: {input: a, delay: 0.1}}",
                      "case.yaml:15: excitation.b.delayed.input: input 'a' is in m/s^2"},
        Contradiction{"follows_itself", "  b: {base_displacement: beam.right, delayed: {input: b, delay: 0.1}}",
                      "case.yaml:14: excitation.b.delayed.input: there is no input 'b' above this one"},
        Contradiction{"velocity_that_lasts", "  a: {base_velocity: beam.left, constant: 1 mm/s}",
                      "case.yaml:14: excitation.a: a constant velocity moves the ground for good"},
        Contradiction{"pulse_of_a_velocity", "  a: {base_velocity: beam.left, impulse: {amplitude: 1 mm/s}}",
                      "case.yaml:14: excitation.a: an impulse moves the ground for good"},
        Contradiction{"unit_of_a_velocity", "  a: {base_velocity: beam.left, " + sine + "}", "case.yaml:14"},
        Contradiction{"drift_of_a_velocity", "  a: {base_velocity: beam.left, drift: keep, " + sine_v + "}",
                      "case.yaml:14: excitation.a.drift has no effect here"},
        Contradiction{"velocity_of_a_mass", "  a: {base_velocity: beam.1, " + sine_v + "}",
                      "case.yaml:14: excitation.a.base_velocity: 'beam.1' is not a ground"},
        Contradiction{"road_as_acceleration", "  a: {base_acceleration: beam.left, road: {class: C, speed: 20}}",
                      "case.yaml:14: excitation.a: a road profile is a displacement [m]"}),
    [](const auto& each) { return each.param.name; });

TEST(MultiSupport, EveryProblemIsReportedAtOnce) {
  const auto found = problems_of(changed(driven_by(left + "}\n  b: {base_displacement: beam.left, " + sine_m + "}\n" +
                                                   "  c: {base_acceleration: beam.rigth, road: {class: C, speed: 10}}"),
                                         "tolerance: 1e-4", "tolerance: 1e-4, substeps: 4"));
  for (const char* part : {"case.yaml:15: excitation.b", "case.yaml:16: excitation.c.base_acceleration",
                           "case.yaml:16: excitation.c: a road", "case.yaml:21: simulate.substeps"})
    EXPECT_NE(found.find(part), std::string::npos) << part << "\n" << found;
}

TEST(MultiSupport, AWholeBaseMovesOnlyWhatFollowsItUnstrained) {
  // a rotation beside a translation: `all` would turn it by 1 rad as the base moves by 1 m
  const std::string lever = R"(kalfem: 1
substructures:
  bar:
    masses: {z: 2 kg, p: 0.1 kg}
    points: {end: {z: 1, p: 0.4}}
    springs: [{from: ground, to: z, stiffness: 1e4}, {from: ground, to: end, stiffness: 1e4}]
excitation:
  a: {base_acceleration: @, sine: {amplitude: 1 m/s^2, frequency: 3}}
sensors: {s: {acceleration: bar.z, noise: 1 %, relative: true}}
simulate: {duration: 1 s, sample_rate: 200 Hz}
)";
  const auto found = problems_of(changed(lever, "@", "all"));
  EXPECT_NE(found.find("case.yaml:8: "), std::string::npos) << found;
  EXPECT_NE(found.find("which deforms substructure 'bar'"), std::string::npos) << found;
  EXPECT_EQ(problems_of(changed(lever, "@", "{bar.z: 1}")), "");
  const auto relative = problems_of(changed(lever, "@", "bar.ground"));
  EXPECT_NE(relative.find("case.yaml:9: sensors.s.acceleration is relative to the accelerated base"), std::string::npos)
      << relative;
}

/// Relative to an accelerated base, the base's load on the unknown part of the mass is part of the linear system.
TEST(MultiSupport, AMassMayBeUnknownUnderAccelerationOfGroundsAndOfTheWholeBase) {
  const std::string estimate = "estimate: {unknown: {beam.2.mass: {initial: 0.9 kg, std: 0.1 kg}}, settle: 0.5 s}\n";
  const std::string signal = "random: {rms: 4 m/s^2, band: [1, 20 Hz]}}";
  for (const std::string moved : {"all", "{beam.left: 1, beam.right: 1}"}) {
    const auto results = results_of(driven_by("  a: {base_acceleration: " + moved + ", " + signal) + estimate);
    ASSERT_TRUE(results.complete()) << moved << ": " << results.failure;
    const auto& unknowns = results.get<EstimationOutcome>().result.unknowns;
    const Eigen::Index last = unknowns.mean.cols() - 1;
    // four deviations of one record; found .3 and .5 of one
    EXPECT_NEAR(unknowns.mean(0, last), 1.0, 4.0 * unknowns.deviation(0, last)) << moved;
    EXPECT_NEAR(results.get<EstimationOutcome>().consistency.mean_nis, 3.0, 0.13) << moved;
  }
}

}  // namespace
}  // namespace kalfem::test
