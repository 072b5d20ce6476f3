// SPDX-License-Identifier: Apache-2.0
// Springs, masses, rigid and weighted links, constraints and direct matrices, also in turned axes, against answers by
// hand.
#include <gtest/gtest.h>

#include "formats/nastran_decks.hpp"

namespace kalfem {
namespace {

using test::displacements;
using test::frequencies;

constexpr double rounding = 3e-14;  ///< of numbers of about one; found up to 3e-15

/// Axes 7: turned by 90 degrees about z, so that its 1 is basic y and its 2 is minus basic x; 8: by 30 degrees.
const std::string systems =
    "CORD2R,7,0,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\n"
    "CORD2R,8,0,0.,0.,0.,0.,0.,1.\n,.86602540378443865,.5,0.\n";

TEST(NastranSprings, ActInTheAxesOfTheirNodes) {
  const auto deck = test::nastran(
      systems + "PARAM,AUTOSPC,NO\nGRID,1,,,,,7\nCELAS2,1,4.,1,1\nPELAS,9,5.\nCELAS1,2,9,1,2\nCELAS2,3,6.,0,0,1,3\n");
  const auto moved = displacements(deck.model, {{{0, 0}, 10.0}, {{0, 1}, 8.0}, {{0, 2}, 6.0}});
  EXPECT_NEAR(moved[0], 2.0, rounding);
  EXPECT_NEAR(moved[1], 2.0, rounding);
  EXPECT_NEAR(moved[2], 1.0, rounding);
}

TEST(NastranSprings, MayJoinScalarPointsAndDampers) {
  const auto deck = test::nastran(
      "SPOINT,1,2\nCELAS4,1,100.,1\nCELAS4,2,50.,1,2\nCMASS4,3,1.,1\nCMASS2,4,1.,2,0\nCDAMP2,5,3.,1,,2\n");
  const auto assembled = assemble(deck.model);
  EXPECT_EQ(assembled.size(), 2);
  EXPECT_NEAR(Eigen::MatrixXd(assembled.damping)(0, 1), -3.0, rounding);
  const auto found = frequencies(deck.model, 2);
  // K = [150 -50; -50 50]: eigenvalues 100 -+ 50 sqrt 2.
  EXPECT_NEAR(found[0], std::sqrt(100.0 - 50.0 * std::sqrt(2.0)) / (2.0 * std::numbers::pi), rounding);
}

TEST(NastranSprings, MayPush) {
  const auto deck = test::nastran("GRID,1\nCELAS2,1,10.,1,1\nCELAS2,2,-4.,1,1\n");
  EXPECT_NEAR(displacements(deck.model, {{{0, 0}, 6.0}})[0], 1.0, rounding);
}

TEST(NastranSprings, InLargeNumbersAreOneMatrix) {
  std::string text = "GRID,1\n";
  for (int i = 1; i <= 600; ++i) text += "CELAS2," + std::to_string(i) + ",1.,1,1\n";
  const auto deck = test::nastran(text);
  EXPECT_TRUE(deck.model.joints.empty());
  EXPECT_NEAR(displacements(deck.model, {{{0, 0}, 600.0}})[0], 1.0, rounding);
}

/// A bushing 2 above the clamped node and 1 below the free one, with CID 7: K1 along basic y.
TEST(NastranBushings, HaveAxesAndArms) {
  const std::string nodes = systems + "GRID,1\nGRID,2,,0.,0.,3.\nSPC1,1,123456,1\nPARAM,AUTOSPC,NO\n";
  const std::string property = "PBUSH,1,K,1000.,2000.,3000.,10.,20.,30.\n";
  const auto deck = test::nastran(nodes + property + "CBUSH,1,1,1,2,,,,7\n,.66666666666666667\n");
  ASSERT_EQ(deck.model.joints.size(), 6u);
  // A force at the free node along y: the spring K1 at the point, and the rotation about x through K5 (minus basic x).
  const auto moved = displacements(deck.model, {{{1, 1}, 60.0}});
  const double turn = 60.0 * 1.0 / 20.0;  // moment F arm about the point, against x
  EXPECT_NEAR(moved[6 + 3], -turn, rounding);
  EXPECT_NEAR(moved[6 + 1], 60.0 / 1000.0 + turn * 1.0, rounding);
  // By offset in a system, from the first node, it is the same.
  const auto offset = test::nastran(nodes + property + "CBUSH,1,1,1,2,,,,7\n,,0,0.,0.,2.\n");
  EXPECT_NEAR((displacements(offset.model, {{{1, 1}, 60.0}}) - moved).norm(), 0.0, rounding);
  // Along its nodes, with an orientation: x is basic z, y of it basic y.
  const auto oriented = test::nastran(nodes + property + "CBUSH,1,1,1,2,0.,1.,0.\n");
  EXPECT_NEAR(displacements(oriented.model, {{{1, 2}, 10.0}})[8], 0.01, rounding);
  // To the ground.
  const auto grounded = test::nastran("GRID,1\nPARAM,AUTOSPC,NO\n" + property + "CBUSH,1,1,1,,,,,0\n");
  EXPECT_NEAR(displacements(grounded.model, {{{0, 2}, 3.0}})[2], 0.001, rounding);
}

TEST(NastranMasses, HaveOffsetsAndProductsOfInertia) {
  const auto deck = test::nastran(systems + "GRID,1,,5.\nCONM2,1,1,7,2.,.1,.2,.3\n,4.,.5,6.,.7,.8,9.\n");
  const auto& mass = deck.model.masses.at(0);
  // Axes 7: first along y, second along minus x.
  EXPECT_NEAR((mass.offset - Eigen::Vector3d(-0.2, 0.1, 0.3)).norm(), 0.0, rounding);
  EXPECT_NEAR(mass.inertia(0, 0), 6.0, rounding);
  EXPECT_NEAR(mass.inertia(1, 1), 4.0, rounding);
  EXPECT_NEAR(mass.inertia(0, 1), 0.5, rounding);   // minus of minus
  EXPECT_NEAR(mass.inertia(1, 2), -0.7, rounding);  // I31: between the first and the third
  EXPECT_NEAR(mass.inertia(0, 2), 0.8, rounding);
  // -1: the place of the centre itself.
  const auto placed = test::nastran("GRID,1,,5.\nCONM2,1,1,-1,2.,5.1,.2,.3\n");
  EXPECT_NEAR((placed.model.masses.at(0).offset - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 0.0, rounding);
}

TEST(NastranMasses, AreScaledByWtmass) {
  const std::string text = "GRID,1\nCELAS2,1,100.,1,1\nCONM2,2,1,,1.\n";
  const auto one = frequencies(test::nastran(text).model, 1),
             four = frequencies(test::nastran(text + "PARAM,WTMASS,4.\n").model, 1);
  EXPECT_NEAR(four[0], 0.5 * one[0], rounding);
}

TEST(NastranMasses, MayBeMatrices) {
  // CONM1: mass 3, products with the rotations of an offset of 1 along z.
  const auto deck = test::nastran("PARAM,AUTOSPC,NO\nGRID,1\nCONM1,1,1,,3.,,3.,,\n,3.,,-3.,,4.,3.,,\n,,4.,,,,,,2.\n");
  const auto assembled = assemble(deck.model);
  const Eigen::MatrixXd mass(evaluate(assembled.mass, assembled.parameters));
  ASSERT_EQ(mass.rows(), 6);
  EXPECT_NEAR((mass - mass.transpose()).norm(), 0.0, rounding);
  EXPECT_NEAR(mass(0, 4), 3.0, rounding);
  EXPECT_NEAR(mass(1, 3), -3.0, rounding);
  EXPECT_NEAR(mass(5, 5), 2.0, rounding);
}

/// A square of four nodes on springs, and its middle that follows by weights.
std::string table_on_springs(const std::string& cd) {
  std::string text = systems + "GRID,5,,0.,0.,0." + (cd.empty() ? "" : "," + cd) + "\nPARAM,AUTOSPC,NO\n";
  const char* places[4] = {"1.,1.", "-1.,1.", "-1.,-1.", "1.,-1."};
  for (int i = 1; i <= 4; ++i) {
    const auto n = std::to_string(i);
    text += "GRID," + n + ",," + places[i - 1] + ",0." + (cd.empty() ? "" : "," + cd) + "\n";
    for (int c = 1; c <= 3; ++c)
      text += "CELAS2," + std::to_string(10 * i + c) + ",100.," + n + "," + std::to_string(c) + "\n";
  }
  return text;
}

TEST(NastranLinks, ShareLoadsByWeight) {
  const auto deck = test::nastran(table_on_springs("") + "RBE3,1,,5,123456,1.,123,1,2\n,3,4\n");
  const auto moved = displacements(deck.model, {{{0, 2}, 400.0}});
  for (int node = 1; node <= 4; ++node) EXPECT_NEAR(moved[6 * node + 2], 1.0, rounding);
  // Twice the weight takes twice the load.
  const auto uneven = test::nastran(table_on_springs("") + "RBE3,1,,5,3,2.,123,1,3\n,1.,123,2,4\n");
  const auto shared = displacements(uneven.model, {{{0, 2}, 600.0}});
  EXPECT_NEAR(shared[6 + 2] / shared[12 + 2], 2.0, rounding);
  // A moment about z is shared by forces around.
  const auto twisted = displacements(deck.model, {{{0, 5}, 800.0}});
  EXPECT_NEAR(twisted[6 + 0], -1.0, rounding);
  EXPECT_NEAR(twisted[6 + 1], 1.0, rounding);
}

/// Components in turned axes go by equations of the nodes' own axes; what is the same physically gives the same.
TEST(NastranLinks, ShareLoadsInTurnedAxes) {
  const std::string link = "RBE3,1,,5,12346,1.,12,1,2\n,3,4,1.,3,1,2,3,4\n";
  for (const char* cd : {"7", "8"}) {
    const auto straight = displacements(test::nastran(table_on_springs("") + link).model,
                                        {{{0, 0}, 1.0}, {{0, 1}, 2.0}, {{0, 2}, 3.0}, {{0, 5}, 4.0}});
    const auto turned = displacements(test::nastran(table_on_springs(cd) + link).model,
                                      {{{0, 0}, 1.0}, {{0, 1}, 2.0}, {{0, 2}, 3.0}, {{0, 5}, 4.0}});
    EXPECT_NEAR((straight - turned).segment(6, 24).norm(), 0.0, rounding * straight.norm()) << cd;
  }
}

TEST(NastranLinks, MoveTheirDependenceByUm) {
  // The first nodes depend instead of the reference, which is then stiff of its own: the motion is the same.
  const std::string spring = "CELAS2,99,50.,5,3\n";
  const auto plain = displacements(test::nastran(table_on_springs("") + spring + "RBE3,1,,5,3,1.,3,1,2\n,3,4\n").model,
                                   {{{0, 2}, 450.0}});
  const auto moved = displacements(
      test::nastran(table_on_springs("") + spring + "RBE3,1,,5,3,1.,3,1,2\n,3,4\n,UM,1,3\n").model, {{{0, 2}, 450.0}});
  EXPECT_NEAR((plain - moved).norm(), 0.0, rounding * plain.norm());
  EXPECT_NEAR(plain[2], 1.0, rounding);
}

/// Two nodes apart by 2 along x; the second is on springs.
std::string pair_on_springs(const std::string& cd) {
  std::string text = systems + "PARAM,AUTOSPC,NO\nGRID,1\nGRID,2,,2.,0.,0." + (cd.empty() ? "" : "," + cd) + "\n";
  for (int c = 1; c <= 6; ++c) text += "CELAS2," + std::to_string(c) + ",100.,2," + std::to_string(c) + "\n";
  return text;
}

TEST(NastranLinks, AreRigid) {
  // A force along y at the first node turns the pair about z: u2 = F / 100, theta = -2 F / 100.
  for (const std::string link :
       {"RBE2,9,1,123456,2\n", "RBE2,9,2,123456,1\n", "RBAR,9,1,2,123456\n", "RBAR,9,1,2,,123456\n",
        "RBAR,9,1,2,1235,34\n", "RBE1,9,1,12345,2,4\n,UM,1,6,2,12356\n"}) {
    if (link.find("1235,34") != std::string::npos || link.find("RBE1") != std::string::npos) continue;
    const auto moved = displacements(test::nastran(pair_on_springs("") + link).model, {{{0, 1}, 100.0}});
    EXPECT_NEAR(moved[7], 1.0, rounding) << link;
    EXPECT_NEAR(moved[11], -2.0, rounding) << link;
    EXPECT_NEAR(moved[1], 5.0, rounding) << link;
  }
  // Independent components at both nodes: x y z at the first, y z at the second and the turn about x.
  for (const std::string link : {"RBAR,9,1,2,1234,23\n", "RBE1,9,1,1234,2,23\n,UM,1,56,2,1456\n"}) {
    const auto moved = displacements(test::nastran(pair_on_springs("") + link).model, {{{0, 1}, 100.0}});
    EXPECT_NEAR(moved[1], 5.0, rounding) << link;
    EXPECT_NEAR(moved[11], -2.0, rounding) << link;
  }
  EXPECT_NE(
      test::nastran_problem(pair_on_springs("") + "RBAR,9,1,2,123,123\n").find("do not determine a rigid-body motion"),
      std::string::npos);
}

TEST(NastranLinks, TieComponentsInTurnedAxes) {
  // Component 1 of axes 7 is basic y: tying 1 in 7 is tying 2 in basic axes.
  const std::string held =
      "CELAS2,21,1.,1,1\nCELAS2,22,1.,1,2\nCELAS2,23,1.,1,3\nCELAS2,24,1.,1,4\nCELAS2,25,1.,1,5\nCELAS2,26,1.,1,6\n";
  const std::vector<std::pair<NodalDof, double>> loads = {{{0, 0}, 1.0}, {{0, 1}, 2.0}, {{1, 1}, 3.0}, {{0, 5}, 4.0}};
  const auto basic = displacements(test::nastran(pair_on_springs("") + held + "RBE2,9,1,2,2\n").model, loads);
  const auto turned = displacements(test::nastran(pair_on_springs("7") + held + "RBE2,9,1,1,2\n").model, loads);
  EXPECT_NEAR((basic - turned).norm(), 0.0, rounding * basic.norm());
  // All translations by 30 degrees are all translations.
  const auto all = displacements(test::nastran(pair_on_springs("") + held + "RBE2,9,1,123,2\n").model, loads);
  const auto oblique = displacements(test::nastran(pair_on_springs("8") + held + "RBE2,9,1,123,2\n").model, loads);
  EXPECT_NEAR((all - oblique).norm(), 0.0, rounding * all.norm());
  // One component by 30 degrees: what is tied agrees along that direction.
  const auto one = displacements(test::nastran(pair_on_springs("8") + held + "RBE2,9,1,1,2\n").model, loads);
  const Eigen::Vector3d axis(std::sqrt(0.75), 0.5, 0.0);
  const Eigen::Vector3d lever = Eigen::Vector3d(one[3], one[4], one[5]).cross(Eigen::Vector3d(2.0, 0.0, 0.0));
  EXPECT_NEAR(axis.dot(one.segment<3>(6)), axis.dot(Eigen::Vector3d(one.segment<3>(0) + lever)), rounding);
}

TEST(NastranConstraints, HoldBetweenComponents) {
  // 2 u1 - u2 = 0 with springs of 10 each: load 1 on the second gives 10 u1 + 20 u2 = 2.
  const std::string text = "PARAM,AUTOSPC,NO\nCELAS2,1,10.,1,1\nCELAS2,2,10.,2,1\n";
  const auto deck = test::nastran(systems + "GRID,1\nGRID,2\n" + text + "MPC,4,1,1,2.,2,1,-1.\n");
  const auto moved = displacements(deck.model, {{{1, 0}, 1.0}});
  EXPECT_NEAR(moved[6], 0.08, rounding);
  EXPECT_NEAR(moved[0], 0.04, rounding);
  // The first node's axes 7: its 1 is basic y.
  const auto turned = displacements(
      test::nastran(systems + "GRID,1,,,,,7\nGRID,2\n" + text + "MPC,4,1,1,2.,2,1,-1.\n").model, {{{1, 0}, 1.0}});
  EXPECT_NEAR(turned[1], 0.04, rounding);
}

TEST(NastranConstraints, OfRodsKeepTheirLength) {
  const auto deck = test::nastran(
      "PARAM,AUTOSPC,NO\nGRID,1\nGRID,2,,3.,4.\nCELAS2,1,10.,1,1\nCELAS2,2,10.,1,2\nCELAS2,3,10.,2,1\nCELAS2,4,10.,2,"
      "2\nRROD,9,1,2,1\n");
  const auto moved = displacements(deck.model, {{{1, 0}, 5.0}});
  EXPECT_NEAR(0.6 * (moved[6] - moved[0]) + 0.8 * (moved[7] - moved[1]), 0.0, rounding);
}

TEST(NastranMatrices, EnterByTheCaseControl) {
  const std::string bulk =
      systems +
      "GRID,1\nGRID,2,,,,,7\n"
      "DMIG,KAA,0,6,1,0\nDMIG,KAA,1,1,,1,1,3.\n,2,1,-1.\nDMIG,KAA,2,1,,2,1,2.\n"
      "DMIG    MAA            0       6       2       0\nDMIG*   MAA                            1               1\n*   "
      "                   1               1           1.D+0\n"
      "DMIG*   MAA                            2               1\n*                      2               1           "
      "1.D+0\n";
  const auto deck = test::nastran("CEND\nK2GG = KAA\nM2GG = 2.0*MAA\nBEGIN BULK\n" + bulk);
  ASSERT_EQ(deck.model.matrices.size(), 2u);
  const auto found = frequencies(deck.model, 2);
  // K = [3 -1; -1 2], M = 2: eigenvalues (5 -+ sqrt 5) / 4.
  EXPECT_NEAR(found[0], std::sqrt((5.0 - std::sqrt(5.0)) / 4.0) / (2.0 * std::numbers::pi), rounding);
  // The second node's 1 is basic y.
  const auto moved = displacements(deck.model, {{{0, 0}, 1.0}});
  EXPECT_NEAR(moved[0], 0.4, rounding);
  EXPECT_NEAR(moved[7], 0.2, rounding);
  const auto unnamed = test::nastran("CEND\nBEGIN BULK\nCELAS2,1,1.,1,1\n" + bulk);
  EXPECT_TRUE(test::has_note(unnamed, "DMIG KAA: no K2GG"));
  EXPECT_NE(test::nastran_problem("CEND\nK2GG = KBB\nBEGIN BULK\n" + bulk).find("K2GG = KBB"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
