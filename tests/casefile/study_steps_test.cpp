// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "casefile/probes.hpp"
#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/prediction/outcome.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/steps/updating/compute.hpp"

/// The steps of a study together: what one hands to the next, where nothing but its place and time can go wrong.
namespace kalfem::wiring {
namespace {

using enum ObservedQuantity;
using Eigen::Index;
using Eigen::VectorXd;

/// A wheel and a row of three masses on it. The filter knows everything exactly: its estimates are the simulation but
/// for what the augmented model's step leaves out.
Sections exact_case(const Sections& changed = {}) {
  Sections sections = estimated_case(
      {{"substructures",
        "{w: {masses: {w: 1.5, v: 1}, springs: [{from: ground, to: w, stiffness: 2e3, damping: 5}, {from: w, to: "
        "v, stiffness: 900}]}, s: {masses: {a: 2, b: 3, c: 1}, springs: [{name: k, from: a, to: b, stiffness: "
        "800, damping: 2}, {name: m, from: b, to: c, stiffness: 700, damping: 1}], damping: {modal: 2 %}}}"},
       {"connectors", "{c: {from: w.w, to: s.a, law: linear, parameters: {k: 500, c: 3}}}"},
       {"excitation", "{f: {force: w.w, random: {rms: 5, band: [0.5, 8], fade_in: 0.3}}}"},
       {"sensors", "{yw: {acceleration: w.w, noise: 0.01}, yb: {acceleration: s.b, noise: 0.01}}"},
       {"simulate", "{duration: 2 s, sample_rate: 200 Hz, tolerance: 1e-5}"},
       {"estimate", "{unknown: {c.k: {initial: 500, std: 0.01}}, settle: 0}"},
       {"predict", "{substructure: s}"}});
  for (const auto& [key, text] : changed) sections[key] = text;
  return sections;
}

void expect_truth(const std::vector<PointQuantity>& points, double limit) {
  EXPECT_FALSE(points.empty());
  for (const auto& point : points) {
    ASSERT_TRUE(point.nrmse.has_value()) << point.point;
    EXPECT_LT(*point.nrmse, limit) << point.point << ", quantity " << int(point.quantity);
  }
}

// Found 2e-4 to 2.1e-3: the boundary's motion is straight between samples of a 200th of a second.
constexpr double step_error = 3e-3;

TEST(StudySteps, PredictWhatWasSimulated) {
  expect_truth(run(study_of(exact_case()), "predict").get<PredictionOutcome>().points, step_error);
}

TEST(StudySteps, PredictOverAnAcceleratedBase) {
  const auto results = run(study_of(exact_case({{"excitation",
                                                 "{e: {base_acceleration: {w.w: 1, w.v: 1, s.a: 1, s.b: 1, s.c: 1}, "
                                                 "random: {rms: 2, band: [0.5, 8], fade_in: 0.3}}}"}})),
                           "predict");
  expect_truth(results.get<PredictionOutcome>().points, step_error);
}

TEST(StudySteps, PredictFromMotion) {
  const std::string start =
      "s.b: {displacement: 20 mm, velocity: 0.3 m/s}, s.c: {velocity: -0.4 m/s}, w.w: {displacement: 5 mm}";
  const auto results = run(
      study_of(
          exact_case({{"simulate", "{duration: 1 s, sample_rate: 200 Hz, tolerance: 1e-5, initial: {" + start + "}}"},
                      {"estimate",
                       "{unknown: {c.k: {initial: 500, std: 0.01}}, settle: 0, "
                       "initial_state: {" +
                           start + "}}"}})),
      "predict");
  expect_truth(results.get<PredictionOutcome>().points, step_error);
  const auto* b = find_quantity(results.get<PredictionOutcome>().points, "s.b", displacement);
  EXPECT_NEAR(b->mean[0], 0.02, 1e-12);  // the prediction starts where the case says
}

// --- a record that begins late ---------------------------------------------------------------------------------------

/// Nothing moves before 0.35 s, so that the record from 0.3 s on begins at rest.
const std::string late_pulses =
    "{f: {force: w.w, impulse: {amplitude: 20 N, start: 0.35 s, duration: 0.1 s, shape: smooth}}, g: {force: s.c, "
    "impulse: "
    "{amplitude: 30 N, start: 0.4 s, duration: 0.12 s, shape: smooth}}}";

class LateRecord : public testing::Test {
protected:
  StudyResults whole = run(study_of(exact_case({{"excitation", late_pulses}})), "simulate");

