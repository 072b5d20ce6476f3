// SPDX-License-Identifier: Apache-2.0
// PBEAM and PBEAML with several stations: which line is which, and what becomes of them.
#include <gtest/gtest.h>

#include "formats/nastran_decks.hpp"

namespace kalfem {
namespace {

using test::displacements;
using test::has_note;
using test::nastran;
using test::nastran_problem;

const std::string head = "GRID,1\nGRID,2,,2.\nCBEAM,1,1,1,2,0.,1.,0.\nMAT1,1,2.E11,,.3,7800.\nSPC1,5,123456,1\n";
const std::string first = "PBEAM,1,1,.001,1.-6,1.-6,,2.-6,\n";
const std::string middle = "+,NO,.4,.004,1.6-5,1.6-5,,3.2-5,\n+,NO,.6,.004,1.6-5,1.6-5,,3.2-5,\n";
const std::string last = "+,NO,1.,.001,1.-6,1.-6,,2.-6,\n";
const std::string rigid_in_shear = "+,0.,0.\n";

const BeamProperty& beam_of(const Deck& deck) { return std::get<BeamProperty>(deck.model.properties.begin()->second); }

double tip(const Deck& deck, int direction = 1) {
  return displacements(deck.model, {{{1, direction}, 1000.0}})[6 + direction];
}

/// int (L - x)^2 / (E I) dx with I linear from 1e-6 to 16e-6, constant, and back: 2.5406 mm under 1 kN.
TEST(NastranStations, CountBetweenTheEnds) {
  for (const std::string& points :
       {std::string("+\n"), std::string("+,.1,.1,-.1,.1,-.1,-.1,.1,-.1\n"), std::string()}) {
    const auto deck = nastran(head + first + points + middle + last + rigid_in_shear);
    EXPECT_NEAR(tip(deck), 2.5406e-3, 5e-8);
    EXPECT_NEAR(tip(deck, 2), 2.5406e-3, 5e-8);
    EXPECT_NEAR(test::masses(deck.model).mass, 43.68, 1e-10);
    EXPECT_EQ(beam_of(deck).stations.size(), 4u);
  }
  // In any order, with points of stress behind YES, and without end B, which then is as end A.
  const std::string points = "+,.1,.1,-.1,.1,-.1,-.1,.1,-.1\n";
  const auto other = nastran(head + first + points + "+,YES,.6,.004,1.6-5,1.6-5,,3.2-5,\n" + points +
                             "+,YESA,.4,.004,1.6-5,1.6-5,,3.2-5,\n" + rigid_in_shear);
  EXPECT_NEAR(tip(other), 2.5406e-3, 5e-8);
}

TEST(NastranStations, BlanksAreThoseOfEndAOrBetweenTheEnds) {
  const auto deck = nastran(head + first + "+\n+,NO,1.,.003,,3.-6\n+,NO,.5,,2.-6\n" + rigid_in_shear);
  const auto& stations = beam_of(deck).stations;
  ASSERT_EQ(stations.size(), 3u);
  EXPECT_DOUBLE_EQ(stations[1].section.area, 0.002);
  EXPECT_DOUBLE_EQ(stations[1].section.inertia_z, 2e-6);
  EXPECT_DOUBLE_EQ(stations[1].section.inertia_y, 2e-6);
  EXPECT_DOUBLE_EQ(stations[2].section.inertia_z, 1e-6);
  EXPECT_DOUBLE_EQ(stations[2].section.torsion, 2e-6);
}

TEST(NastranStations, WithoutAFlagAreStations) {
  const std::string station = "+,,1.0,.004,1.6-5,1.6-5,,3.2-5,\n";
  for (const std::string& points : {std::string("+,0.,0.,0.,0.,0.,0.,0.,0.\n"), std::string("+\n"), std::string()}) {
    const auto deck = nastran(head + first + points + station);
    ASSERT_EQ(beam_of(deck).stations.size(), 2u) << points;
    EXPECT_DOUBLE_EQ(beam_of(deck).stations[1].section.area, 0.004);
    EXPECT_DOUBLE_EQ(beam_of(deck).section.shear_factor_y, 1.0);
    // L ln(A_B / A_A) / (E (A_B - A_A))
    EXPECT_NEAR(tip(deck, 0), 1000.0 * 2.0 * std::log(4.0) / (2e11 * 3e-3), 5e-14);
    EXPECT_TRUE(has_note(deck, "without a flag"));
  }
  // K1 left out in front of K2, and no station.
  const auto factors = nastran(head + first + "+\n+,,.5\n");
  EXPECT_TRUE(beam_of(factors).stations.empty());
  EXPECT_EQ(beam_of(factors).section.shear_factor_z, 0.5);
  EXPECT_NE(nastran_problem(head + first + "+\n+,,.5,.002\n").find("begins with a blank field"), std::string::npos);
}

TEST(NastranStations, AreRefusedOutOfPlace) {
  for (const auto& [lines, part] : {std::pair{"+\n+,NO,1.5,.004\n", "not between 0 and 1"},
                                    {"+\n+,NO,0.,.004\n", "not between 0 and 1"},
                                    {"+\n+,NO,.5,.004\n+,NO,.5,.003\n", "two stations"},
                                    {"+\n+,NO,,.004\n", "X/XB"},
                                    {"+\n+,1.,1.\n+,0.\n+,NO,.5,.004\n", "behind the lines of K1"},
                                    {"+\n+,NO,.5,-.004\n", "no positive area"}})
    EXPECT_NE(nastran_problem(head + first + lines).find(part), std::string::npos)
        << lines << nastran_problem(head + first + lines);
}

/// Centres of gravity and of nonstructural mass, and its inertia about the axis, go from end to end.
TEST(NastranStations, HoldNeutralAxesAndNonstructuralInertia) {
  const auto deck =
      nastran(head + "PBEAM,1,1,.001,1.-6,1.-6,,2.-6,5.\n+\n+,0.,0.,,,.3,.5\n+,.1,.2,.3,.4,.01,.02,.03,.04\n");
  const auto& stations = beam_of(deck).stations;
  ASSERT_EQ(stations.size(), 2u);
  EXPECT_EQ(stations[0].section.centroid, Eigen::Vector2d(0.01, 0.02));
  EXPECT_EQ(stations[1].section.centroid, Eigen::Vector2d(0.03, 0.04));
  EXPECT_EQ(stations[1].nonstructural_centre, Eigen::Vector2d(0.3, 0.4));
  EXPECT_EQ(stations[0].nonstructural_inertia, 0.3);
  EXPECT_EQ(stations[1].nonstructural_inertia, 0.5);
  // Inertia about the line of a uniform beam: (2 rho I + NSI) L
  const auto uniform = nastran("PARAM,COUPMASS,1\n" + head + "PBEAM,1,1,.001,1.-6,1.-6,,2.-6\n+\n+,0.,0.,,,.3\n");
  EXPECT_NEAR(test::masses(uniform.model).inertia(0, 0), 2.0 * (7800.0 * 2e-6 + 0.3), 1e-12);
}

TEST(NastranStations, OfPbeamlAreSections) {
  const auto deck = nastran(head + "PBEAML,1,1,,BAR\n+,.1,.2,1.,NO,.5,.1,.4,3.\n+,YES,1.,.1,.2\n");
  const auto& stations = beam_of(deck).stations;
  ASSERT_EQ(stations.size(), 3u);
  EXPECT_NEAR(stations[1].section.area, 0.04, 1e-16);
  EXPECT_NEAR(stations[1].section.inertia_z, 0.1 * std::pow(0.4, 3) / 12.0, 1e-16);
  EXPECT_NEAR(test::masses(deck.model).mass, 2.0 * (7800.0 * 0.03 + 2.0), 1e-9);
  const auto whole = nastran(head + "PBEAML,1,1,,BAR\n+,.1,.2,1.\n");
  EXPECT_TRUE(beam_of(whole).stations.empty());
  EXPECT_NE(nastran_problem(head + "PBEAML,1,1,,BAR\n+,.1,.2,1.,.5,.5,.1,.4,3.\n").find("begins with YES or NO"),
            std::string::npos);
}

}  // namespace
}  // namespace kalfem
