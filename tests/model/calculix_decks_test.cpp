// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "base/scratch_folder.hpp"
#include "kalfem/formats/abaqus.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly/assembly.hpp"
#include "model/calculix.hpp"

// Decks of CalculiX's own test suite with their reference output, and decks made here that CalculiX (ccx) solves beside
// kalfem where it is installed.

namespace kalfem {
namespace {

using Eigen::Index;

std::vector<double> frequencies_of(const FiniteElementModel& model, Index count) {
  const auto assembled = assemble(model);
  const auto modes = lowest_modes(evaluate(assembled.stiffness, assembled.parameters),
                                  evaluate(assembled.mass, assembled.parameters), {.count = count});
  std::vector<double> frequencies;
  for (Index i = 0; i < modes.values.size(); ++i)
    frequencies.push_back(std::sqrt(std::max(0.0, modes.values[i])) / (2.0 * std::numbers::pi));
  return frequencies;
}

void expect_close(const std::vector<double>& ours, const std::vector<double>& theirs, double tolerance,
                  std::size_t count) {
  ASSERT_GE(ours.size(), count);
  ASSERT_GE(theirs.size(), count);
  for (std::size_t i = 0; i < count; ++i) EXPECT_NEAR(ours[i], theirs[i], tolerance * theirs[i]) << "mode " << i + 1;
}

std::filesystem::path decks_folder() { return data_folder("calculix-decks"); }

/// Compares a deck of the suite with its reference output.
void expect_reference(const std::string& name, double tolerance, std::size_t count) {
  const auto deck = read_abaqus(decks_folder() / (name + ".inp"));
  expect_close(frequencies_of(deck.model, static_cast<Index>(count)),
               frequencies_in(decks_folder() / (name + ".dat.ref")), tolerance, count);
}

class CalculixSuite : public testing::Test {
protected:
  void SetUp() override {
    if (!std::filesystem::exists(decks_folder() / "beamf.inp")) KALFEM_ABSENT("the decks of CalculiX are not here");
  }
};

// 256 C3D8. The reference is printed with seven digits.
TEST_F(CalculixSuite, CantileverOfEightNodeHexahedra) { expect_reference("beam8f", 1e-6, 10); }

// 32 C3D20R. CalculiX integrates the mass by 2 x 2 x 2 points, kalfem exactly: 0.2 % in the tenth mode, up to
// .053 % below.
TEST_F(CalculixSuite, CantileverOfTwentyNodeHexahedra) {
  expect_reference("beamf", 1e-3, 9);
  expect_reference("beamf", 3e-3, 10);
}

TEST_F(CalculixSuite, CantileverWithAPointMass) { expect_reference("mass2", 1e-3, 10); }

// Element 32 of beamf as stiffness and mass files.
TEST_F(CalculixSuite, CantileverWithASuperelement) {
  expect_reference("beamfsuper", 1e-3, 9);
  const auto deck = read_abaqus(decks_folder() / "beamfsuper.inp");
  ASSERT_EQ(deck.model.matrices.size(), 1u);
  EXPECT_EQ(deck.model.matrices.front().dofs.size(), 60u);
}

// A plate of thickness 0.01 at the clamped side, 0.03 in the middle and 0.02 at the tip by four S8. The reference
// output (19247 Hz) is of elements much too coarse: CalculiX itself gives 12843, 10834 and 10222 Hz with 4 x 4, 8 x 8
// and 16 x 16 S8 and 9943 Hz with 32 x 32 S4. The sixteen linear shells that stand for the four here come near that.
TEST_F(CalculixSuite, CantileverOfQuadraticShellsOfVaryingThickness) {
  const auto deck = read_abaqus(decks_folder() / "shellf.inp");
  EXPECT_EQ(deck.model.mesh.cells.size(), 16u);
  EXPECT_NEAR(frequencies_of(deck.model, 1).front(), 9943.0, 0.05 * 9943.0);
}

class Calculix : public testing::Test {
protected:
  void SetUp() override {
    if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  }

