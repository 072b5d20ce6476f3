// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "casefile/probes.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/identified_case.hpp"
#include "kalfem/study/study.hpp"

/// The identified case holds the values in the places of their parameters, and reads back.
namespace kalfem::wiring {
namespace {

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

Study read_back(const IdentifiedCase& identified) {
  return load_study(write_file("identified.yaml", identified.yaml).string());
}

Sections chain_case(const std::string& unknowns) {
  return {{"substructures",
           "{w: {masses: {w: 1.5}}, s: {masses: {m: {x: 2 kg, rz: 0.1}}, chain: {masses: 3, mass: 1, stiffness: 800}, "
           "springs: [{name: k, from: 1, to: ground, stiffness: 900, damping: 2}, {from: m.x, to: 1, stiffness: 500}, "
           "{from: m.rz, to: ground, stiffness: 5}], damping: {modal: [1 %, 2 %]}}}"},
          {"connectors", "{c: {from: w.w, to: s.2, law: linear, parameters: {k: 0.5 kN/m}}}"},
          {"excitation", "{f: {force: w.w, sine: {amplitude: 1, frequency: 2}}}"},
          {"sensors", "{y: {acceleration: s.3, noise: 2 %}}"},
          {"estimate", "{unknown: {" + unknowns + "}}"}};
}

TEST(IdentifiedCase, HasTheValuesOfLumpedPartsAndConnectorsInTheirPlaces) {
  const Study study = study_of(lumped_case(
      chain_case("c.k: {initial: 400, std: 100 N/m}, c.c: {initial: 1, std: 50 %}, s.k.stiffness: {initial: 800}, "
                 "s.2-3.stiffness: {initial: 700}, s.m.rz.mass: {initial: 0.2}, s.3.mass: {initial: 2}, "
                 "s.damping.modal.2: {initial: 1 %}, s.k.damping: {initial: 1}")));
  const double third = 1.0 / 3.0;
  const auto identified =
      identified_case(study, {.unknowns = {500.0 + third, 3.25, 901.0, 801.0, 0.125, 1.5, 0.015, 2.5}});
  EXPECT_TRUE(identified.notes.empty());
  const Study found = read_back(identified);
  const auto& connector = found.structure->parts.connectors.front();
  EXPECT_EQ(connector.parameters[0], 500.0 + third);  // every digit
  EXPECT_EQ(connector.parameters[1], 3.25);           // the case left it at its default
  const auto& part = found.structure->parts.substructures.back();
  ASSERT_EQ(part.masses.size(), 5U);
  EXPECT_EQ(part.masses[0].mass, 2.0);
  EXPECT_EQ(part.masses[1].mass, 0.125);
  EXPECT_EQ(part.masses[4].mass, 1.5);
  EXPECT_EQ(part.masses[3].mass, 1.0);
  ASSERT_EQ(part.springs.size(), 5U);
  EXPECT_EQ(part.springs[0].stiffness, 800.0);  // 1-2
  EXPECT_EQ(part.springs[1].stiffness, 801.0);  // 2-3
  EXPECT_EQ(part.springs[2].name, "k");
  EXPECT_EQ(part.springs[2].stiffness, 901.0);
  EXPECT_EQ(part.springs[2].damping, 2.5);
  EXPECT_EQ(part.modal_damping, (std::vector<double>{0.01, 0.015}));
  // The next run starts at the values, with priors as before: 100 N/m, 50 % of 3.25, and the default of 50 %.
  const auto& unknowns = found.problem->settings.unknowns;
  EXPECT_EQ(unknowns[0].initial, 500.0 + third);
  near(unknowns[0].deviation, 100.0);
  EXPECT_EQ(unknowns[1].initial, 3.25);
  near(unknowns[1].deviation, 1.625);
  near(unknowns[2].deviation, 450.5);
}

TEST(IdentifiedCase, HasOneRatioForAllModesAndASharedValueInEveryPlace) {
  const Study study = study_of(lumped_case(
      chain_case("all: {initial: 700, applies_to: [s.1-2.stiffness, s.2-3.stiffness]}, f: {initial: 0.1, std: 0.1, "
                 "applies_to: [s.damping.mass_factor]}")));
  const auto& part = read_back(identified_case(study, {.unknowns = {777.0, 0.25}})).structure->parts.substructures[1];
  EXPECT_EQ(part.springs[0].stiffness, 777.0);
  EXPECT_EQ(part.springs[1].stiffness, 777.0);
  EXPECT_EQ(part.rayleigh.mass_factor, 0.25);
}

/// What the user's file does not say is not said: the defaults may change.
TEST(IdentifiedCase, KeepsToTheKeysOfTheUser) {
  const Study study = study_of(lumped_case(chain_case("c.c: {initial: 1, std: 50 %}")));
  const auto text = identified_case(study, {.unknowns = {3.0}}).yaml;
  EXPECT_TRUE(holds(text, "chain:")) << text;  // nothing of it was identified
  EXPECT_TRUE(holds(text, "c: 3 N s/m")) << text;
  EXPECT_FALSE(holds(text, "passes")) << text;
  EXPECT_FALSE(holds(text, "stiffness_factor")) << text;
  EXPECT_FALSE(holds(text, "transform")) << text;
}

/// A default transform follows the sign of the initial value; that of the run stays.
TEST(IdentifiedCase, KeepsTheTransformAndStaysBetweenBounds) {
  const Study study = study_of(
      lumped_case(chain_case("c.c: {initial: 0, std: 2 N s/m}, c.k: {initial: 400, bounds: [100 N/m, 500 N/m]}")));
  const Study found = read_back(identified_case(study, {.unknowns = {3.0, 500.0}}));
  const auto& unknowns = found.problem->settings.unknowns;
  EXPECT_EQ(unknowns[0].transform.kind, TransformKind::none);
  near(unknowns[0].deviation, 2.0);
  EXPECT_LT(unknowns[1].initial, 500.0);
  EXPECT_NEAR(unknowns[1].initial, 500.0, 1e-6);
}

TEST(IdentifiedCase, HasTheValuesOfFiniteElementsAndNamesThoseWithoutAPlace) {
  const Study study = study_of(beam_case(
      {{"substructures", "{b: {finite_elements: {" + beam_elements("masses: {lump: {at: tip, mass: 0.5 kg}}") + "}}}"},
       {"update",
        "{parameters: {b.steel.youngs_modulus: {}, b.steel.density: {std: 10 %}, b.lump.mass: {}, "
        "b.bar.bending_y: {}}, compare: {f: {modes: b, frequencies: [20]}}}"}}));
  const auto identified = identified_case(study, {.updated = {2.0e11, 7800.5, 0.75, 1.25}});
  ASSERT_EQ(identified.notes.size(), 1U);
  EXPECT_TRUE(holds(identified.notes[0], "'b.bar.bending_y', found to be 1.25, has no key")) << identified.notes[0];
  EXPECT_TRUE(identified.yaml.starts_with("# " + identified.notes[0] + "\n")) << identified.yaml;
  const Study found = read_back(identified);
  const auto& elements = found.structure->finite_elements.front().part->elements;
  EXPECT_EQ(elements.materials.at("steel").youngs_modulus, 2.0e11);
  EXPECT_EQ(elements.materials.at("steel").density, 7800.5);
  EXPECT_EQ(elements.masses.front().mass, 0.75);
  const auto& parameters = found.updating->parameters;
  EXPECT_EQ(parameters[0].initial, 2.0e11);
  EXPECT_EQ(parameters[3].initial, 1.25);
  near(parameters[1].deviation, study.updating->parameters[1].deviation);
}

TEST(IdentifiedCase, IsOfARunThatEstimatedAndIsUsable) {
  const Study study = study_of(estimated_case());
  StudyResults results = run(study, "estimate");
  ASSERT_TRUE(results.usable());
  ASSERT_TRUE(results.identified.has_value());
  const double estimate =
      results.get<EstimationOutcome>().result.unknowns.mean(0, results.get<EstimationOutcome>().result.nis.size() - 1);
  const auto& found = read_back(*results.identified).problem->settings.unknowns.front();
  EXPECT_EQ(found.initial, estimate);
  EXPECT_FALSE(run(study, "simulate").identified.has_value());
}

}  // namespace
}  // namespace kalfem::wiring
