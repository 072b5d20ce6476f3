// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "formats/abaqus_decks.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// One free element of a type, with its section and its mass.
struct ElementCase {
  std::string type;
  std::string corners;  ///< which of the shapes below
  int nodes;
  std::string section;
  double mass;
};

constexpr double steel = 7850.0;  ///< its density [kg/m^3]
const std::string solid = "*SOLID SECTION, ELSET=e, MATERIAL=steel\n";
const std::string shell = "*SHELL SECTION, ELSET=e, MATERIAL=steel\n0.01\n";
const std::string beam = "*BEAM SECTION, ELSET=e, MATERIAL=steel, SECTION=RECT\n0.1, 0.2\n0., 1., 0.\n";

/// Nodes in the order of the deck: unit tetrahedron, wedge, cube, triangle, square, line along x.
std::string nodes_of(const std::string& shape) {
  if (shape == "tetrahedron")
    return "1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,.5,0,0\n6,.5,.5,0\n7,0,.5,0\n8,0,0,.5\n9,.5,0,.5\n10,0,.5,.5\n";
  if (shape == "wedge")
    return "1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,0,1\n6,0,1,1\n7,.5,0,0\n8,.5,.5,0\n9,0,.5,0\n10,.5,0,1\n11,.5,.5,"
           "1\n"
           "12,0,.5,1\n13,0,0,.5\n14,1,0,.5\n15,0,1,.5\n";
  if (shape == "cube")
    return "1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n9,.5,0,0\n10,1,.5,0\n11,.5,1,0\n12,"
           "0,.5,0\n"
           "13,.5,0,1\n14,1,.5,1\n15,.5,1,1\n16,0,.5,1\n17,0,0,.5\n18,1,0,.5\n19,1,1,.5\n20,0,1,.5\n";
  if (shape == "triangle") return "1,0,0,0\n2,1,0,0\n3,0,1,0\n4,.5,0,0\n5,.5,.5,0\n6,0,.5,0\n";
  if (shape == "square") return "1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,.5,0,0\n6,1,.5,0\n7,.5,1,0\n8,0,.5,0\n";
  if (shape == "line3") return "1,0,0,0\n2,1,0,0\n3,2,0,0\n";
  return "1,0,0,0\n2,2,0,0\n";
}

class AbaqusElement : public testing::TestWithParam<ElementCase> {};