  /// Solves a deck here and by ccx and compares the lowest frequencies.
  static void expect_same(const std::string& deck, std::size_t count, double tolerance,
                          const std::string& step = "*STEP\n") {
    const ScratchFolder folder("decks");
    std::ofstream(folder / "deck.inp") << deck << step << "*FREQUENCY\n" << count << "\n*END STEP\n";
    const bool ran = run_calculix(folder, "deck");
    const auto theirs = frequencies_in(folder / "deck.dat");
    const auto read = read_abaqus(folder / "deck.inp");
    ASSERT_TRUE(ran);
    expect_close(frequencies_of(read.model, static_cast<Index>(count)), theirs, tolerance, count);
  }
};

/// Nodes and elements of a straight beam along x with so many B32 elements.
std::string beam_mesh(int elements, double length, const std::string& type = "B32") {
  std::ostringstream text;
  const int per_element = type == "B32" ? 2 : 1;
  text << "*NODE, NSET=all\n";
  for (int i = 0; i <= per_element * elements; ++i)
    text << i + 1 << ", " << length * i / (per_element * elements) << ", 0., 0.\n";
  text << "*ELEMENT, TYPE=" << type << ", ELSET=beam\n";
  for (int i = 0; i < elements; ++i) {
    const int first = 1 + per_element * i;
    text << i + 1 << ", " << first << ", " << first + 1;
    if (per_element == 2) text << ", " << first + 2;
    text << "\n";
  }
  return text.str();
}

/// Nonlinear constraints are linearised by CalculiX at the end of a nonlinear step.
const std::string behind_nonlinear_step = "*STEP, NLGEOM\n*STATIC\n*CLOAD\n30, 1, 0.\n*END STEP\n*STEP, PERTURBATION\n";

const std::string steel = "*MATERIAL, NAME=steel\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7850.\n";

// CalculiX makes solids of its beams and hinders the clamped section from contracting: 1.4 % above Timoshenko's beam in
// the first mode, 2.2 % in the fourth.
constexpr double solid_beam = 0.025;

// Width along n1 (here y) and height along n2 = t x n1 (here z) must not be exchanged: 0.02 by 0.05.
TEST_F(Calculix, RectangularBeam) {
  expect_same(beam_mesh(10, 1.0) + steel +
                  "*BEAM SECTION, ELSET=beam, MATERIAL=steel, SECTION=RECT\n0.02, 0.05\n0., 1., 0.\n"
                  "*BOUNDARY\n1, 1, 6\n",
              4, solid_beam);
}

// Two numbers of CIRC are CalculiX's diameters.
TEST_F(Calculix, RoundBeam) {
  expect_same(beam_mesh(10, 1.0) + steel +
                  "*BEAM SECTION, ELSET=beam, MATERIAL=steel, SECTION=CIRC\n0.04, 0.04\n0., 1., 0.\n"
                  "*BOUNDARY\n1, 1, 6\n",
              4, solid_beam);
}

TEST_F(Calculix, BeamOfFirstOrderWithATipMassAndSprings) {
  expect_same(
      beam_mesh(20, 1.0, "B31") + steel +
          "*BEAM SECTION, ELSET=beam, MATERIAL=steel, SECTION=RECT\n0.02, 0.05\n0., 1., 0.\n"
          "*ELEMENT, TYPE=MASS, ELSET=tip\n100, 21\n*MASS, ELSET=tip\n2.5\n"
          "*ELEMENT, TYPE=SPRING1, ELSET=s1\n101, 11\n*SPRING, ELSET=s1\n2\n5.e5\n"
          "*NODE\n50, 1., -0.3, -0.4\n*ELEMENT, TYPE=SPRINGA, ELSET=sa\n102, 21, 50\n*SPRING, ELSET=sa\n\n3.e5\n"
          "*BOUNDARY\n1, 1, 6\n50, 1, 3\n",
      3, 0.01);
}

/// A block of n x n x m hexahedra, side 1, 1, 2; sets: bottom, top.
std::string block_mesh(int n, int m, const std::string& type = "C3D8") {
  std::ostringstream text, bottom, top;
  text << "*NODE, NSET=all\n";
  const auto id = [&](int i, int j, int k) { return 1 + i + (n + 1) * (j + (n + 1) * k); };
  for (int k = 0; k <= m; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        text << id(i, j, k) << ", " << double(i) / n << ", " << double(j) / n << ", " << 2.0 * k / m << "\n";
        if (k == 0) bottom << id(i, j, k) << ",\n";
        if (k == m) top << id(i, j, k) << ",\n";
      }
  text << "*ELEMENT, TYPE=" << type << ", ELSET=block\n";
  int element = 0;
  for (int k = 0; k < m; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        text << ++element;
        for (int level = 0; level < 2; ++level)
          text << ", " << id(i, j, k + level) << ", " << id(i + 1, j, k + level) << ", " << id(i + 1, j + 1, k + level)
               << ", " << id(i, j + 1, k + level);
        text << "\n";
      }
  text << "*NSET, NSET=bottom\n" << bottom.str() << "*NSET, NSET=top\n" << top.str();
  text << steel << "*SOLID SECTION, ELSET=block, MATERIAL=steel\n";
  return text.str();
}

// Plain C3D8 are the same elements: frequencies agree but for the seven digits of the output.
constexpr double same_element = 1e-6;

TEST_F(Calculix, SupportInTurnedAxes) {
  expect_same(
      block_mesh(2, 3) +
          "*TRANSFORM, NSET=bottom, TYPE=R\n1., 2., 0.5, -2., 1., 0.3\n*BOUNDARY\nbottom, 1\nbottom, 3\n1, 1, 3\n",
      6, same_element);
}

TEST_F(Calculix, SupportInCylindricalAxes) {
  expect_same(
      block_mesh(2, 3) + "*TRANSFORM, NSET=bottom, TYPE=C\n-1., -1., 0., -1., -1., 1.\n*BOUNDARY\nbottom, 2, 3\n", 6,
      same_element);
}

TEST_F(Calculix, Equations) {
  // Top nodes 28 to 36 of the 2 x 2 x 3 block move together along z; one along x as another along y.
  std::string deck = block_mesh(2, 3) + "*BOUNDARY\nbottom, 1, 3\n*EQUATION\n";
  for (int node = 29; node <= 36; ++node) deck += "2\n" + std::to_string(node) + ", 3, 1., 28, 3, -1.\n";
  deck += "3\n30, 1, 1., 34, 2, -0.5, 36, 2,\n-0.5\n";
  deck.replace(deck.rfind("36, 2,\n-0.5"), 11, "36, 2, -0.5");
  expect_same(deck, 6, same_element);
}

TEST_F(Calculix, EquationInTurnedAxes) {
  expect_same(block_mesh(2, 3) +
                  "*NSET, NSET=turned\n30, 34\n*TRANSFORM, NSET=turned, TYPE=R\n1., 1., 0., -1., 1., 0.\n"
                  "*BOUNDARY\nbottom, 1, 3\n*EQUATION\n2\n30, 1, 1., 34, 2, -1.\n",
              6, same_element);
}

TEST_F(Calculix, RigidBodyWithAMass) {
  expect_same(block_mesh(2, 3) +
                  "*NODE\n200, 0.5, 0.5, 2.5\n201, 0.5, 0.5, 2.5\n*RIGID BODY, NSET=top, REF NODE=200, ROT NODE=201\n"
                  "*ELEMENT, TYPE=MASS, ELSET=m\n500, 200\n*MASS, ELSET=m\n5000.\n*BOUNDARY\nbottom, 1, 3\n",
              5, same_element);
}

TEST_F(Calculix, PlaneStaysPlane) {
  expect_same(block_mesh(2, 3) + "*MPC\nPLANE, 28, 30, 36, 29, 31, 32, 33, 34, 35\n*BOUNDARY\nbottom, 1, 3\n", 5,
              same_element, behind_nonlinear_step);
}

TEST_F(Calculix, LineStaysStraight) {
  expect_same(block_mesh(2, 3) + "*MPC\nSTRAIGHT, 28, 30, 29\n*BOUNDARY\nbottom, 1, 3\n", 5, same_element,
              behind_nonlinear_step);
}

TEST_F(Calculix, SpringsBetweenNodes) {
  expect_same(block_mesh(2, 3) +
                  "*ELEMENT, TYPE=SPRING2, ELSET=s2\n500, 28, 32\n*SPRING, ELSET=s2\n1, 1\n1.e10\n"
                  "*ELEMENT, TYPE=SPRINGA, ELSET=sa\n501, 10, 36\n*SPRING, ELSET=sa\n\n3.e10\n"
                  "*BOUNDARY\nbottom, 1, 3\n",
              6, same_element);
}

/// A plate of n x n S4 in the x-y plane, clamped at x = 0, with an upright flange of n x n/2 at x = 1.
std::string angle_mesh(int n, const std::string& offset) {
  std::ostringstream nodes, plate, flange, edge;
  for (int k = 0; k <= n / 2; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = k == 0 ? 0 : n; i <= n; ++i) {
        const int id = 1 + i + 100 * j + 10000 * k;
        nodes << id << ", " << double(i) / n << ", " << double(j) / n << ", " << double(k) / n << "\n";
        if (i == 0) edge << id << ",\n";
      }
  int element = 0;
  const auto add = [&](std::ostringstream& list, int first, int along, int across) {
    list << ++element << ", " << first << ", " << first + along << ", " << first + along + across << ", "
         << first + across << "\n";
  };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) add(plate, 1 + i + 100 * j, 1, 100);
  for (int k = 0; k < n / 2; ++k)
    for (int j = 0; j < n; ++j) add(flange, 1 + n + 100 * j + 10000 * k, 100, 10000);
  return "*NODE\n" + nodes.str() + "*ELEMENT, TYPE=S4, ELSET=plate\n" + plate.str() +
         "*ELEMENT, TYPE=S4, ELSET=flange\n" + flange.str() + "*NSET, NSET=edge\n" + edge.str() + steel +
         "*SHELL SECTION, ELSET=plate, MATERIAL=steel, OFFSET=" + offset +
         "\n0.05\n*SHELL SECTION, ELSET=flange, MATERIAL=steel\n0.05\n*BOUNDARY\nedge, 1, 6\n";
}

// Two shell formulations on one mesh differ by 0.5 %. The flange tells the sides of the plate apart: by 8 % in the
// third frequency between offsets of 0.5 and -0.5 thicknesses, by 37 % between 2 and -2.
TEST_F(Calculix, ShellsWithAnOffset) {
  for (const std::string offset : {"0.5", "-0.5", "2.", "-2."}) expect_same(angle_mesh(12, offset), 6, 0.012);
}

}  // namespace
}  // namespace kalfem
