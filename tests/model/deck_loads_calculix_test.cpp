// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "base/absent.hpp"
#include "base/scratch_folder.hpp"
#include "kalfem/formats/abaqus.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "model/calculix.hpp"

// Static steps of a deck, read with their loads and a material by temperature, against CalculiX (ccx) on the same file:
// differences up to 1.9e-5 of the largest displacement.

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// A bar of three hexahedra along x of an orthotropic material whose axes are turned by 30 degrees about z, at 120
/// between its rows of 20 and 220. A reference node 30 moves the end along y by an equation.
const std::string bar = R"(*NODE, NSET=ALL
1, 0, 0, 0
2, 1, 0, 0
3, 2, 0, 0
4, 3, 0, 0
5, 0, 1, 0
6, 1, 1.1, 0
7, 2, 1, 0
8, 3, 1, 0
9, 0, 0, 1
10, 1, 0, 1
11, 2, 0, 1.1
12, 3, 0, 1
13, 0, 1, 1
14, 1, 1, 1
15, 2, 1, 1
16, 3, 1, 1
30, 5, 5, 5
*NSET, NSET=ROOT
1, 5, 9, 13
*NSET, NSET=TIP
4, 8, 12, 16
*ELEMENT, TYPE=C3D8, ELSET=BAR
1, 1, 2, 6, 5, 9, 10, 14, 13
2, 2, 3, 7, 6, 10, 11, 15, 14
3, 3, 4, 8, 7, 11, 12, 16, 15
*ORIENTATION, NAME=TURNED
0.8660254037844386, 0.5, 0., -0.5, 0.8660254037844386, 0.
*SOLID SECTION, ELSET=BAR, MATERIAL=PLY, ORIENTATION=TURNED
*MATERIAL, NAME=PLY
*ELASTIC, TYPE=ENGINEERING CONSTANTS
1.4e5, 1.e4, 1.e4, 0.3, 0.3, 0.4, 5.e3, 5.e3
3.e3, 20.
1.e5, 6.e3, 6.e3, 0.3, 0.3, 0.4, 3.e3, 3.e3
2.e3, 220.
*DENSITY
2.
*INITIAL CONDITIONS, TYPE=TEMPERATURE
ALL, 120.
*BOUNDARY
ROOT, 1, 3
30, 1, 1
30, 3, 3
)";

const std::string output = "*NODE PRINT, NSET=ALL, GLOBAL=YES\nU\n*END STEP\n";
const std::string forces = "*STEP\n*STATIC\n*BOUNDARY\n30, 2, 2\n*CLOAD\nTIP, 3, 2.\n8, 1, 30.\n" + output;
const std::string pressed = "*STEP\n*STATIC\n*DLOAD\nBAR, GRAV, 9.81, 0., -1., -2.\n3, P4, 12.\n2, P2, 7.\n" + output;

/// Tables of displacements in a .dat file, one a step.
std::vector<std::map<std::int64_t, Vector3d>> displacements_in(const std::filesystem::path& file) {
  std::vector<std::map<std::int64_t, Vector3d>> tables;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.find("displacements") != std::string::npos) tables.emplace_back();
    std::istringstream numbers(line);
    std::int64_t node = 0;
    Vector3d moved;
    if (!tables.empty() && numbers >> node >> moved[0] >> moved[1] >> moved[2]) tables.back()[node] = moved;
  }
  return tables;
}

class DeckLoadsCalculix : public testing::Test {
protected:
  void SetUp() override {
    if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  }

  static void expect_same(const std::string& text) {
    const ScratchFolder folder("deck-loads");
    std::ofstream(folder / "deck.inp") << text;
    ASSERT_TRUE(run_calculix(folder, "deck"));
    const auto expected = displacements_in(folder / "deck.dat");
    const auto deck = read_abaqus(folder / "deck.inp", {.load_cases = true});
    ASSERT_EQ(deck.load_cases.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const auto found = solve_statics(deck.model, deck.load_cases[i]).displacements;
      double largest = 0.0;
      for (const auto& [node, moved] : expected[i]) largest = std::max(largest, moved.norm());
      ASSERT_GT(largest, 0.0);
      const NodeFinder nodes(deck.model.mesh);
      for (const auto& [node, moved] : expected[i])
        EXPECT_LE((found.segment<3>(6 * nodes.find(node)) - moved).norm(), 5e-5 * largest)
            << "step " << i + 1 << ", node " << node << ": " << found.segment<3>(6 * nodes.find(node)).transpose()
            << " instead of " << moved.transpose();
    }
  }
};

TEST_F(DeckLoadsCalculix, OrthotropicBarUnderForcesAndPressures) { expect_same(bar + forces + pressed); }

TEST_F(DeckLoadsCalculix, OrthotropicBarMovedByAReferenceNode) {
  expect_same(bar + "*EQUATION\n2\n4, 2, 1., 30, 2, -0.5\n*EQUATION\n2\n12, 2, 1., 30, 2, -1.\n" +
              "*STEP\n*STATIC\n*BOUNDARY\n30, 2, 2, 0.01\n" + output);
}

const std::string sloped = "*TRANSFORM, NSET=TIP, TYPE=R\n0.8, 0.6, 0., -0.6, 0.8, 0.2\n";

TEST_F(DeckLoadsCalculix, EndMovedAlongAxesOfItsOwn) {
  expect_same(bar + sloped + "*BOUNDARY\nTIP, 2, 2\n" + "*STEP\n*STATIC\n*BOUNDARY\nTIP, 1, 1, 0.01\n" + output);
}

/// The dependent degree of freedom of an equation with a right side, 0.7 times the motion of node 30, is along an axis
/// of its node.
TEST_F(DeckLoadsCalculix, EquationWithARightSideInAxesOfItsNode) {
  expect_same(bar + sloped + "*EQUATION\n3\n4, 1, 1., 8, 2, -0.3, 30, 2, -0.7\n*EQUATION\n2\n12, 3, 1., 30, 2, -1.\n" +
              "*STEP\n*STATIC\n*BOUNDARY\n30, 2, 2, 0.01\n*CLOAD\n16, 2, 3.\n" + output);
}

}  // namespace
}  // namespace kalfem::test
