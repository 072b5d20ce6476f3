// SPDX-License-Identifier: Apache-2.0
// What a finite-element model of a case is made of: nodes by place, boundaries on links, what a deck lacks.
#include <gtest/gtest.h>

#include <algorithm>

#include "command.hpp"

namespace kalfem::test {
namespace {

void write(const std::filesystem::path& file, const std::string& text) { std::ofstream(file) << text; }

/// Whether a piece stands in a text.
bool holds(const std::string& text, const std::string& piece) { return text.find(piece) != std::string::npos; }

/// A cantilever plate of 4 x 2 elements with a hub at (1.1, 0.2, 0.05), number 100, and its link; a mass of 2 kg at it.
std::string plate_deck(const std::string& link, const std::string& more = "") {
  std::string deck = "SOL 103\nCEND\nSPC = 1\nBEGIN BULK\nPARAM,COUPMASS,1\n";
  for (int i = 0; i <= 4; ++i)
    for (int j = 0; j <= 2; ++j)
      deck += "GRID," + std::to_string(10 * i + j + 1) + ",," + std::to_string(0.25 * i) + "," +
              std::to_string(0.2 * j) + ",0.\n";
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 2; ++j) {
      const int n = 10 * i + j + 1;
      deck += "CQUAD4," + std::to_string(2 * i + j + 1) + ",7," + std::to_string(n) + "," + std::to_string(n + 10) +
              "," + std::to_string(n + 11) + "," + std::to_string(n + 1) + "\n";
    }
  return deck +
         "PSHELL,7,9,.01,9,,9\nMAT1,9,2.1E11,,.3,7850.\nSPC1,1,123456,1,2,3\nGRID,100,,1.1,.2,.05\n"
         "CONM2,90,100,,2.\n" +
         link + more + "ENDDATA\n";
}
const std::string mean_link = "RBE3,50,,100,123456,1.,123,41,43\n,32\n";
const std::string rigid_link = "RBE2,50,100,123456,41,42,43\n";

std::string case_of(const std::string& nodes, const std::string& more) {
  return "kalfem: 1\nsubstructures:\n  plate:\n    finite_elements:\n      deck: plate.bdf\n      nodes: " + nodes +
         "\n" + more;
}

Outcome run(const std::string& verb, const ScratchFolder& folder, const std::string& deck, const std::string& text) {
  write(folder / "plate.bdf", deck);
  write(folder / "case.yaml", text);
  return run_command(
      verb + " " + (folder / "case.yaml").string() + (verb == "check" ? "" : " --out " + (folder / "out").string()),
      folder);
}

nlohmann::json reduction_of(const ScratchFolder& folder) {
  return read_summary(folder / "out")["model"]["substructures"]["plate"]["reduction"];
}

/// The reference of a weighted mean, and a follower of a rigid link, are boundary nodes as others.
TEST(Boundary, MayBeAReferenceOrAFollower) {
  const ScratchFolder folder("boundary-links");
  for (const auto& [link, node] : {std::pair{mean_link, "100"}, std::pair{rigid_link, "42"}}) {
    const auto outcome = run("modes", folder, plate_deck(link),
                             case_of(std::string("{hub: ") + node + "}",
                                     "    reduction: {modes: 12, boundary: [hub]}\n"
                                     "report: {superelements: [matrix_market]}\n"));
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    EXPECT_EQ(reduction_of(folder)["boundary"], 3) << link;
    const auto modes = reduction_of(folder)["modes"];
    // Up to the highest fixed-interface mode: as many full ones at least, and at most three more for three held
    // motions.
    EXPECT_GE(modes.size(), 12u) << link;
    EXPECT_LE(modes.size(), 15u) << link;
    // found 3e-7: what twelve modes and three modal truncation augmentation vectors leave of the tenth
    for (std::size_t i = 0; i < 10; ++i)
      EXPECT_NEAR(modes[i]["reduced_hz"].get<double>() / modes[i]["full_hz"].get<double>(), 1.0, 1e-6) << link;
    const auto rows = read(folder / "out" / "plate_reduced.dof");
    EXPECT_TRUE(holds(rows, node)) << rows;
    std::filesystem::remove_all(folder / "out");
  }
}

TEST(Boundary, OfWhatConnectorsTouchIsReducedToo) {
  const ScratchFolder folder("boundary-attached");
  const auto outcome = run("simulate", folder, plate_deck(mean_link),
                           case_of("{hub: 100, tip: 42}",
                                   "excitation:\n  push: {force: plate.hub.z, random: {rms: 1 N, band: [5, 30 Hz], "
                                   "fade_in: 0.05 s}}\nsensors:\n  a: {acceleration: plate.tip.z, noise: 5 %}\n"
                                   "simulate: {duration: 0.1 s, sample_rate: 1 kHz}\n"));
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(reduction_of(folder)["boundary"], 3);
}

struct Refusal {
  const char* name;
  std::string nodes, more;
  std::vector<std::string> pieces;
};

class BoundaryRefusal : public testing::TestWithParam<Refusal> {};

TEST_P(BoundaryRefusal, HasItsPlace) {
  const ScratchFolder folder(std::string("boundary-") + GetParam().name);
  for (const std::string verb : {"check", "modes"}) {
    const auto outcome = run(verb, folder, plate_deck(mean_link), case_of(GetParam().nodes, GetParam().more));
    EXPECT_EQ(outcome.code, 2) << outcome.output << outcome.errors;
    for (const auto& piece : GetParam().pieces) EXPECT_TRUE(holds(outcome.errors, piece)) << outcome.errors;
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Mistakes, BoundaryRefusal,
    testing::Values(Refusal{"Held",
                            "{root: 2, tip: 42}",
                            "    reduction: {modes: 4, boundary: [tip, root]}\n",
                            {"case.yaml:7", "'root' cannot move", "a support fixes it"}},
                    Refusal{"HeldMotion",
                            "{root: 2, tip: 42}",
                            "    reduction: {modes: 4, boundary: [tip, root.rx]}\n",
                            {"case.yaml:7", "'root.rx' cannot move"}},
                    Refusal{"None", "{tip: 42}", "    reduction: {modes: 4}\n", {"case.yaml:7", "has no boundary"}},
                    Refusal{"NoneForFiles",
                            "{tip: 42}",
                            "report: {superelements: [dmig]}\n",
                            {"case.yaml:7", "the case reduces no substructure"}}),
    [](const auto& each) { return std::string(each.param.name); });

TEST(NamedNodes, AreToldWithTheirPlaceAndDistance) {
  const ScratchFolder folder("node-places");
  const auto outcome = run("check", folder, plate_deck(rigid_link), case_of("{tip: [1.02, 0.4, 0], hub: 100}", ""));
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  for (const char* piece : {"Named nodes", "tip", "43", "1, 0.4, 0", "0.02"})
    EXPECT_TRUE(holds(outcome.output, piece)) << piece << "\n" << outcome.output;
}

TEST(NamedNodes, MustLieInTheModel) {
  const ScratchFolder folder("node-far");
  const auto far = run("check", folder, plate_deck(rigid_link), case_of("{tip: [1000, 0, 0]}", ""));
  EXPECT_EQ(far.code, 2);
  for (const char* piece : {"case.yaml:6", "tip", "node 100", "998.9 m away", "metres"})
    EXPECT_TRUE(holds(far.errors, piece)) << piece << "\n" << far.errors;
  const auto shared =
      run("check", folder, plate_deck(rigid_link), case_of("{left: [0.45, 0.2, 0], right: [0.55, 0.2, 0]}", ""));
  EXPECT_EQ(shared.code, 2);
  for (const char* piece : {"case.yaml:6", "'left'", "are both nearest to node 22"})
    EXPECT_TRUE(holds(shared.errors, piece)) << piece << "\n" << shared.errors;
  const auto named = run("check", folder, plate_deck(rigid_link),
                         case_of("{left: [0.5, 0.2, 0], same: [0.5, 0.2, 0], number: 22}", ""));
  EXPECT_EQ(named.code, 0) << named.errors;
}

TEST(Mass, IsTheWholeAndTheFreePartBesideIt) {
  const ScratchFolder folder("mass");
  const std::string text = case_of("{tip: 42}", "");
  const auto checked = run("check", folder, plate_deck(rigid_link), text);
  ASSERT_EQ(checked.code, 0) << checked.errors;
  // 7850 x 0.4 x 0.01 + 2 kg. The elements at the root are a quarter of the plate, and the mean of the squared shape
  // function leaves a third of them free.
  for (const char* piece : {"33.4", "centre of gravity", "free to move along x, y, z"})
    EXPECT_TRUE(holds(checked.output, piece)) << piece << "\n" << checked.output;
  ASSERT_EQ(run("modes", folder, plate_deck(rigid_link), text).code, 0);
  const auto plate = read_summary(folder / "out")["model"]["substructures"]["plate"];
  // rounding
  EXPECT_NEAR(plate["mass"].get<double>(), 33.4, 1e-13);
  EXPECT_NEAR(plate["moving_mass"][2].get<double>(), 33.4 - 2.0 / 3.0 * 7.85, 1e-13);
  EXPECT_NEAR(plate["centre_of_gravity"][1].get<double>(), 0.2, 1e-15);
}

TEST(MissingParts, AreRefusedUnlessTheCaseAcceptsThem) {
  const ScratchFolder folder("missing");
  const std::string deck = plate_deck(rigid_link, "CBEND,70,8,21,31,32,22\nPBEND,8,9,.001\nFORCE,5,42,,1.,0.,0.,1.\n");
  const auto refused = run("modes", folder, deck, case_of("{tip: 42}", ""));
  EXPECT_EQ(refused.code, 2);
  for (const char* piece : {"plate.bdf:35", "CBEND is missing", "accept_missing: [CBEND]"})
    EXPECT_TRUE(holds(refused.errors, piece)) << piece << "\n" << refused.errors;
  const auto accepted = run("modes", folder, deck, case_of("{tip: 42}", "      accept_missing: [CBEND]\n"));
  EXPECT_EQ(accepted.code, 0) << accepted.errors;
  EXPECT_TRUE(holds(accepted.errors, "CBEND")) << accepted.errors;
  const auto idle = run("modes", folder, deck, case_of("{tip: 42}", "      accept_missing: [CBEND, CWELD]\n"));
  EXPECT_EQ(idle.code, 2);
  EXPECT_TRUE(holds(idle.errors, "case.yaml:7") && holds(idle.errors, "'CWELD'")) << idle.errors;
}

TEST(MissingParts, AreErrorsOfADeckThatIsCheckedAlone) {
  const ScratchFolder folder("missing-deck");
  write(folder / "plate.bdf", plate_deck(rigid_link, "CBEND,70,8,21,31,32,22\nFORCE,5,42,,1.,0.,0.,1.\n"));
  const auto outcome = run_command("check " + (folder / "plate.bdf").string(), folder);
  EXPECT_EQ(outcome.code, 2) << outcome.output;
  EXPECT_TRUE(holds(outcome.output, "error: ") && holds(outcome.output, "CBEND")) << outcome.output;
  EXPECT_TRUE(holds(outcome.output, "not used: ")) << outcome.output;
}

/// A deck that is cut off behind its elements loses its supports, or the masses that follow.
TEST(MissingParts, OfADeckThatIsCutOffAreRefused) {
  const ScratchFolder folder("cut-deck");
  const std::string whole = plate_deck(rigid_link);
  for (const std::string lost : {"SPC1,1,12", "CONM2"}) {
    const std::string deck = whole.substr(0, whole.find(lost));
    const auto last = std::to_string(std::ranges::count(deck, '\n'));
    for (const std::string verb : {"check", "modes"}) {
      const auto outcome = run(verb, folder, deck, case_of("{tip: 42}", ""));
      EXPECT_EQ(outcome.code, 2) << outcome.output;
      EXPECT_TRUE(holds(outcome.errors, "plate.bdf:" + last + ": ENDDATA is missing")) << outcome.errors;
    }
    EXPECT_EQ(run_command("check " + (folder / "plate.bdf").string(), folder).code, 2);
  }
}

}  // namespace
}  // namespace kalfem::test