  Study late(const Sections& more = {}) {
    const auto& clean = whole.get<SimulationOutcome>().reference.sensors;
    const auto column = [&](Index j) { return std::vector<double>(clean.row(j).begin(), clean.row(j).end()); };
    write_file("late.csv", csv_of(200.0, {{"yw", column(0)}, {"yb", column(1)}}));
    const std::string at_rest =
        "{unknown: {c.k: {initial: 500, std: 0.01}}, settle: 0, initial_state: {all: {displacement: 0}}}";
    Sections sections{{"excitation", late_pulses},
                      {"simulate", ""},
                      {"record", "{file: late.csv, start: 0.3 s, end: 1.3 s}"},
                      {"estimate", at_rest}};
    for (const auto& [key, text] : more) sections[key] = text;
    return study_of(exact_case(sections));
  }

  /// Of the whole simulation, from 0.3 s on.
  VectorXd truth(const std::string& point, ObservedQuantity quantity) {
    return find_quantity(whole.get<SimulationOutcome>().points, point, quantity)->mean.segment(60, 201);
  }
};

TEST_F(LateRecord, IsDrivenByWhatActedThen) {
  const auto study = late();
  EXPECT_EQ(study.record->record.samples(), 201);
  EXPECT_NEAR(study.record->record.start, 0.3, 1e-14);  // rounding, and the same samples below
  const auto filter = make_filter_run(study.problem, *study.augmented_model, record_of(study, {}));
  const auto signals = study.structure->signals[1]->sample(0.3, 0.005 / 4, 801);
  EXPECT_LT((filter.input.inputs.row(1).transpose() - signals.col(0).matrix()).norm(),
            1e-14 * signals.col(0).matrix().norm());
  const auto results = run(study, "estimate");
  for (const std::string point : {"w.v", "s.a", "s.c"}) {
    const auto* found = find_quantity(results.get<EstimationOutcome>().points, point, displacement);
    EXPECT_LT(nrmse(found->mean, truth(point, displacement)), 4e-4) << point;  // displacements: found 1e-4
  }
}

TEST_F(LateRecord, PredictsWithTheForcesOfThen) {
  const auto results = run(late(), "predict");
  for (const auto& point : results.get<PredictionOutcome>().points)
    EXPECT_LT(nrmse(point.mean, truth(point.point, point.quantity)), step_error) << point.point;
}

/// Both comparisons with a record are small at the true parameters, in parts of the noise of 0.01 m/s^2, and large
/// beside them.
TEST_F(LateRecord, IsComparedWithWhatHappenedThen) {
  for (const std::string comparison : {"simulation: all", "time_history: s"}) {
    const auto study = late({{"update", "{parameters: {s.k.stiffness: {}}, compare: {r: {" + comparison + "}}}"}});
    const auto residuals = all_comparisons(study, {});
    const auto size = [&](double k) {
      return rms(residuals.at(0).continuation_steps[0]->evaluate(VectorXd::Constant(1, k), false)->values);
    };
    EXPECT_LT(size(800.0), 1.5) << comparison;  // found .74 at most
    EXPECT_GT(size(700.0), 10.0) << comparison;
  }
}

/// What the filter learns from ends where the record's useful part does; the rest is for comparison alone.
TEST_F(LateRecord, IsNotLearntFromBeyondItsUse) {
  auto study = late();
  study.record->record.used = 120;
  const auto filter = make_filter_run(study.problem, *study.augmented_model, record_of(study, {}));
  const auto sees = [&](Index k) {
    VectorXd sample;
    filter.input.sample(k, sample);
    return sample.allFinite();
  };
  EXPECT_TRUE(sees(119));
  EXPECT_FALSE(sees(120));
  EXPECT_FALSE(sees(200));
  EXPECT_TRUE(filter.input.measured.values.allFinite());
}

/// Driven by the estimated motion of its boundary from a sample amid the motion on, behind the sensor's chain: at the
/// true parameters what is left is noise, in its own deviations; 100 to 300 values tell their rms to 7 %.
TEST(StudySteps, ADrivenHistoryIsNoiseAtTheTruth) {
  const std::string start = "s.b: {displacement: 20 mm, velocity: 0.3 m/s}, s.c: {velocity: -0.4 m/s}";
  for (const std::string settle : {"0", "0.5 s"})
    for (const std::string chain : {"", ", chain: [{butterworth: {order: 2, low_pass: 30 Hz}}]"}) {
      const auto study = study_of(exact_case(
          {{"sensors", "{yw: {acceleration: w.w, noise: 0.05}, yb: {acceleration: s.b, noise: 0.05" + chain + "}}"},
           {"simulate", "{duration: 1.5 s, sample_rate: 200 Hz, tolerance: 1e-5, initial: {" + start + "}}"},
           {"estimate",
            "{unknown: {c.k: {initial: 500, std: 0.01}}, settle: " + settle + ", initial_state: {" + start + "}}"},
           {"update", "{parameters: {s.k.stiffness: {}}, compare: {r: {time_history: s, sensors: yb}}}"}}));
      const auto results = run(study, "simulate");
      const auto residuals = all_comparisons(study, results);
      const auto values = residuals.at(0).continuation_steps[0]->evaluate(vector({800.0}), false)->values;
      EXPECT_NEAR(rms(values), 1.0, 0.1) << "settle " << settle << chain;
    }
}

// --- noise and sensors -----------------------------------------------------------------------------------------------

TEST(StudySteps, NoiseOfARecordIsAPartOfItsRms) {
  write_file("rms.csv", csv_of(100.0, {{"y", {3, -3, 3, -3, 3, -3}}, {"z", {1, 2, 1, 2, 1, 2}}}));
  const auto study = study_of(
      estimated_case({{"simulate", ""},
                      {"record", "{file: rms.csv}"},
                      {"sensors", "{z: {displacement: s.a, noise: 0.2}, y: {displacement: s.b, noise: 5 %}}"}}));
  const auto record = record_of(study, {});
  near(record.channels[0].noise, 0.2);
  near(record.channels[1].noise, 0.15);
  EXPECT_EQ(record.channels[1].unit, "m");
  const auto filter = make_filter_run(study.problem, *study.augmented_model, record);
  near(filter.input.noise(0, 0), 0.04);
  near(filter.input.noise(1, 1), 0.0225);
}

/// The augmented model's sensors stand behind their own measurement chains, which the case's simulation has too.
TEST(StudySteps, SensorsOfTheAugmentedModelHaveTheirChains) {
  const auto study = study_of(estimated_case({{"sensors",
                                               "{x: {displacement: s.a, noise: 0.1 mm}, y: {displacement: s.b, noise: "
                                               "0.1 mm, chain: [{butterworth: {order: 2, "
                                               "low_pass: 5 Hz}}, {gain: 3}]}}"}}));
  const auto results = run(study, "estimate");
  EXPECT_EQ(results.get<EstimationOutcome>().augmented_model->form().size(), 4 + 2);
  const auto plain =
      run(study_of(estimated_case({{"sensors",
                                    "{x: {displacement: s.a, noise: 0.1 mm}, y: {displacement: s.b, noise: "
                                    "0.1 mm}}"}})),
          "simulate");
  const VectorXd before = plain.get<SimulationOutcome>().reference.sensors.row(1),
                 behind = results.get<SimulationOutcome>().reference.sensors.row(1);
  // found 1e-3: straight lines between samples of a hundredth of a second
  EXPECT_LT(nrmse(behind, study.sensors[1].chain.filter(before, 100.0)), 3e-3);
  EXPECT_GT(nrmse(behind, before), 0.5);
}

/// Forces of connectors reach a sensor's chain at once, by what it measures: an acceleration beside a connector, and
/// the force itself. A consistent filter has a NIS of 2; 401 samples tell it to 0.1.
TEST(StudySteps, ConnectorForcesPassTheChainsOfTheAugmentedModel) {
  const auto results = run(
      study_of(
          exact_case({{"sensors",
                       "{yw: {acceleration: w.w, noise: 0.05, chain: [{butterworth: {order: 2, low_pass: 40 "
                       "Hz}}]}, fc: {force: c, noise: 0.05 N, chain: [{bessel: {order: 2, low_pass: 30 Hz}}]}}"},
                      {"connectors", "{c: {from: w.w, to: s.a, law: cubic, parameters: {k: 500, k3: 1e6, c: 3}}}"}})),
      "estimate");
  // 401 samples: two standard errors
  EXPECT_NEAR(results.get<EstimationOutcome>().consistency.mean_nis, 2.0, 0.2);
}

// --- the updating and what comes after it
// ------------------------------------------------------------------------------

const std::string updated_springs =
    "{parameters: {s.k.stiffness: {initial: 640}, s.m.stiffness: {initial: 810}}, compare: {f: {modes: s, frequencies: "
    "[2.9, 5.5], "
    "above: 0.5 Hz}}}";

TEST(StudySteps, TheAugmentedModelOfACaseThatUpdatesStartsAtTheFirstValues) {
  const auto study = study_of(exact_case({{"update", updated_springs}}));
  const auto& stiffness = study.augmented_model->model->system().stiffness;
  near(stiffness.coeff(2, 3), -640.0);
  near(stiffness.coeff(3, 4), -810.0);
  near(system_of(study).stiffness.coeff(2, 3), -800.0);
}

/// Estimation, prediction and modifications are of the structure that the updating ends at.
TEST(StudySteps, WhatFollowsAnUpdatingIsOfTheUpdatedStructure) {
  const auto study =
      study_of(exact_case({{"update", updated_springs},
                           {"modifications", "{m: {substructure: s, set: {k.damping: 2}, above: 0.5 Hz, modes: 2}}"}}));
  // The invented frequencies contradict the record, so that the estimates are refused in the end.
  const auto results = run_study(study, "update");
  EXPECT_FALSE(results.usable());
  const VectorXd values = results.get<UpdatingOutcome>().values;
  EXPECT_GT((values - vector({640, 810})).norm(), 10.0);
  const auto& system = results.get<EstimationOutcome>().augmented_model->system();
  near(system.stiffness.coeff(2, 3), -values[0], many_roundings);
  near(system.stiffness.coeff(3, 4), -values[1], many_roundings);
  // Two free frequencies and two springs: the updated structure has the measured ones, and so has a changed dashpot.
  // found 6e-7 and 1e-7 Hz: the search's tolerance, and a dashpot of 2 N s/m
  EXPECT_NEAR(results.get<ModificationsOutcome>().modifications.at(0).frequencies[0], 2.9, 2e-6);
  EXPECT_NEAR(results.get<ModificationsOutcome>().modifications.at(0).frequencies[1], 5.5, 5e-7);
}

/// One value that several parameters share is present under each of their names.
/// A group's own name may be that of an unknown of the filter, which is another parameter.
TEST(StudySteps, UpdatedValuesArePresentUnderAllNamesThatTheyApplyToAndNoOther) {
  const auto study = study_of(exact_case(
      {{"update",
        "{parameters: {both: {initial: 750, applies_to: [s.k.stiffness, s.m.stiffness]}, s.k.damping: {initial: 2}}, "
        "compare: {f: {modes: s, frequencies: [2.9, 5.5], above: 0.5 Hz}}}"}}));
  const auto present = present_values(*study.updating, vector({730, 3}));
  for (const std::string name : {"s.k.stiffness", "s.m.stiffness"}) near(present.at(name), 730.0);
  EXPECT_FALSE(present.contains("both"));
  near(present.at("s.k.damping"), 3.0);
}

/// A stiffer beam by an unknown of its material: the augmented model's superelement is reduced at the first guess, and
/// a value beside it in the same basis has the stiffness of that value.
TEST(StudySteps, LinearUnknownsOfFiniteElementsMoveTheirSuperelement) {
  const auto study = study_of(
      beam_case({{"estimate", "{unknown: {b.steel.youngs_modulus: {initial: 200 GPa, std: 5 %}}, settle: 0}"}}));
  const auto& linear = study.augmented_model->linear_unknowns;
  ASSERT_EQ(linear.initial.size(), 1u);
  near(linear.initial[0], 200e9);
  near(*study.augmented_model->true_parameters[0], 210e9);
  EXPECT_EQ(study.augmented_model->options.unknowns[0].transform.kind, TransformKind::log);
  const auto stiffness_at = [&](double value) {
    const auto parts = parts_at(*study.problem, linear, VectorXd::Constant(1, value));
    return Eigen::MatrixXd(parts.finite_elements.at(0).model->stiffness);
  };
  EXPECT_LT(relative_difference(stiffness_at(220e9), 1.1 * stiffness_at(200e9)), 1e-13);
  // The boundary's static stiffness is the tip's, 3 E I / L^3; shear takes 0.022 %.
  const double inertia = 3.14159265358979323846 * std::pow(0.02, 4) / 64;
  near(stiffness_at(200e9)(2, 2), 3 * 200e9 * inertia, 3e-4);
  EXPECT_LT(relative_difference(stiffness_at(200e9), Eigen::MatrixXd(study.augmented_model->model->system().stiffness)),
            1e-14);
}

}  // namespace
}  // namespace kalfem::wiring
