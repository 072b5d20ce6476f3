// SPDX-License-Identifier: Apache-2.0
// *STEP, PERTURBATION of static steps: the stress of the step that it starts from is in its stiffness. Closed forms.
#include <gtest/gtest.h>

#include "formats/abaqus_decks.hpp"
#include "kalfem/model/placement.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "kalfem/model/unit_system.hpp"

namespace kalfem {
namespace {

const std::string abaqus = "*PREPRINT, ECHO=NO\n";  // a keyword that CalculiX does not have

Deck read(const std::string& text, bool load_cases = true) {
  return parse_abaqus(text, "deck.inp", {}, {.load_cases = load_cases});
}

std::string step(const std::string& loads, const std::string& options = "") {
  return "*STEP" + options + "\n*STATIC\n" + loads + "*END STEP\n";
}

/// A string of two trusses, 1 m each, pulled by 1000 N; then its middle is pushed aside by 10 N.
std::string string_deck(const std::string& first, const std::string& second = ", PERTURBATION") {
  return "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n*ELEMENT, TYPE=T3D2, ELSET=E\n1, 1, 2\n2, 2, 3\n" +
         deck_steel + "*SOLID SECTION, ELSET=E, MATERIAL=steel\n1.E-5\n*BOUNDARY\n1, 1, 3\n2, 2, 3\n3, 2, 3\n" +
         step("*CLOAD\n3, 1, 1000.\n", first) +
         step("*BOUNDARY, OP=NEW\n1, 1, 3\n2, 3, 3\n3, 1, 3\n*CLOAD\n2, 2, 10.\n", second);
}

double aside(const Deck& deck) { return solve_statics(deck.model, deck.load_cases.at(1)).displacements[6 + 1]; }

/// u = F / (N / L + N / L), in any axes and units.
TEST(StaticPerturbations, AStringIsHeldByItsTension) {
  auto deck = read(string_deck(""));
  ASSERT_EQ(deck.load_cases.at(1).preload.size(), 1u);
  EXPECT_EQ(deck.load_cases[1].preload[0].name, "step1");
  EXPECT_NEAR(aside(deck), 10.0 / 2000.0, 1e-9);

  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  place(deck.model, deck.load_cases, {.rotation = turn});
  const auto turned = solve_statics(deck.model, deck.load_cases[1]).displacements.segment<3>(6);
  EXPECT_NEAR((turned - 0.005 * turn.col(1)).norm(), 0.0, 1e-9);

  auto in_millimetres = read(string_deck(""));
  const UnitSystem units{.length = 1e-3};
  to_si(in_millimetres.model, units);
  for (auto& load_case : in_millimetres.load_cases) to_si(load_case, units);
  EXPECT_NEAR(aside(in_millimetres), 0.005e-3, 1e-12);
}

TEST(StaticPerturbations, FollowTheRuleOfTheirProgram) {
  EXPECT_TRUE(read(string_deck("", "")).load_cases.at(1).preload.empty());
  EXPECT_NEAR(aside(read(abaqus + string_deck(", NLGEOM"))), 0.005, 1e-9);
  const auto without = read(abaqus + string_deck(""));
  EXPECT_TRUE(without.load_cases.at(1).preload.empty());
  EXPECT_TRUE(std::ranges::any_of(without.notes, [](const auto& note) {
    return note.what == "*STEP, PERTURBATION of a static step" && note.kind == DeckNoteKind::doubtful;
  }));
  // A general step of Abaqus goes on with large displacements, and perturbations do not change its state.
  const auto later = read(abaqus + string_deck(", NLGEOM") + step("*CLOAD\n2, 2, 1.\n", ", PERTURBATION"));
  EXPECT_EQ(later.load_cases.at(2).preload.at(0).name, "step1");
}

/// A cantilever under the axial force P: u = F / P (tan(k L) / k - L), k^2 = P / E I of a compressed one.
std::string column_deck(double force, const std::string& more = "") {
  std::string nodes = "*NODE\n", beams = "*ELEMENT, TYPE=B31, ELSET=E\n";
  for (int i = 0; i <= 8; ++i) nodes += std::to_string(i + 1) + ", " + std::to_string(i / 8.0) + ", 0., 0.\n";
  for (int i = 1; i <= 8; ++i)
    beams += std::to_string(i) + ", " + std::to_string(i) + ", " + std::to_string(i + 1) + "\n";
  return nodes + beams + deck_steel +
         "*BEAM SECTION, ELSET=E, MATERIAL=steel, SECTION=RECT\n0.01, 0.01\n0., 1., 0.\n*BOUNDARY\n1, 1, 6\n" +
         step("*CLOAD\n9, 1, " + std::to_string(force) + "\n") + step("*CLOAD\n9, 2, 3.\n", ", PERTURBATION") + more;
}

TEST(StaticPerturbations, AColumnBendsMoreUnderCompression) {
  const double stiffness = 2.1e11 * 1e-8 / 12.0;
  for (const double force : {-300.0, 300.0}) {
    const auto deck = read(column_deck(force));
    const StaticAnalysis analysis(deck.model, deck.load_cases);
    const auto bent = analysis.solve(1);
    const double k = std::sqrt(std::abs(force) / stiffness);
    const double factor = force < 0.0 ? std::tan(k) / k - 1.0 : 1.0 - std::tanh(k) / k;
    EXPECT_NEAR(bent.displacements[6 * 8 + 1] / (3.0 / std::abs(force) * factor), 1.0, 2e-3) << force;
    EXPECT_EQ(bent.preload, "step1");
    EXPECT_LT(bent.imbalance, 1e-9);
    EXPECT_TRUE(analysis.ignored_springs(1).empty());
  }
}

TEST(StaticPerturbations, BeyondBucklingAreRefused) {
  const auto deck = read(column_deck(-500.0));  // Euler's load is 432 N
  try {
    const StaticAnalysis analysis(deck.model, deck.load_cases);
    ADD_FAILURE() << "it was solved";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("the preload 'step1' of load case 'step2'"), std::string::npos)
        << error.what();
  }
}

/// In CalculiX, modes behind a static perturbation have its stress, found with the stiffness that it had.
TEST(StaticPerturbations, AreThePreloadOfModesBehindThem) {
  for (const bool wanted : {true, false}) {
    const auto deck = read(column_deck(-300.0, "*STEP, PERTURBATION\n*FREQUENCY\n1\n*END STEP\n"), wanted);
    ASSERT_TRUE(deck.preload);
    EXPECT_EQ(deck.preload->name, "step2");
    ASSERT_EQ(deck.preload->preload.size(), 1u);
    EXPECT_EQ(deck.preload->preload[0].name, "step1");
    EXPECT_EQ(deck.load_cases.size(), wanted ? 2u : 0u);
  }
}

}  // namespace
}  // namespace kalfem