TEST_P(AbaqusElement, HasItsMassAndMovesWithoutForce) {
  const auto& item = GetParam();
  std::string deck = "*NODE\n" + nodes_of(item.corners) + "*ELEMENT, TYPE=" + item.type + ", ELSET=e\n1";
  for (int i = 1; i <= item.nodes; ++i) deck += "," + std::string(i == 10 ? "\n" : "") + std::to_string(i);
  const Matrices matrices(parse_deck(deck + "\n" + deck_steel + item.section).model);
  const double scale = matrices.stiffness.coeffs().cwiseAbs().maxCoeff();
  for (int axis = 0; axis < 3; ++axis) {
    const auto motion = matrices.translation(axis);
    EXPECT_NEAR(motion.dot(matrices.mass * motion), item.mass, 2e-14 * item.mass);  // rounding
    if (item.type != "T3D2") {
      EXPECT_LT((matrices.stiffness * motion).cwiseAbs().maxCoeff(), 2e-14 * scale);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Types, AbaqusElement,
    testing::Values(
        ElementCase{"C3D4", "tetrahedron", 4, solid, steel / 6},
        ElementCase{"C3D10", "tetrahedron", 10, solid, steel / 6},
        ElementCase{"C3D10M", "tetrahedron", 10, solid, steel / 6}, ElementCase{"C3D6", "wedge", 6, solid, steel / 2},
        ElementCase{"C3D15", "wedge", 15, solid, steel / 2}, ElementCase{"C3D8", "cube", 8, solid, steel},
        ElementCase{"C3D8I", "cube", 8, solid, steel}, ElementCase{"C3D8R", "cube", 8, solid, steel},
        ElementCase{"C3D8H", "cube", 8, solid, steel}, ElementCase{"C3D20", "cube", 20, solid, steel},
        ElementCase{"C3D20R", "cube", 20, solid, steel}, ElementCase{"S3", "triangle", 3, shell, steel * 0.005},
        ElementCase{"S3R", "triangle", 3, shell, steel * 0.005}, ElementCase{"S6", "triangle", 6, shell, steel * 0.005},
        ElementCase{"STRI65", "triangle", 6, shell, steel * 0.005}, ElementCase{"S4", "square", 4, shell, steel * 0.01},
        ElementCase{"S4R", "square", 4, shell, steel * 0.01}, ElementCase{"S8", "square", 8, shell, steel * 0.01},
        ElementCase{"S8R", "square", 8, shell, steel * 0.01}, ElementCase{"S8R5", "square", 8, shell, steel * 0.01},
        ElementCase{"M3D4", "square", 4, "*MEMBRANE SECTION, ELSET=e, MATERIAL=steel\n0.01\n", steel * 0.01},
        ElementCase{"B31", "line", 2, beam, steel * 0.04}, ElementCase{"B33", "line", 2, beam, steel * 0.04},
        ElementCase{"B31H", "line", 2, beam, steel * 0.04}, ElementCase{"B32", "line3", 3, beam, steel * 0.04},
        ElementCase{"B32R", "line3", 3, beam, steel * 0.04}, ElementCase{"PIPE31", "line", 2, beam, steel * 0.04}),
    [](const auto& each) { return each.param.type; });

TEST(AbaqusElements, SolidsOfSeveralKindsGetRegionsOfTheirOwn) {
  const auto deck = parse_deck("*NODE\n" + nodes_of("cube") + "*ELEMENT, TYPE=C3D8I, ELSET=all\n1,1,2,3,4,5,6,7,8\n" +
                               "*ELEMENT, TYPE=C3D8R, ELSET=all\n2,1,2,3,4,5,6,7,8\n" + deck_steel +
                               "*SOLID SECTION, ELSET=all, MATERIAL=steel\n");
  EXPECT_EQ(std::get<SolidProperty>(deck.model.properties.at("all")).kind, SolidKind::standard);
  EXPECT_EQ(std::get<SolidProperty>(deck.model.properties.at("all.2")).kind, SolidKind::reduced);
}

TEST(AbaqusElements, BrickWithTwoPairsOfNodesInOneIsAWedge) {
  const auto deck = parse_deck("*NODE\n" + nodes_of("wedge") + "*ELEMENT, TYPE=C3D8, ELSET=e\n1,1,2,3,3,4,5,6,6\n" +
                               deck_steel + solid);
  EXPECT_EQ(deck.model.mesh.cells.front().shape, CellShape::wedge6);
}

// Two trusses at right angles: along x (length 2) the node is held by E A / L and one half of the mass.
TEST(AbaqusElements, TrussIsASpringWithHalfItsMassAtEachEnd) {
  const auto deck = parse_deck(
      "*NODE\n1,0,0,0\n2,2,0,0\n3,2,1,0\n4,2,0,1\n*ELEMENT, TYPE=T3D2, ELSET=e\n1,1,2\n2,3,2\n3,4,2\n" + deck_steel +
      "*SOLID SECTION, ELSET=e, MATERIAL=steel\n1.e-4\n*BOUNDARY\n1,PINNED\n3,PINNED\n4,PINNED\n");
  const Matrices matrices(deck.model);
  ASSERT_EQ(matrices.model.size(), 3);
  EXPECT_NEAR(matrices.stiffness.coeff(0, 0), 2.1e11 * 1e-4 / 2.0, 1e-8);  // rounding of 1e7
  EXPECT_NEAR(matrices.stiffness.coeff(1, 1), 2.1e11 * 1e-4, 1e-8);
  EXPECT_NEAR(matrices.mass.coeff(0, 0), steel * 1e-4 * 2.0, 1e-15);
}

TEST(AbaqusElements, SpringsAndDashpotsOfEveryKind) {
  const auto deck = parse_deck(
      "*NODE\n1,0,0,0\n2,3,4,0\n*ELEMENT, TYPE=SPRING1, ELSET=a\n1,1\n*SPRING, ELSET=a\n5\n7.\n"
      "*ELEMENT, TYPE=SPRING2, ELSET=b\n2,1,2\n*SPRING, ELSET=b\n1,3\n8.\n*ELEMENT, TYPE=SPRINGA, "
      "ELSET=c\n3,1,2\n*SPRING, ELSET=c\n\n9.\n"
      "*ELEMENT, TYPE=DASHPOTA, ELSET=d\n4,1,2\n*DASHPOT, ELSET=d\n\n2.\n"
      "*ORIENTATION, NAME=o\n0,1,0,-1,0,0\n*ELEMENT, TYPE=SPRING1, ELSET=e\n5,2\n*SPRING, ELSET=e, "
      "ORIENTATION=o\n1\n6.\n"
      "*ELEMENT, TYPE=SPRING1, ELSET=n\n6,2\n*SPRING, ELSET=n, NONLINEAR\n1\n-2.,-1.\n0.,0.\n3.,1.\n");
  const auto& model = deck.model;
  ASSERT_EQ(model.springs.size(), 3u);
  EXPECT_EQ(model.springs[0].from, (NodalDof{0, 4}));
  EXPECT_EQ(model.springs[0].stiffness, 7.0);
  EXPECT_EQ(*model.springs[1].to, (NodalDof{1, 2}));
  EXPECT_EQ(model.springs[2].stiffness, 3.0);  // the slope at rest
  ASSERT_EQ(model.joints.size(), 3u);
  const auto coefficient = [&](const JointSpring& joint, NodalDof dof) {
    double sum = 0.0;
    for (const auto& [other, share] : joint.deformation)
      if (other == dof) sum += share;
    return sum;
  };
  EXPECT_EQ(model.joints[0].name, "c.3");
  // rounding
  EXPECT_NEAR(coefficient(model.joints[0], {1, 0}), 0.6, 1e-15);
  EXPECT_NEAR(coefficient(model.joints[0], {0, 1}), -0.8, 1e-15);
  EXPECT_NEAR(coefficient(model.joints[1], {1, 1}), 1.0, 1e-15);  // axis 1 of the orientation is y
  EXPECT_EQ(model.joints[2].damping, 2.0);
}

TEST(AbaqusElements, MassesAndInertiasInTheAxesOfTheirOrientation) {
  const auto deck = parse_deck(
      "*NODE\n1,0,0,0\n*ELEMENT, TYPE=MASS, ELSET=m\n1,1\n*MASS, ELSET=m\n3.\n*ORIENTATION, NAME=o\n0,1,0,-1,0,0\n"
      "*ELEMENT, TYPE=ROTARYI, ELSET=r\n2,1\n*ROTARY INERTIA, ELSET=r, ORIENTATION=o\n1.,2.,3.,0.1,0.2,0.3\n");
  ASSERT_EQ(deck.model.masses.size(), 2u);
  EXPECT_EQ(deck.model.masses[0].mass, 3.0);
  // Local 1 is y, local 2 is -x, local 3 is z.
  Eigen::Matrix3d expected;
  expected << 2.0, -0.1, -0.3, -0.1, 1.0, 0.2, -0.3, 0.2, 3.0;
  EXPECT_TRUE(deck.model.masses[1].inertia.isApprox(expected, 1e-14));
}

TEST(AbaqusElements, NonstructuralMassIsSpreadOverItsElements) {
  const auto deck = parse_deck("*NODE\n" + nodes_of("square") + "*ELEMENT, TYPE=S4, ELSET=e\n1,1,2,3,4\n" + deck_steel +
                               shell + "*NONSTRUCTURAL MASS, ELSET=e, UNITS=MASS PER AREA\n12.\n");
  double total = 0.0;
  for (const auto& mass : deck.model.masses) total += mass.mass;
  EXPECT_NEAR(total, 12.0, 1e-14);  // rounding
}

}  // namespace
}  // namespace kalfem
