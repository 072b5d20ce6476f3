// SPDX-License-Identifier: Apache-2.0
// Models that other codes' users bring: decks, matrices, and what the command says of them.
#include <gtest/gtest.h>

#include "command.hpp"

namespace kalfem::test {
namespace {

/// A steel bar of four bricks, clamped at one end, in mm, t, s.
std::string brick_deck() {
  std::string deck = "*HEADING\nbar\n*NODE, NSET=ALL\n";
  for (int i = 0; i <= 4; ++i)
    for (int corner = 0; corner < 4; ++corner)
      deck += std::to_string(4 * i + corner + 1) + ", " + std::to_string(50.0 * i) + ", " +
              (corner == 1 || corner == 2 ? "20., " : "0., ") + (corner > 1 ? "20.\n" : "0.\n");
  deck += "*ELEMENT, TYPE=C3D8I, ELSET=BAR\n";
  for (int e = 0; e < 4; ++e) {
    deck += std::to_string(e + 1);
    for (int corner = 1; corner <= 4; ++corner) deck += ", " + std::to_string(4 * e + corner);
    for (int corner = 1; corner <= 4; ++corner) deck += ", " + std::to_string(4 * e + 4 + corner);
    deck += "\n";
  }
  return deck +
         "*NSET, NSET=TIP\n17\n*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n*DENSITY\n7.85E-9\n"
         "*SOLID SECTION, ELSET=BAR, MATERIAL=STEEL\n*BOUNDARY\n1, 1, 3\n2, 1, 3\n3, 1, 3\n4, 1, 3\n"
         "*STEP\n*FREQUENCY\n4\n*CLOAD\n17, 2, 1.\n*END STEP\n";
}

void write(const std::filesystem::path& file, const std::string& text) { std::ofstream(file) << text; }

double first_frequency(const std::filesystem::path& folder, const std::string& substructure) {
  return read_summary(folder)["model"]["substructures"][substructure]["frequencies_hz"][0].get<double>();
}

TEST(Decks, CheckSaysWhatADeckHolds) {
  const ScratchFolder folder("check-deck");
  write(folder / "bar.inp", brick_deck());
  const auto outcome = run_command(
      "check " + (folder / "bar.inp").string() + " --units mm t s --page " + (folder / "health.html").string(), folder);
  EXPECT_EQ(outcome.code, 0) << outcome.errors << outcome.output;
  for (const char* piece : {"mass [kg]", "0.628", "BAR", "STEEL", "Lowest natural frequencies"})
    EXPECT_NE(outcome.output.find(piece), std::string::npos) << piece << "\n" << outcome.output;
  EXPECT_NE(read(folder / "health.html").find("<svg"), std::string::npos);
}

TEST(Decks, UnitsThatWereNotDeclaredAreNoticed) {
  const ScratchFolder folder("check-units");
  write(folder / "bar.inp", brick_deck());
  const auto outcome = run_command("check " + (folder / "bar.inp").string(), folder);
  EXPECT_NE(outcome.output.find("mm, t, s"), std::string::npos) << outcome.output;
}

/// Decks are older than UTF-8.
TEST(Decks, NamesInOtherEncodingsBreakNoOutput) {
  const ScratchFolder folder("deck-names");
  std::string deck = brick_deck();
  for (std::size_t at = 0; (at = deck.find("ELSET=BAR", at)) != std::string::npos; at += 9)
    deck.replace(at, 9, "ELSET=TR\xC4GER\x1b[31m");
  write(folder / "bar.inp", deck);
  write(folder / "case.yaml",
        "kalfem: 1\nsubstructures:\n  bar:\n    finite_elements:\n      deck: bar.inp\n"
        "      units: {length: 1 mm, mass: 1 t, time: 1 s}\n      nodes: {tip: TIP}\n");
  for (const std::string verb : {"modes", "check"}) {
    const auto outcome = run_command(verb + " " + (folder / "case.yaml").string(), folder);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    EXPECT_EQ(outcome.output.find('\x1b'), std::string::npos) << outcome.output;
    EXPECT_EQ(outcome.output.find('\xC4'), std::string::npos) << outcome.output;
  }
  EXPECT_EQ(read_summary(folder / "case.kalfem-out")["status"], "ok");
  const auto page = read(folder / "case.kalfem-out" / "report.html");
  EXPECT_EQ(page.find('\x1b'), std::string::npos);
  EXPECT_EQ(page.find("TR\xC4GER"), std::string::npos);
  EXPECT_NE(page.find("TR\xEF\xBF\xBDGER[31m"), std::string::npos);
}

TEST(Decks, DeckOfBricksHasTheFrequenciesOfABeam) {
  const ScratchFolder folder("deck-modes");
  write(folder / "bar.inp", brick_deck());
  write(folder / "case.yaml",
        "kalfem: 1\nsubstructures:\n  bar:\n    finite_elements:\n      deck: bar.inp\n"
        "      units: {length: 1 mm, mass: 1 t, time: 1 s}\n      nodes: {tip: TIP, side: [0.2, 0.02, 0]}\n");
  const auto outcome =
      run_command("modes " + (folder / "case.yaml").string() + " --out " + (folder / "out").string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("kalfem ignores"), std::string::npos) << outcome.errors;  // the load of its step
  // Euler-Bernoulli: 1.8751^2 / (2 pi L^2) sqrt(E I / rho A) = 417.8 Hz for 20 x 20 x 200 mm; shear and rotary inertia
  // take 0.9 % of it, four bricks along the bar are 3 % too stiff: found 1.1 % off.
  EXPECT_NEAR(first_frequency(folder / "out", "bar"), 417.8, 0.02 * 417.8);
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "bar_modes.vtu"));
}

