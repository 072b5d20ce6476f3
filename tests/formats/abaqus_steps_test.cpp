// SPDX-License-Identifier: Apache-2.0
// Steps of Abaqus and CalculiX decks: supports, temperatures, preload and loads that they change, and what they do not
// run.
#include <gtest/gtest.h>

#include "formats/abaqus_decks.hpp"
#include "formats/nastran_decks.hpp"
#include "kalfem/model/statics/statics.hpp"

namespace kalfem {
namespace {

Deck read(const std::string& text, const DeckOptions& options = {}) {
  return parse_abaqus(text, "deck.inp", {}, options);
}
Deck with_cases(const std::string& text) { return read(text, {.load_cases = true}); }

std::string problem_of(const std::string& text, bool load_cases = true) {
  try {
    read(text, {.load_cases = load_cases});
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

void expect_problem(const std::string& text, const std::string& part, bool load_cases = true) {
  const auto problem = problem_of(text, load_cases);
  EXPECT_NE(problem.find(part), std::string::npos) << part << " is not in: " << problem;
}

const DeckNote* note_of(const Deck& deck, const std::string& what) {
  const auto note = std::ranges::find(deck.notes, what, &DeckNote::what);
  return note == deck.notes.end() ? nullptr : &*note;
}

/// Two trusses of E A / L = 2e6 N/m along x, held at node 1 and across.
const std::string trusses = R"(*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 2., 0., 0.
*NSET, NSET=MID
2
*ELEMENT, TYPE=T3D2, ELSET=E
1, 1, 2
2, 2, 3
*MATERIAL, NAME=M
*ELASTIC
2.E11, 0.3
*DENSITY
7800.
*SOLID SECTION, ELSET=E, MATERIAL=M
1.E-5
*BOUNDARY
1, 1, 3
2, 2, 3
3, 2, 3
)";

std::string step(const std::string& loads, const std::string& options = "") {
  return "*STEP" + options + "\n*STATIC\n" + loads + "*END STEP\n";
}
std::string modes(const std::string& lines = "", const std::string& options = "") {
  return "*STEP" + options + "\n*FREQUENCY\n1\n" + lines + "*END STEP\n";
}

double along_x(const Deck& deck, std::size_t load_case, Eigen::Index node) {
  return solve_statics(deck.model, deck.load_cases.at(load_case)).displacements[6 * node];
}

TEST(AbaqusSteps, ForcesOfOneStepAddUp) {
  const auto deck = with_cases(trusses + step("*CLOAD\n3, 1, 1000.\n*CLOAD\n3, 1, 500.\n"));
  EXPECT_NEAR(along_x(deck, 0, 2), 0.0015, 1e-12);
}

/// With one more support the trusses are a fixed bar, without the one at node 1 they hang at node 2.
TEST(AbaqusSteps, HaveTheirOwnSupports) {
  const auto deck = with_cases(trusses + step("*CLOAD\n3, 1, 1000.\n") + step("*BOUNDARY\n2, 1, 1\n") +
                               step("*BOUNDARY, OP=NEW\nMID, 1, 3\n1, 2, 3\n3, 2, 3\n*CLOAD, OP=NEW\n1, 1, 400.\n"));
  ASSERT_EQ(deck.load_cases.size(), 3u);
  EXPECT_NEAR(along_x(deck, 0, 2), 1e-3, 1e-12);
  EXPECT_NEAR(along_x(deck, 1, 2), 0.5e-3, 1e-12);
  EXPECT_NEAR(along_x(deck, 1, 1), 0.0, 1e-15);
  EXPECT_NEAR(along_x(deck, 2, 0), 0.2e-3, 1e-12);
  EXPECT_NEAR(along_x(deck, 2, 2), 0.0, 1e-15);
}

/// A support that moves in axes of its own in one step, and does not hold in the next.
TEST(AbaqusSteps, HaveTheirOwnSupportsAlongTheAxesOfNodes) {
  const std::string turned = "*NSET, NSET=T\n3\n*TRANSFORM, NSET=T\n0., 1., 0., -1., 0., 0.\n";
  const auto deck =
      with_cases(trusses + turned + step("*BOUNDARY, OP=NEW\n1, 1, 3\n2, 2, 3\n3, 1, 1\n3, 3, 3\n3, 2, 2, -0.001\n") +
                 step("*BOUNDARY, OP=NEW\n1, 1, 3\n2, 2, 3\n3, 1, 1\n3, 3, 3\n*CLOAD\n3, 2, -1000.\n"));
  ASSERT_EQ(deck.load_cases.size(), 2u);
  EXPECT_NEAR(along_x(deck, 0, 2), 0.001, 1e-12);
  EXPECT_NEAR(along_x(deck, 1, 2), 0.001, 1e-12);
}

/// Modes have the supports of the step that asks for them: held at both ends, or at one.
TEST(AbaqusSteps, SupportsOfTheModesAreThoseOfTheirStep) {
  const auto frequency = [&](const std::string& steps) {
    return Matrices(read(trusses + steps).model).frequencies(1)[0];
  };
  const double free_end = frequency(""), fixed_end = frequency("*STEP\n*FREQUENCY\n1\n*BOUNDARY\n3, 1, 1\n*END STEP\n");
  EXPECT_GT(fixed_end, 1.5 * free_end);
  EXPECT_DOUBLE_EQ(frequency(step("*CLOAD\n3, 1, 1.\n") + modes("*BOUNDARY\n3, 1, 1\n")), fixed_end);
  EXPECT_DOUBLE_EQ(frequency(step("*BOUNDARY\n3, 1, 1\n") + modes("*BOUNDARY, OP=NEW\n1, 1, 3\n2, 2, 3\n3, 2, 3\n")),
                   free_end);
  EXPECT_DOUBLE_EQ(frequency(step("*CLOAD\n3, 1, 1.\n") + modes("*BOUNDARY, FIXED\n3, 1, 1\n")), fixed_end);
  EXPECT_TRUE(
      note_of(read(trusses + modes() + modes("*BOUNDARY\n3, 1, 1\n")), "supports that change between steps of modes"));
}

TEST(AbaqusSteps, FixedWhereASolutionLeftItIsRefused) {
  expect_problem(trusses + step("*CLOAD\n3, 1, 1.\n") + step("*BOUNDARY, FIXED\n3, 1, 1\n"), "*BOUNDARY, FIXED holds");
}

TEST(AbaqusSteps, WhatChangesTheModelIsMissing) {
  for (const std::string keyword : {"*CHANGE SOLID SECTION, ELSET=E, MATERIAL=M", "*MODEL CHANGE, TYPE=ELEMENT, REMOVE",
                                    "*CHANGE MATERIAL, NAME=M", "*SOME UNKNOWN KEYWORD"}) {
    const auto deck = read(trusses + step(keyword + "\nE\n"));
    const auto* note = note_of(deck, keyword.substr(0, keyword.find(',')));
    ASSERT_TRUE(note) << keyword;
    EXPECT_EQ(note->kind, DeckNoteKind::missing);
  }
  expect_problem(trusses + step("*SPRING, ELSET=E\n\n1.\n"), "*SPRING stands in step 1", false);
}

TEST(AbaqusSteps, WhatIsNotRunIsNamed) {
  for (const std::string kind :
       {"*BUCKLE", "*STEADY STATE DYNAMICS", "*DYNAMIC", "*COMPLEX FREQUENCY", "*MODAL DYNAMIC", "*HEAT TRANSFER",
        "*VISCO", "*RANDOM RESPONSE", "*RESPONSE SPECTRUM", "*GREEN", "*SUBSTRUCTURE GENERATE", "*SENSITIVITY",
        "*COUPLED TEMPERATURE-DISPLACEMENT", "*UNCOUPLED TEMPERATURE-DISPLACEMENT"}) {
    const auto deck = read(trusses + "*STEP\n" + kind + "\n1.\n*END STEP\n");
    ASSERT_TRUE(note_of(deck, kind)) << kind;
    EXPECT_NE(note_of(deck, kind)->consequence.find("not run"), std::string::npos) << kind;
  }
  EXPECT_FALSE(note_of(read(trusses + modes() + step("*CLOAD\n3, 1, 1.\n")), "*STATIC"));
}

TEST(AbaqusSteps, ScaledMassesAreTold) {
  const std::string scaled = "*STEP\n*DYNAMIC, EXPLICIT\n, 1.\n*FIXED MASS SCALING, ELSET=E, FACTOR=4.\n*END STEP\n";
  const auto* note = note_of(read(trusses + scaled), "*FIXED MASS SCALING");
  ASSERT_TRUE(note);
  EXPECT_EQ(note->kind, DeckNoteKind::changed);
  const auto deck = read(trusses + "*STEP\n*DYNAMIC, EXPLICIT\n.1, 1., 1.e-4\n*END STEP\n");
  ASSERT_TRUE(note_of(deck, "*DYNAMIC, EXPLICIT with a least time increment"));
}

// --- Preload ---------------------------------------------------------------------------------------------------------

const std::string abaqus = "*PREPRINT, ECHO=NO\n";  // a keyword that CalculiX does not have

TEST(AbaqusPreload, IsTheStaticStepBeforeAPerturbation) {
  const std::string pulled = trusses + step("*CLOAD\n3, 1, 1000.\n");
  for (const bool wanted : {true, false}) {
    const auto deck = read(pulled + modes("", ", PERTURBATION"), {.load_cases = wanted});
    ASSERT_TRUE(deck.preload);
    EXPECT_EQ(deck.preload->name, "step1");
    EXPECT_NEAR(nodal_forces(deck.model, *deck.preload)[6 * 2], 1000.0, 1e-9);
    EXPECT_EQ(deck.load_cases.size(), wanted ? 1u : 0u);
    EXPECT_FALSE(note_of(deck, "*CLOAD"));
  }
  EXPECT_FALSE(read(pulled + modes()).preload);
  EXPECT_FALSE(read(pulled).preload);
  EXPECT_FALSE(read(trusses + step("") + modes("", ", PERTURBATION")).preload);
  EXPECT_TRUE(note_of(read(pulled + modes()), "*CLOAD"));
}

TEST(AbaqusPreload, NeedsLargeDisplacementsInAbaqus) {
  const auto pulled = [](const std::string& options) {
    return abaqus + trusses + step("*CLOAD\n3, 1, 1000.\n", options);
  };
  EXPECT_TRUE(read(pulled(", NLGEOM=YES") + modes()).preload);
  const auto without = read(pulled("") + modes("", ", PERTURBATION"));
  EXPECT_FALSE(without.preload);
  ASSERT_TRUE(note_of(without, "modes behind a loaded static step"));
  EXPECT_NE(note_of(without, "modes behind a loaded static step")->consequence.find("preload: step1"),
            std::string::npos);
}

TEST(AbaqusPreload, HasTheLoadsOfAllStepsUpToIt) {
  const auto deck = read(trusses + step("*CLOAD\n3, 1, 1000.\n") + step("*CLOAD\n2, 1, 500.\n") +
                         modes("", ", PERTURBATION") + step("*CLOAD\n2, 1, 9.\n"));
  ASSERT_TRUE(deck.preload);
  EXPECT_EQ(deck.preload->name, "step2");
  EXPECT_NEAR(nodal_forces(deck.model, *deck.preload).sum(), 1500.0, 1e-9);
}

TEST(AbaqusPreload, OfALoadThatIsNotReadIsRefused) {
  expect_problem(trusses + step("*DLOAD\nE, ROTA, 1.\n") + modes("", ", PERTURBATION"), "*DLOAD ROTA is not read",
                 false);
  std::string hot = trusses;
  hot.insert(hot.find("*DENSITY"), "*EXPANSION\n1.2e-5\n");
  expect_problem(hot + step("*TEMPERATURE\nALL, 100.\n") + modes("", ", PERTURBATION"),
                 "*TEMPERATURE in step 1 loads what expands", false);
}

// --- Temperature -----------------------------------------------------------------------------------------------------

const std::string warm_trusses = [] {
  std::string text = trusses;
  text.replace(text.find("2.E11, 0.3"), 10, "2.E11, 0.3, 20.\n1.E11, 0.3, 520.");
  return text + "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, 20.\n";
}();

double modulus(const Deck& deck) { return deck.model.joints.front().stiffness / 1e-5; }

TEST(AbaqusStepTemperature, IsThatOfTheMaterials) {
  EXPECT_DOUBLE_EQ(modulus(read(warm_trusses)), 2e11);
  EXPECT_DOUBLE_EQ(modulus(read(warm_trusses + step("*TEMPERATURE\nALL, 520.\n") + modes("", ", PERTURBATION"))), 1e11);
  EXPECT_DOUBLE_EQ(modulus(read(warm_trusses + step("*TEMPERATURE\nALL, 270.\n"))), 1.5e11);
  EXPECT_DOUBLE_EQ(modulus(read(warm_trusses + modes("*TEMPERATURE\nALL, 520.\n"))), 1e11);
  EXPECT_DOUBLE_EQ(modulus(read(warm_trusses + modes() + step("*TEMPERATURE\nALL, 520.\n"))), 2e11);
  EXPECT_DOUBLE_EQ(modulus(read(warm_trusses + step("*TEMPERATURE\nALL, 520.\n"), {.temperature = 20.0})), 2e11);
}

TEST(AbaqusStepTemperature, MustBeOneForAll) {
  expect_problem(warm_trusses + step("*TEMPERATURE\nALL, 520.\nMID, 100.\n"), "from 100 to 520", false);
  expect_problem(warm_trusses + step("*TEMPERATURE\nALL, 520.\n*CLOAD\n3, 1, 1.\n") + step("*TEMPERATURE\nALL, 100.\n"),
                 "step 2 has other temperatures than the model");
  expect_problem(warm_trusses + step("*TEMPERATURE, FILE=run\n"), "from a results file", false);
}

// --- Loads that are not read -----------------------------------------------------------------------------------------

TEST(AbaqusStepLoads, ThatAreNotReadAreRefusedByName) {
  const std::string pulled = "*CLOAD\n3, 1, 1.\n";
  for (const std::string label : {"ROTA", "CORIO", "BXNU", "P1NU", "HP", "EDNOR1", "TRVEC", "NEWTON", "PX"})
    expect_problem(trusses + step(pulled + "*DLOAD\nE, " + label + ", 4.\n"), "*DLOAD " + label + " is not read");
  for (const std::string keyword : {"*PRE-TENSION SECTION, SURFACE=S, NODE=3", "*INERTIA RELIEF", "*CONNECTOR LOAD"}) {
    const std::string title = keyword.substr(0, keyword.find(','));
    expect_problem(trusses + step(pulled + keyword + "\n"), title + " in step 1 is not read");
    expect_problem(trusses + step(keyword + "\n"), title + " in step 1 is not read");
  }
  expect_problem(trusses + "*INITIAL CONDITIONS, TYPE=STRESS\n1, 1, 1.\n" + step(pulled), "loads the static steps");
  expect_problem(trusses + step("*CLOAD, LOAD CASE=2\n3, 1, 1.\n"), "imaginary load");
  expect_problem(trusses + step("*BOUNDARY, TYPE=VELOCITY\n3, 1, 1, 2.\n"), "no displacements");
  expect_problem(trusses + step("*CLOAD, AMPLITUDE=A\n3, 1, 1.\n"), "no *AMPLITUDE of that name");
}

/// Gravity on one of the trusses: half its weight at each of its ends; on both it is the gravity of the case.
TEST(AbaqusStepLoads, WeighAPartOfTheModel) {
  const auto part = with_cases(trusses + step("*DLOAD\n2, GRAV, 10., 1., 0., 0.\n"));
  const auto forces = nodal_forces(part.model, part.load_cases.at(0));
  EXPECT_NEAR(forces[6 * 1], 0.5 * 7800 * 1e-5 * 10, 1e-12);
  EXPECT_NEAR(forces[6 * 2], 0.5 * 7800 * 1e-5 * 10, 1e-12);
  EXPECT_NEAR(with_cases(trusses + step("*DLOAD\nE, GRAV, 10., 1., 0., 0.\n")).load_cases.at(0).gravity.x(), 10.0, 0.0);
}

TEST(AbaqusStepLoads, OnElementsWithoutMassAreRefused) {
  const std::string spring = "*ELEMENT, TYPE=SPRINGA, ELSET=S\n9, 1, 3\n*SPRING, ELSET=S\n\n1.E4\n";
  for (const std::string load : {"GRAV, 10., 1., 0., 0.", "BX, 10.", "CENTRIF, 25., 0.5, 0., 0., 0., 0., 2."})
    expect_problem(trusses + spring + step("*CLOAD\n3, 1, 1.\n*DLOAD\nS, " + load + "\n"), "elements without mass");
}

TEST(AbaqusStepLoads, RotateTheModel) {
  const auto deck = with_cases(trusses + step("*DLOAD\nE, CENTRIF, 25., 0.5, 0., 0., 0., 0., 2.\n"));
  const auto& rotation = deck.load_cases.at(0).rotation;
  ASSERT_TRUE(rotation);
  EXPECT_DOUBLE_EQ(rotation->speed, 5.0);
  EXPECT_DOUBLE_EQ(rotation->about.x(), 0.5);
}

/// Abaqus keeps *DSLOAD and *DLOAD apart and goes on behind a perturbation with what acted before it.
TEST(AbaqusStepLoads, FollowTheRulesOfTheirProgram) {
  const auto force = [](const std::string& head) {
    const auto deck = with_cases(head + trusses + step("*CLOAD\n3, 1, 5.\n") +
                                 step("*CLOAD\n3, 1, 3.\n", ", PERTURBATION") + step("*CLOAD\n2, 1, 1.\n"));
    return nodal_forces(deck.model, deck.load_cases.at(2)).sum();
  };
  EXPECT_DOUBLE_EQ(force(abaqus), 6.0);
  EXPECT_DOUBLE_EQ(force(""), 4.0);
}

// --- Springs ---------------------------------------------------------------------------------------------------------

std::string spring(const std::string& lines, const std::string& options = "", const std::string& more = "") {
  return "*NODE, NSET=ALL\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=SPRINGA, ELSET=S\n1, 1, 2\n*SPRING, ELSET=S" +
         options + "\n" + lines +
         "*ELEMENT, TYPE=MASS, ELSET=MM\n9, 2\n*MASS, ELSET=MM\n4.\n*BOUNDARY\n1, 1, 3\n2, 2, 3\n" + more;
}

double stiffness(const std::string& text, std::optional<double> temperature = {}) {
  return read(text, {.temperature = temperature}).model.joints.at(0).stiffness;
}

TEST(AbaqusSprings, TakeTheRowOfTheirTemperature) {
  const std::string rows = "\n1.E4, , 0.\n4.E4, , 100.\n", warm = "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, 50.\n";
  EXPECT_DOUBLE_EQ(stiffness(spring(rows), 100.0), 4e4);
  EXPECT_DOUBLE_EQ(stiffness(spring(rows), 50.0), 2.5e4);
  EXPECT_DOUBLE_EQ(stiffness(spring(rows, "", warm)), 2.5e4);
  EXPECT_DOUBLE_EQ(stiffness(spring("1.E4, , 0.\n4.E4, , 100.\n"), 100.0), 4e4);  // without the blank line
  EXPECT_DOUBLE_EQ(
      stiffness(spring("\n-1., -1.e-3, 0.\n1., 1.e-3, 0.\n-4., -1.e-3, 100.\n4., 1.e-3, 100.\n", ", NONLINEAR"), 100.0),
      4e3);
}

TEST(AbaqusSprings, WithValuesThatAModelHasNotAreRefused) {
  expect_problem(spring("\n1.E4, , 0.\n4.E4, , 100.\n"), "several temperatures", false);
  expect_problem(spring("\n1.E4, 1.\n4.E4, 10.\n"), "several frequencies", false);
  expect_problem(spring("\n1.E4\n4.E4\n"), "several values at one temperature", false);
  expect_problem(spring("\n1.E4, 1.E2\n", ", COMPLEX STIFFNESS"), "COMPLEX STIFFNESS", false);
}

// --- Files and couplings ---------------------------------------------------------------------------------------------

TEST(AbaqusIncludes, OfNestedFilesMayBeNamedFromTheFirstFolder) {
  std::vector<std::string> asked;
  const auto loader = [&](const std::filesystem::path& path) -> std::string {
    asked.push_back(path.string());
    if (path == "run/parts/outer.inp") return "*INCLUDE, INPUT=parts/inner.inp\n";
    if (path == "run/parts/inner.inp") return trusses;
    throw InvalidInput(Issue{{path.string(), 0}, "no such file", "", ""});
  };
  EXPECT_EQ(parse_abaqus("*INCLUDE, INPUT=parts/outer.inp\n", "run/deck.inp", loader).model.joints.size(), 2u);
  try {
    parse_abaqus("*INCLUDE, INPUT=parts/outer.inp\n*INCLUDE, INPUT=none.inp\n", "run/deck.inp", loader);
    ADD_FAILURE() << "the deck was read";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("none.inp"), std::string::npos) << error.what();
  }
}

TEST(AbaqusCouplings, OfTwoProgramsAreReadAsTheDeckIsWritten) {
  const std::string coupling =
      "*NODE\n9, 1., 1., 0.\n*ELEMENT, TYPE=DCOUP3D, ELSET=D\n7, 9\n*DISTRIBUTING COUPLING, ELSET=D\n"
      "1, 1.\n2, 1.\n3, 1.\n";
  const auto of_calculix = read(trusses + coupling), of_abaqus = read(abaqus + trusses + coupling);
  EXPECT_TRUE(note_of(of_calculix, "*DISTRIBUTING COUPLING"));
  EXPECT_TRUE(of_calculix.model.weighted_links.empty());
  EXPECT_EQ(of_abaqus.model.weighted_links.size(), 1u);
}

}  // namespace
}  // namespace kalfem
