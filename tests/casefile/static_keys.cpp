// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "casefile/probes.hpp"

#include "kalfem/steps/modes/outcome.hpp"
#include "kalfem/steps/statics/outcome.hpp"
#include "kalfem/study/study.hpp"

/// Keys of static load cases.
namespace kalfem::wiring {
namespace {

/// The cantilever of beam_case, 1 m long, of a circle of 20 mm.
Study with_static(const std::string& cases, const std::string& more = "") {
  return study_of(beam_case({{"static", "{substructure: b, cases: {" + cases + "}" + more + "}"}}));
}

LoadCase load_case(const std::string& text) {
  return with_static("one: {" + text + "}").statics.value().analysis->cases().at(0);
}

StaticsOutcome solved(const std::string& cases, const std::string& more = "") {
  return run(with_static(cases, more), "static").get<StaticsOutcome>();
}

const std::string push = "forces: [{at: tip, force: [0, 0, 10 N]}]";

void substructure_and_cases() {
  const auto outcome = solved("one: {" + push + "}, two: {gravity: [0, 0, -9.81]}");
  EXPECT_EQ(outcome.substructure, "b");
  ASSERT_EQ(outcome.cases.size(), 2u);
  EXPECT_EQ(outcome.cases[0].solution.load_case, "one");
  EXPECT_EQ(outcome.cases[1].solution.load_case, "two");
}

void forces_and_moments() {
  const auto loads = load_case("forces: [{at: tip, force: [1 kN, 2, 3], moment: [4 N m, 5, 6]}]").loads;
  ASSERT_EQ(loads.size(), 1u);
  EXPECT_EQ(loads[0].node, 2);
  near(loads[0].force, vector({1000.0, 2.0, 3.0}));
  near(loads[0].moment, vector({4.0, 5.0, 6.0}));
  EXPECT_EQ(load_case("forces: [{at: 2, force: [0, 0, 1]}]").loads.at(0).node, 1);
  // Spread evenly over the two elements of the region: half of it at the node between them.
  const auto spread = load_case("forces: [{at: bar, force: [0, 0, 4 N]}]").loads;
  ASSERT_EQ(spread.size(), 3u);
  near(spread[0].force, vector({0.0, 0.0, 1.0}));
  near(spread[1].force, vector({0.0, 0.0, 2.0}));
  near(spread[1].moment.norm(), 0.0);
}

/// A square plate of 1 m in the x-y plane.
void pressures() {
  write_file("square.msh",
             "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 2 \"edge\"\n2 1 \"plate\"\n$EndPhysicalNames\n"
             "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n$Elements\n2\n1 1 2 2 1 1 2\n2 3 2 1 1 1 2 3 "
             "4\n$EndElements\n");
  const auto study = study_of(
      {{"kalfem", "1"},
       {"substructures",
        "{p: {finite_elements: {mesh: square.msh, materials: {steel: {youngs_modulus: 210 GPa, density: 8000}}, "
        "regions: {plate: {material: steel, shell: {thickness: 10 mm}}}, fixed: {clamp: {nodes: edge}}}}}"},
       {"static", "{substructure: p, cases: {one: {pressures: [{on: plate, pressure: 2 kPa}]}}}"}});
  const auto& pressure = study.statics->analysis->cases().at(0).pressures.at(0);
  EXPECT_EQ(pressure.faces.size(), 1u);
  near(pressure.pressure, 2000.0);
  near(run(study, "static").get<StaticsOutcome>().cases[0].solution.applied.force, vector({0.0, 0.0, -2000.0}),
       many_roundings);
}

void gravity() {
  near(load_case("gravity: [0, 1 m/s^2, -9.81]").gravity, vector({0.0, 1.0, -9.81}));
  const double weight = 7850.0 * std::numbers::pi * 1e-4 * 9.81;
  near(solved("one: {gravity: [0, 0, -9.81]}").cases[0].solution.reaction_sum.force, vector({0.0, 0.0, weight}), 1e-9);
}

void rotation() {
  const auto given = load_case("rotation: {axis: [0, 2, 0], about: [1 m, 0, 20 mm], speed: 3000 rpm}").rotation;
  ASSERT_TRUE(given);
  near(given->axis, vector({0.0, 2.0, 0.0}));
  near(given->about, vector({1.0, 0.0, 0.02}));
  near(given->speed, 100.0 * std::numbers::pi);
  const double mass = 7850.0 * std::numbers::pi * 1e-4;  // the middle of the beam stands 0.5 m from the axis
  near(solved("one: {rotation: {axis: [0, 0, 1], speed: 10}}").cases[0].solution.applied.force,
       vector({50.0 * mass, 0.0, 0.0}), 1e-9);
}

/// Out of the plane of rotation the beam's squared frequency is larger by that of the speed, but for its two elements.
void preload_of_rotation() {
  const auto study =
      study_of(beam_case({{"substructures", "{b: {finite_elements: {" + beam_elements() + "}, preload: spin}}"},
                          {"static",
                           "{substructure: b, cases: {spin: {rotation: {axis: [0, 0, 1], "
                           "speed: 100 rad/s}}}}"}}));
  const auto frequencies = run(study, "modes").get<ModesOutcome>().substructures.at(0).frequencies;
  const double lag = 2.0 * std::numbers::pi * frequencies[0], flap = 2.0 * std::numbers::pi * frequencies[1];
  near(flap * flap - lag * lag, 1e4, 0.15);
}

void imposed_displacements() {
  const auto imposed = load_case("displacements: {tip.z: 2 mm, mid.ry: 1 mrad}").imposed;
  ASSERT_EQ(imposed.size(), 2u);
  EXPECT_EQ(imposed[0].dof, (NodalDof{2, 2}));
  near(imposed[0].value, 0.002);
  EXPECT_EQ(imposed[1].dof, (NodalDof{1, 4}));
  near(imposed[1].value, 0.001);
}

/// The loads of a deck, in its units, beside those of the case.
void cases_of_the_deck() {
  write_file("bar.bdf",
             "GRID,1,,0.,0.,0.,,123456\nGRID,2,,1000.,0.,0.,,23456\nMAT1,1,2.1+5,,.3,7.85-9\nPROD,1,1,10.\n"
             "CROD,1,1,1,2\nFORCE,7,2,,10.,3.\nENDDATA\n");
  const auto with = [](const std::string& statics) {
    return study_of(beam_case(
        {{"substructures",
          "{b: {finite_elements: {deck: bar.bdf, units: {length: 1 mm, mass: 1 t, time: 1 s}, nodes: {tip: 2}}}}"},
         {"excitation", ""},
         {"sensors", ""},
         {"simulate", ""},
         {"static", "{substructure: b, " + statics + "}"}}));
  };
  const auto outcome = run(with("deck_cases: true, cases: {own: {forces: [{at: tip, force: [6 N, 0, 0]}]}}"), "static")
                           .get<StaticsOutcome>();
  ASSERT_EQ(outcome.cases.size(), 2u);
  EXPECT_EQ(outcome.cases[1].solution.load_case, "load7");
  near(outcome.cases[1].points.at(0).displacement[0], 30.0 / (2.1e11 * 1e-5));
  EXPECT_THROW(with("deck_cases: false"), InvalidInput);                                       // no case at all
  EXPECT_THROW(with("deck_cases: true, cases: {load7: {gravity: [0, 0, 1]}}"), InvalidInput);  // twice one name
  EXPECT_THROW(with_static("one: {" + push + "}", ", deck_cases: true"), InvalidInput);        // tables, not a deck
}

void reported_points() {
  EXPECT_EQ(solved("one: {" + push + "}").cases[0].points.size(), 3u);
  const auto points = solved("one: {" + push + "}", ", points: tip").cases[0].points;
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].name, "tip");
  const double inertia = std::numbers::pi * std::pow(0.02, 4) / 64.0;
  near(points[0].displacement[2], 10.0 / (3.0 * 2.1e11 * inertia), 1e-3);  // and a little shear
}

