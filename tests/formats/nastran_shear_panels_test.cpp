// SPDX-License-Identifier: Apache-2.0
// Shear panels of Nastran decks against closed forms; E = 7e10, nu = 0.3, rho = 2700.
#include <gtest/gtest.h>

#include "formats/nastran_decks.hpp"

namespace kalfem {
namespace {

using test::aluminium;
using test::displacements;

constexpr double modulus = 7e10, poisson = 0.3, shear_modulus = modulus / (2.0 * (1.0 + poisson)), thickness = 0.002;

std::string grid(int id, double x, double y, const std::string& held = "3456") {
  return "GRID," + std::to_string(id) + ",," + std::to_string(x) + "," + std::to_string(y) + ",0.,," + held + "\n";
}

/// A panel on a base that is held, of height h, its upper edge moved along x by `lean`; its rods keep the edges'
/// lengths.
std::string panel(double length, double height, double lean) {
  return grid(1, 0, 0, "123456") + grid(2, length, 0, "123456") + grid(3, length + lean, height) +
         grid(4, lean, height) + aluminium + "PSHEAR,5,1,.002\nCSHEAR,7,5,1,2,3,4\n";
}

/// Stiff rods along the three free edges leave only the shear of the panel: the upper edge moves by q times the length
/// over the stiffness, F = q a with U = q^2 A c / (2 G t).
double moved(double length, double height, double lean) {
  const std::string rods = "CONROD,11,4,3,2,1.\nCONROD,12,2,3,2,1.\nCONROD,13,1,4,2,1.\nMAT1,2,1.+15,,.3\n";
  const auto deck = test::nastran(panel(length, height, lean) + rods);
  const auto found = displacements(deck.model, {{{2, 0}, 500.0}, {{3, 0}, 500.0}});
  return found[6 * 2];
}

TEST(NastranShearPanels, ShearAsRectangles) {
  const double length = 0.4, height = 0.25, force = 1000.0;
  EXPECT_NEAR(moved(length, height, 0.0) / (force * height / (shear_modulus * thickness * length)), 1.0, 1e-6);
}

/// At the angle phi the stress along the edges adds 2 cot^2 phi / (1 + nu) to the energy.
TEST(NastranShearPanels, ShearAsParallelograms) {
  const double length = 0.4, height = 0.25, force = 1000.0;
  for (const double lean : {0.1, -0.3}) {
    const double cotangent = lean / height, factor = 1.0 + 2.0 * cotangent * cotangent / (1.0 + poisson);
    EXPECT_NEAR(moved(length, height, lean) / (force * height * factor / (shear_modulus * thickness * length)), 1.0,
                1e-6)
        << lean;
  }
}

/// A spar of booms, ribs and webs, loaded at its tip: bending by the booms, each with the force at the middle of its
/// bay, and shear by the webs.
TEST(NastranShearPanels, AreTheWebsOfASpar) {
  constexpr int bays = 5;
  constexpr double bay = 0.3, height = 0.2, boom = 4e-4, force = 2000.0;
  std::string text = aluminium + "PSHEAR,5,1,.002\nPROD,6,1,4.-4\n";
  for (int i = 0; i <= bays; ++i) {
    const std::string held = i == 0 ? "123456" : "3456";
    text += grid(2 * i + 1, i * bay, 0.0, held) + grid(2 * i + 2, i * bay, height, held);
    const auto n = [&](int offset) { return std::to_string(2 * i + offset); };
    const auto element = [&](int kind) { return std::to_string(100 * kind + i); };
    if (i > 0) text += "CROD," + element(3) + ",6," + n(1) + "," + n(2) + "\n";
    if (i < bays)
      text += "CROD," + element(1) + ",6," + n(1) + "," + n(3) + "\nCROD," + element(2) + ",6," + n(2) + "," + n(4) +
              "\nCSHEAR," + element(4) + ",5," + n(1) + "," + n(3) + "," + n(4) + "," + n(2) + "\n";
  }
  const auto deck = test::nastran(text);
  const auto found = displacements(deck.model, {{{2 * bays, 1}, 0.5 * force}, {{2 * bays + 1, 1}, 0.5 * force}});
  double expected = force * bays * bay / (shear_modulus * thickness * height);
  for (int i = 0; i < bays; ++i) {
    const double arm = (bays - i - 0.5) * bay;
    expected += 2.0 * force * arm * arm * bay / (height * height * modulus * boom);
  }
  EXPECT_NEAR(found[6 * 2 * bays + 1] / expected, 1.0, 1e-9);
}

TEST(NastranShearPanels, HaveMassAndEdges) {
  const auto deck = test::nastran(panel(0.4, 0.25, 0.0) + "CONROD,11,4,3,1,1.-6\n");
  EXPECT_NEAR(test::masses(deck.model).mass, 2700.0 * (0.4 * 0.25 * 0.002 + 0.4e-6), 1e-12);
  auto text = panel(0.4, 0.25, 0.0);
  text.replace(text.find("PSHEAR,5,1,.002"), 15, "PSHEAR,5,1,.002,3.,.5,2.");
  const auto edged = test::nastran(text).model;
  EXPECT_NEAR(test::masses(edged).mass, 0.4 * 0.25 * (2700.0 * 0.002 + 3.0), 1e-12);
  const auto stiffness = [&](const std::string& name) {
    const auto found = std::ranges::find(edged.joints, name, &JointSpring::name);
    return found == edged.joints.end() ? 0.0 : found->stiffness;
  };
  EXPECT_DOUBLE_EQ(stiffness("cshear7.e1"), modulus * 0.5 * 0.002 * 0.4 * 0.25 / 0.8 / 0.4);
  EXPECT_DOUBLE_EQ(stiffness("cshear7.e2"), modulus * 0.5 * 2.0 * 0.002 * 0.002 / 0.25);
}

TEST(NastranShearPanels, AreCheckedForTheirShape) {
  EXPECT_TRUE(test::has_note(test::nastran(grid(1, 0, 0, "123456") + grid(2, 1, 0, "123456") + grid(3, 0.8, 1) +
                                           grid(4, 0.2, 1) + aluminium + "PSHEAR,5,1,.002\nCSHEAR,7,5,1,2,3,4\n"),
                             "CSHEAR that is no parallelogram"));
  const auto line = test::nastran_problem(grid(1, 0, 0) + grid(2, 1, 0) + grid(3, 2, 0) + grid(4, 3, 0) + aluminium +
                                          "PSHEAR,5,1,.002\nCSHEAR,7,5,1,2,3,4\n");
  EXPECT_NE(line.find("CSHEAR 7 has no area"), std::string::npos) << line;
  const auto thin = test::nastran_problem(panel(1, 1, 0) + "PSHEAR,6,1,0.\n");
  EXPECT_NE(thin.find("T is not positive"), std::string::npos) << thin;
  const auto sheet =
      test::nastran_problem(panel(1, 1, 0) + "MAT8,9,7.+10,7.+10,.3,2.+10\nPSHEAR,6,9,.01\nCSHEAR,8,6,1,2,3,4\n");
  EXPECT_NE(sheet.find("its material is not isotropic"), std::string::npos) << sheet;
}

}  // namespace
}  // namespace kalfem