TEST(Decks, NastranPlateIsAsTheSamePlateFromAMesh) {
  const ScratchFolder folder("deck-nastran");
  write(folder / "plate.bdf",
        "SOL 103\nCEND\nSPC = 1\nBEGIN BULK\nPARAM,COUPMASS,1\n"
        "GRID,1,,0.,0.,0.\nGRID,2,,.5,0.,0.\nGRID,3,,1.,0.,0.\nGRID,4,,0.,.4,0.\nGRID,5,,.5,.4,0.\nGRID,6,,1.,.4,0.\n"
        "CQUAD4,1,7,1,2,5,4\nCQUAD4,2,7,2,3,6,5\nPSHELL,7,9,.005,9,,9\nMAT1,9,2.1E11,,.3,7850.\n"
        "SPC1,1,123456,1,4\nENDDATA\n");
  write(folder / "plate.msh",
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"plate\"\n1 2 \"edge\"\n$EndPhysicalNames\n"
        "$Nodes\n6\n1 0 0 0\n2 0.5 0 0\n3 1 0 0\n4 0 0.4 0\n5 0.5 0.4 0\n6 1 0.4 0\n$EndNodes\n"
        "$Elements\n3\n1 3 2 1 1 1 2 5 4\n2 3 2 1 1 2 3 6 5\n3 1 2 2 1 1 4\n$EndElements\n");
  write(folder / "case.yaml",
        "kalfem: 1\nsubstructures:\n  deck:\n    finite_elements: {deck: plate.bdf}\n"
        "  mesh:\n    finite_elements:\n      mesh: plate.msh\n"
        "      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}\n"
        "      regions: {plate: {material: steel, shell: {thickness: 5 mm}}}\n      fixed: {edge: {nodes: edge}}\n");
  const auto outcome =
      run_command("modes " + (folder / "case.yaml").string() + " --out " + (folder / "out").string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  // rounding
  EXPECT_NEAR(first_frequency(folder / "out", "deck") / first_frequency(folder / "out", "mesh"), 1.0, 1e-12);
}

TEST(Decks, WhatWasReducedIsReadBackFromEachFormat) {
  const ScratchFolder folder("export");
  write(folder / "bar.inp", brick_deck());
  write(folder / "case.yaml",
        "kalfem: 1\nsubstructures:\n  bar:\n    finite_elements:\n      deck: bar.inp\n"
        "      units: {length: 1 mm, mass: 1 t, time: 1 s}\n      nodes: {tip: TIP}\n"
        "    reduction: {modes: 6, boundary: [tip]}\n"
        "report: {superelements: [matrix_market, dmig, op4, hdf5]}\n");
  auto outcome =
      run_command("modes " + (folder / "case.yaml").string() + " --out " + (folder / "out").string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const double expected = first_frequency(folder / "out", "bar");
  write(folder / "again.yaml",
        "kalfem: 1\nsubstructures:\n"
        "  h5: {finite_elements: {matrices: {files: out/bar_reduced.h5}, nodes: {tip: 17}}}\n"
        "  dmig: {finite_elements: {matrices: {files: out/bar_reduced.dmig}}}\n"
        "  op4: {finite_elements: {matrices: {files: out/bar_reduced.op4, dofs: out/bar_reduced.dof}}}\n"
        "  mtx: {finite_elements: {matrices: {files: [out/bar_reduced_K.mtx, out/bar_reduced_M.mtx], dofs: "
        "out/bar_reduced.dof}}}\n");
  outcome = run_command("modes " + (folder / "again.yaml").string() + " --out " + (folder / "again").string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  // Six modes and three modal truncation augmentation vectors keep the first frequency; DMIG keeps eleven digits.
  for (const char* part : {"h5", "dmig", "op4", "mtx"})
    EXPECT_NEAR(first_frequency(folder / "again", part) / expected, 1.0, 2e-11) << part;  // found 3e-12
}

/// A body of three masses of 2 kg in a row on springs of 3e4 N/m, as matrices, and as lumped masses; each on a mount.
const std::string chain_case = R"(kalfem: 1
substructures:
  wheel: {masses: {z: 1 kg}, springs: [{from: ground, to: z, stiffness: 2e4, damping: 5}]}
  body: BODY
connectors:
  mount: {from: wheel.z, to: body.FOOT, law: cubic, parameters: {k: 1e4, k3: 1e8}}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 1 mm, band: [0.5, 30 Hz]}}
sensors:
  a: {acceleration: body.TOP, noise: 5 %}
simulate: {duration: 1 s, sample_rate: 1 kHz}
)";