/// f / f_0 = sqrt(1 + N / N_cr) of a cantilever but for the change of its shape, N_cr = pi^2 E I / 4 L^2.
void preload() {
  const double inertia = std::numbers::pi * std::pow(0.02, 4) / 64.0,
               critical = std::pow(std::numbers::pi, 2) * 2.1e11 * inertia / 4.0;
  const auto frequency = [&](double force, bool is_preloaded) {
    const auto study = study_of(beam_case({{"substructures", "{b: {finite_elements: {" + beam_elements() + "}" +
                                                                 (is_preloaded ? ", preload: pull" : "") + "}}"},
                                           {"static", "{substructure: b, cases: {pull: {forces: [{at: tip, force: [" +
                                                          std::to_string(force) + ", 0, 0]}]}}}"}}));
    return run(study, "modes").get<ModesOutcome>().substructures.at(0).frequencies[0];
  };
  const double free = frequency(critical, false);
  near(frequency(0.5 * critical, true) / free, std::sqrt(1.5), 0.03);
  near(frequency(-0.5 * critical, true) / free, std::sqrt(0.5), 0.03);
  try {
    frequency(-1.1 * critical, true);
    ADD_FAILURE() << "a preload beyond buckling is accepted";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("beyond its buckling load"), std::string::npos) << error.what();
  }
}

}  // namespace

KeyChecks static_keys() {
  return {{"substructures.*.preload", preload},
          {"static.substructure", substructure_and_cases},
          {"static.deck_cases", cases_of_the_deck},
          {"static.cases.*.forces[].at", forces_and_moments},
          {"static.cases.*.forces[].force", forces_and_moments},
          {"static.cases.*.forces[].moment", forces_and_moments},
          {"static.cases.*.pressures[].on", pressures},
          {"static.cases.*.pressures[].pressure", pressures},
          {"static.cases.*.gravity", gravity},
          {"static.cases.*.rotation.axis", rotation},
          {"static.cases.*.rotation.about", rotation},
          {"static.cases.*.rotation.speed",
           [] {
             rotation();
             preload_of_rotation();
           }},
          {"static.cases.*.displacements", imposed_displacements},
          {"static.points", reported_points}};
}

}  // namespace kalfem::wiring
