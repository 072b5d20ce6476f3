// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "formats/abaqus_decks.hpp"

namespace kalfem {
namespace {

const std::string line = "*NODE\n1,0,0,0\n2,2,0,0\n*ELEMENT, TYPE=B31, ELSET=e\n1,1,2\n";
const std::string square = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n*ELEMENT, TYPE=S4, ELSET=e\n1,1,2,3,4\n";

BeamProperty beam_of(const std::string& section) {
  return std::get<BeamProperty>(parse_deck(line + deck_steel + section).model.properties.at("e"));
}

// Every tolerance of this file is a rounding of what is compared: 1e-15 to 1e-14 of it.

// Direction 1 of the deck is y here, 2 is t x n1 = z. kalfem's local z is direction 1.
TEST(AbaqusSections, RectangleHasItsWidthAlongDirectionOne) {
  const auto beam = beam_of("*BEAM SECTION, ELSET=e, MATERIAL=steel, SECTION=RECT\n0.1, 0.2\n0., 1., 0.\n");
  EXPECT_TRUE(beam.placement(0).up.isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_NEAR(beam.section.inertia_y, 0.2 * std::pow(0.1, 3) / 12, 1e-20);  // bending along y
  EXPECT_NEAR(beam.section.inertia_z, 0.1 * std::pow(0.2, 3) / 12, 1e-20);
}

TEST(AbaqusSections, RoundSectionsByRadiusOrTwoDiameters) {
  const double pi = std::numbers::pi;
  EXPECT_NEAR(beam_of("*BEAM SECTION, ELSET=e, MATERIAL=steel, SECTION=CIRC\n0.1\n").section.area, pi * 0.01, 3e-17);
  EXPECT_NEAR(beam_of("*BEAM SECTION, ELSET=e, MATERIAL=steel, SECTION=CIRC\n0.1, 0.1\n").section.area, pi * 0.0025,
              3e-17);
  EXPECT_NEAR(beam_of("*BEAM SECTION, ELSET=e, MATERIAL=steel, SECTION=PIPE\n0.1, 0.02\n").section.area,
              pi * (0.01 - 0.0064), 3e-17);
}

// Unequal flanges; origin at the underside. Hand calculation.
TEST(AbaqusSections, IProfileHasItsCentroidAndShearCentreAsideOfTheNodes) {
  const auto beam =
      beam_of("*BEAM SECTION, ELSET=e, MATERIAL=steel, SECTION=I\n0., 0.2, 0.1, 0.05, 0.01, 0.01, 0.008\n0., 1., 0.\n");
  const double web = 0.18 * 0.008, low = 0.1 * 0.01, high = 0.05 * 0.01, area = web + low + high;
  const double centroid = (web * 0.1 + low * 0.005 + high * 0.195) / area;
  const double shear = 0.005 + 0.19 * std::pow(0.05, 3) / (std::pow(0.05, 3) + std::pow(0.1, 3));
  EXPECT_NEAR(beam.section.area, area, 1e-17);
  // Direction 2 is global z: the beam's line lies there above the nodes.
  EXPECT_TRUE(beam.placement(0).offsets.col(0).isApprox(Eigen::Vector3d(0, 0, shear)));
  EXPECT_NEAR(beam.section.centroid.x(), -(centroid - shear), 3e-16);  // local y is against direction 2
  EXPECT_NEAR(beam.section.centroid.y(), 0.0, 3e-16);
  EXPECT_NEAR(beam.section.torsion, (0.18 * std::pow(0.008, 3) + 0.15 * std::pow(0.01, 3)) / 3, 1e-21);
}

TEST(AbaqusSections, BoxAndAngleByRectangles) {
  const auto box =
      beam_of("*BEAM SECTION, ELSET=e, MATERIAL=steel, SECTION=BOX\n0.1, 0.2, 0.01, 0.01, 0.01, 0.01\n0,1,0\n").section;
  const auto same = rectangular_tube_section(0.2, 0.1, 0.01);
  EXPECT_NEAR(box.area, same.area, 1e-17);
  EXPECT_NEAR(box.inertia_y, same.inertia_y, 1e-20);
  EXPECT_NEAR(box.torsion, same.torsion, 3e-20);
  const auto angle =
      beam_of("*BEAM SECTION, ELSET=e, MATERIAL=steel, SECTION=L\n0.1, 0.1, 0.01, 0.01\n0,1,0\n").section;
  EXPECT_NEAR(angle.area, 0.0019, 3e-18);
  EXPECT_NEAR(angle.inertia_y, angle.inertia_z, 3e-21);
  EXPECT_GT(angle.product_yz, 0.0);  // I12 < 0 with legs along +1 and +2, and local y is against 2
}

TEST(AbaqusSections, GeneralBeamWithModuliOfItsOwn) {
  const auto deck = parse_deck(line +
                               "*BEAM GENERAL SECTION, ELSET=e, SECTION=GENERAL, DENSITY=1000.\n0.01, 2e-6, 3e-7, "
                               "1e-6, 4e-6\n0., 1., 0.\n1e10, 4e9\n");
  const auto& beam = std::get<BeamProperty>(deck.model.properties.at("e"));
  EXPECT_NEAR(beam.section.inertia_z, 2e-6, 1e-20);
  EXPECT_NEAR(beam.section.inertia_y, 1e-6, 1e-20);
  EXPECT_NEAR(beam.section.product_yz, -3e-7, 1e-20);
  EXPECT_NEAR(deck.model.materials.at(beam.material).poissons_ratio, 0.25, 1e-15);
  EXPECT_EQ(deck.model.materials.at(beam.material).density, 1000.0);
}

TEST(AbaqusSections, ReleasedEndsAndExtraNodes) {
  const auto deck =
      parse_deck("*NODE\n1,0,0,0\n2,2,0,0\n3,0,0,5\n*ELEMENT, TYPE=B31, ELSET=e\n1,1,2,3\n*RELEASE\ne, S2, M1-T\n" +
                 deck_steel + "*BEAM SECTION, ELSET=e, MATERIAL=steel, SECTION=RECT\n0.1, 0.2\n");
  const auto& placement = std::get<BeamProperty>(deck.model.properties.at("e")).placement(0);
  EXPECT_TRUE(placement.up.normalized().isApprox(Eigen::Vector3d::UnitZ()));
  // The moment about axis 1 is that about local z.
  EXPECT_EQ(placement.released,
            (std::array<bool, 12>{false, false, false, false, false, false, false, false, false, true, false, true}));
}

// The reference surface, where the nodes are, lies half a thickness above the middle.
TEST(AbaqusSections, ShellOffsetIsThatOfTheReferenceSurface) {
  const auto deck = parse_deck(square + deck_steel + "*SHELL SECTION, ELSET=e, MATERIAL=steel, OFFSET=SPOS\n0.02\n");
  EXPECT_NEAR(std::get<ShellProperty>(deck.model.properties.at("e")).offset, -0.01, 1e-17);
}

const std::string lamina =
    "*MATERIAL, NAME=ply\n*ELASTIC, TYPE=LAMINA\n100e9, 10e9, 0.3, 5e9, 5e9, 4e9\n*DENSITY\n1500.\n";

TEST(AbaqusSections, LayersWithAnglesAndTheirOrientation) {
  const auto deck =
      parse_deck(square + lamina +
                 "*ORIENTATION, NAME=o\n0,1,0,-1,0,0\n3, 0.\n*SHELL SECTION, ELSET=e, COMPOSITE, ORIENTATION=o\n"
                 "0.001, 3, ply, 0.\n0.002, 3, ply, 90.\n");
  const auto& laminate = std::get<LaminateProperty>(deck.model.properties.at("e"));
  EXPECT_NEAR(laminate.mass, 4.5, 1e-14);
  EXPECT_TRUE(laminate.direction(0).isApprox(Eigen::Vector3d::UnitY()));
  const double c = 1.0 - 0.3 * 0.3 * 0.1;
  EXPECT_NEAR(laminate.stiffness.membrane(0, 0), (100e9 * 0.001 + 10e9 * 0.002) / c, 3e-7);
  EXPECT_NEAR(laminate.stiffness.membrane(1, 1), (10e9 * 0.001 + 100e9 * 0.002) / c, 3e-7);
}

// Without an orientation local 1 is global x laid into the surface.
TEST(AbaqusSections, OrthotropicShellWithoutOrientation) {
  const auto deck = parse_deck(square + lamina + "*SHELL SECTION, ELSET=e, MATERIAL=ply\n0.001\n");
  EXPECT_TRUE(
      std::get<LaminateProperty>(deck.model.properties.at("e")).direction(0).isApprox(Eigen::Vector3d::UnitX()));
}

TEST(AbaqusSections, DirectShellStiffness) {
  const auto deck = parse_deck(square +
                               "*SHELL GENERAL SECTION, ELSET=e, DENSITY=7.\n1, 2, 3, 4, 5, 6, 7, 8\n9, 10, 11, 12, "
                               "13, 14, 15, 16\n17, 18, 19, 20, 21\n");
  const auto& laminate = std::get<LaminateProperty>(deck.model.properties.at("e"));
  EXPECT_EQ(laminate.stiffness.membrane(1, 2), 5.0);
  EXPECT_EQ(laminate.stiffness.coupling(0, 0), 7.0);
  EXPECT_EQ(laminate.stiffness.bending(2, 2), 21.0);
  EXPECT_EQ(laminate.mass, 7.0);
  EXPECT_NEAR(laminate.stiffness.shear(0, 0), (1.0 + 3.0) / 6.0 + 6.0 / 3.0, 1e-14);
}

const std::string cube =
    "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n*ELEMENT, TYPE=C3D8, "
    "ELSET=e\n1,1,2,3,4,5,6,7,8\n";
const std::string orthotropic =
    "*MATERIAL, NAME=wood\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n12e9, 1e9, 0.5e9, 0.4, 0.45, 0.5, 0.8e9, "
    "0.7e9\n0.1e9\n*DENSITY\n500.\n";

/// 1 / (n n : S : n n): Young's modulus along a direction.
double modulus_along(const Matrix6& stiffness, const Eigen::Vector3d& n) {
  Eigen::Matrix<double, 6, 1> s;
  s << n.x() * n.x(), n.y() * n.y(), n.z() * n.z(), n.x() * n.y(), n.y() * n.z(), n.x() * n.z();
  return 1.0 / s.dot(stiffness.inverse() * s);
}

TEST(AbaqusSections, OrthotropicSolidInTurnedAxes) {
  const auto deck =
      parse_deck(cube + orthotropic +
                 "*ORIENTATION, NAME=o\n1,1,0,-1,1,0\n*SOLID SECTION, ELSET=e, MATERIAL=wood, ORIENTATION=o\n");
  const auto& stiffness = *std::get<SolidProperty>(deck.model.properties.at("e")).elasticity;
  EXPECT_NEAR(modulus_along(stiffness, Eigen::Vector3d(1, 1, 0).normalized()), 12e9, 1e-4);
  EXPECT_NEAR(modulus_along(stiffness, Eigen::Vector3d(-1, 1, 0).normalized()), 1e9, 1e-5);
  EXPECT_NEAR(modulus_along(stiffness, Eigen::Vector3d::UnitZ()), 0.5e9, 5e-6);
  // At 45 degrees between 1 and 3: 4 / E = 1/E1 + 1/E3 + 1/G13 - 2 nu13/E1.
  EXPECT_NEAR(
      4.0 / modulus_along(stiffness, (Eigen::Vector3d(1, 1, 0).normalized() + Eigen::Vector3d::UnitZ()).normalized()),
      1 / 12e9 + 1 / 0.5e9 + 1 / 0.7e9 - 0.9 / 12e9, 3e-23);
}

TEST(AbaqusSections, CylindricalAxesGiveARegionForEachDirection) {
  const auto deck = parse_deck(
      "*NODE\n1,1,0,0\n2,2,0,0\n3,2,1,0\n4,1,1,0\n5,1,0,1\n6,2,0,1\n7,2,1,1\n8,1,1,1\n9,2,3,0\n10,1,3,0\n11,2,3,1\n12,"
      "1,3,1\n"
      "*ELEMENT, TYPE=C3D8, ELSET=e\n1,1,2,3,4,5,6,7,8\n2,4,3,9,10,8,7,11,12\n" +
      orthotropic +
      "*ORIENTATION, NAME=o, SYSTEM=CYLINDRICAL\n0,0,0,0,0,1\n*SOLID SECTION, ELSET=e, MATERIAL=wood, ORIENTATION=o\n");
  ASSERT_EQ(deck.model.mesh.regions.size(), 2u);
  const auto& second = *std::get<SolidProperty>(deck.model.properties.at("e.2")).elasticity;
  EXPECT_NEAR(modulus_along(second, Eigen::Vector3d(1.5, 2.0, 0).normalized()), 12e9, 1e-4);
}

}  // namespace
}  // namespace kalfem