nlohmann::json run_chain(const std::filesystem::path& folder, const std::string& body, const std::string& foot,
                         const std::string& top) {
  std::string text = chain_case;
  const auto put = [&](const std::string& word, const std::string& with) {
    text.replace(text.find(word), word.size(), with);
  };
  put("BODY", body);
  put("FOOT", foot);
  put("TOP", top);
  write(folder / "case.yaml", text);
  const auto outcome =
      run_command("simulate " + (folder / "case.yaml").string() + " --out " + (folder / "out").string(), folder);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  return outcome.code == 0 ? read_summary(folder / "out") : nlohmann::json();
}

TEST(Matrices, OfAChainHaveItsFrequencies) {
  const ScratchFolder folder("matrices");
  write(folder / "K.mtx",
        "%%MatrixMarket matrix coordinate real symmetric\n3 3 5\n1 1 3e4\n2 1 -3e4\n2 2 6e4\n3 2 -3e4\n3 3 3e4\n");
  write(folder / "M.mtx", "%%MatrixMarket matrix coordinate real symmetric\n3 3 3\n1 1 2\n2 2 2\n3 3 2\n");
  write(folder / "map.txt", "11.1\n12.1\n13.1\n");
  const std::string matrices =
      "{finite_elements: {matrices: {files: [K.mtx, M.mtx], dofs: map.txt}, nodes: {foot: 11, top: 13}}}";
  const auto of_matrices = run_chain(folder, matrices, "foot.x", "top.x");
  const auto lumped = run_chain(folder, "{chain: {masses: 3, mass: 2 kg, stiffness: 3e4}}", "1", "3");
  ASSERT_FALSE(of_matrices.is_null() || lumped.is_null());
  for (int mode = 1; mode < 3; ++mode)
    EXPECT_NEAR(of_matrices["model"]["substructures"]["body"]["frequencies_hz"][mode].get<double>() /
                    lumped["model"]["substructures"]["body"]["frequencies_hz"][mode].get<double>(),
                1.0, 1e-12);
}

TEST(Matrices, MistakesAreNamedTogether) {
  const ScratchFolder folder("matrix-mistakes");
  write(folder / "K.mtx", "%%MatrixMarket matrix coordinate real symmetric\n2 2 1\n1 1 3e4\n");
  write(folder / "M.mtx", "%%MatrixMarket matrix coordinate real general\n2 3 1\n1 1 3e4\n");
  write(folder / "case.yaml",
        "kalfem: 1\nsubstructures:\n  body:\n    finite_elements:\n      matrices:\n        - files: K.mtx\n"
        "        - files: [K.mtx, M.mtx]\n");
  const auto outcome = run_command("modes " + (folder / "case.yaml").string(), folder);
  EXPECT_EQ(outcome.code, 2);
  for (const char* piece : {"K.mtx", "which matrix is the mass matrix", "K (2 x 2)", "M (2 x 3)"})
    EXPECT_NE(outcome.errors.find(piece), std::string::npos) << piece << "\n" << outcome.errors;
}

}  // namespace
}  // namespace kalfem::test
