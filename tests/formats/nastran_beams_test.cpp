// SPDX-License-Identifier: Apache-2.0
// Beams, rods and their sections against closed-form answers; E = 7e10, nu = 0.3, rho = 2700 unless said otherwise.
#include <gtest/gtest.h>

#include <cstdio>

#include "formats/nastran_decks.hpp"
#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem {
namespace {

using nastran::section_of_shape;
using test::aluminium;
using test::displacements;
using test::frequencies;

constexpr double e = 7e10, g = e / 2.6, rho = 2700.0;

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17e", value);
  return text;
}

/// Coordinates of a place in a system, as its card's reader takes them.
using Coordinates = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

/// Ten bars of 0.1 from the origin along x, clamped at node 1, I1 = 4e-9 and I2 = 1e-9.
std::string cantilever(const std::string& systems, const std::string& cp, const std::string& cd, const Coordinates& of,
                       const std::string& orientation = "0.,1.,0.") {
  std::string text = aluminium + systems + "PBAR,1,1,1.E-4,4.E-9,1.E-9,2.E-9\nSPC1,1,123456,1\n";
  for (int i = 0; i <= 10; ++i) {
    const Eigen::Vector3d x = of({0.1 * i, 0.0, 0.0});
    text += "GRID," + std::to_string(i + 1) + "," + cp + "," + number(x[0]) + "," + number(x[1]) + "," + number(x[2]) +
            "," + cd + "\n";
    if (i > 0)
      text += "CBAR," + std::to_string(i) + ",1," + std::to_string(i) + "," + std::to_string(i + 1) + "," +
              orientation + "\n";
  }
  return text;
}

const Coordinates basic = [](const Eigen::Vector3d& x) { return x; };

TEST(NastranBeams, BendInTheirPlanes) {
  const auto deck = test::nastran(cantilever("", "", "", basic));
  // Tip loads along y bend plane 1, along z plane 2: L^3 / (3 E I).
  const auto along_y = displacements(deck.model, {{{10, 1}, 1.0}}),
             along_z = displacements(deck.model, {{{10, 2}, 1.0}});
  // rounding, of bending by its condition
  EXPECT_NEAR(along_y[61] * 3.0 * e * 4e-9, 1.0, 5e-12);
  EXPECT_NEAR(along_z[62] * 3.0 * e * 1e-9, 1.0, 5e-12);
  const auto twist = displacements(deck.model, {{{10, 3}, 1.0}});
  EXPECT_NEAR(twist[63] * g * 2e-9, 1.0, 3e-14);
  // An orientation by a node in the plane, and by CBAR's default card, is the same.
  const auto by_node = test::nastran(cantilever("GRID,99,,0.,7.,0.\n", "", "", basic, "99"));
  const auto by_default = test::nastran(cantilever("BAROR,,,,,0.,1.,0.\n", "", "", basic, ""));
  for (const auto* other : {&by_node, &by_default})
    EXPECT_NEAR(displacements(other->model, {{{other->model.mesh.node_count() - 1, 1}, 1.0}}).tail<6>()[1], along_y[61],
                1e-14 * along_y[61]);
}

TEST(NastranBeams, HaveEulerBernoullisFrequencies) {
  const auto deck = test::nastran(cantilever("PARAM,COUPMASS,1\n", "", "", basic));
  const auto found = frequencies(deck.model, 3);
  const auto exact = [](double inertia, double beta) {
    return beta * beta / (2.0 * std::numbers::pi) * std::sqrt(e * inertia / (rho * 1e-4));
  };
  // discretisation of ten elements: 8e-7, and 3e-5 of the second mode
  EXPECT_NEAR(found[0], exact(1e-9, 1.8751041), 2e-6 * found[0]);
  EXPECT_NEAR(found[1], exact(4e-9, 1.8751041), 2e-6 * found[1]);
  EXPECT_NEAR(found[2], exact(1e-9, 4.6940911), 1e-4 * found[2]);
}

/// Frequencies do not depend on the systems in which places and motions are written, however they hang on one another.
TEST(NastranFrames, LeaveFrequenciesAlone) {
  const auto reference = frequencies(test::nastran(cantilever("", "", "", basic)).model, 6);
  // System 3 turns x to y to z and moves; 4 is cylindrical in it, defined before it; 6 hangs on nodes 101 to 103.
  const std::string systems =
      "CORD2C,4,3,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"
      "CORD2R,3,0,1.,2.,3.,2.,2.,3.\n,1.,3.,3.\n"
      "CORD2S,5,3,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"
      "GRID,101,,0.,0.,5.\nGRID,102,,0.,5.,5.\nGRID,103,,3.,0.,9.\nCORD1R,6,101,102,103\n";
  // In system 3: origin (1, 2, 3), z along basic x, x along basic y, y along basic z.
  const auto in_3 = [](const Eigen::Vector3d& x) { return Eigen::Vector3d(x.y() - 2.0, x.z() - 3.0, x.x() - 1.0); };
  const auto degrees = [](double y, double x) { return std::atan2(y, x) * 180.0 / std::numbers::pi; };
  const Coordinates in_4 = [&](const Eigen::Vector3d& x) {
    const Eigen::Vector3d c = in_3(x);
    return Eigen::Vector3d(std::hypot(c.x(), c.y()), degrees(c.y(), c.x()), c.z());
  };
  const Coordinates in_5 = [&](const Eigen::Vector3d& x) {
    const Eigen::Vector3d c = in_3(x);
    return Eigen::Vector3d(c.norm(), degrees(std::hypot(c.x(), c.y()), c.z()), degrees(c.y(), c.x()));
  };
  for (const auto& [cp, of] : std::vector<std::pair<std::string, Coordinates>>{{"3", in_3}, {"4", in_4}, {"5", in_5}}) {
    const auto deck = test::nastran(cantilever(systems, cp, "", of));
    // rounding
    EXPECT_NEAR((frequencies(deck.model, 6) - reference).norm(), 0.0, 5e-12 * reference.norm()) << "CP " << cp;
  }
  // Vectors of bars are in CD: that of system 3 for y is its x.
  const auto turned = test::nastran(cantilever(systems, "", "3", basic, "1.,0.,0."));
  EXPECT_NEAR((frequencies(turned.model, 6) - reference).norm(), 0.0, 5e-12 * reference.norm());
}

TEST(NastranFrames, TurnSupports) {
  // Sliding along an inclined plane: system 7 is turned by 30 degrees about z; component 2 of the tip is held.
  const std::string systems = "CORD2R,7,0,0.,0.,0.,0.,0.,1.\n," + number(std::cos(std::numbers::pi / 6.0)) + ",.5,0.\n";
  const auto deck = test::nastran(cantilever(systems + "SPC1,1,2,11\n", "", "", basic) + "");
  auto text = cantilever(systems + "SPC1,1,2,11\n", "", "", basic);
  text.replace(text.find("GRID,11,"), text.find('\n', text.find("GRID,11,")) - text.find("GRID,11,"),
               "GRID,11,,1.,0.,0.,7");
  const auto inclined = test::nastran(text);
  const auto moved = displacements(inclined.model, {{{10, 0}, 1000.0}});
  // The tip moves along (cos 30, sin 30): axial and bending springs act together.
  // rounding, here and below
  EXPECT_NEAR(moved[61] / moved[60], std::tan(std::numbers::pi / 6.0), 1e-14);
  const double axial = e * 1e-4, bending = 3.0 * e * 4e-9, c = std::cos(std::numbers::pi / 6.0);
  const double s = 1000.0 * c / (axial * c * c + bending * 0.25);
  EXPECT_NEAR(moved[60], s * c, 1e-14 * std::abs(s));
}

/// Two bars of 0.5, clamped at both ends, the last end hinged by PB: 7 P L^3 / (768 E I) at the middle.
TEST(NastranBeams, HaveHinges) {
  const std::string text = aluminium +
                           "PBAR,1,1,1.E-4,4.E-9,1.E-9,2.E-9\nSPC1,1,123456,1,3\n"
                           "GRID,1\nGRID,2,,.5\nGRID,3,,1.\nCBAR,1,1,1,2,0.,1.,0.\n";
  const auto hinged = test::nastran(text + "CBAR,2,1,2,3,0.,1.,0.,GGG\n,,56\n");
  const auto moved = displacements(hinged.model, {{{1, 1}, 1.0}, {{1, 2}, 1.0}});
  EXPECT_NEAR(moved[7], 7.0 / (768.0 * e * 4e-9), 1e-14 * moved[7]);
  EXPECT_NEAR(moved[8], 7.0 / (768.0 * e * 1e-9), 1e-14 * moved[8]);
  // 6 alone frees the bending in plane 1; plane 2 stays clamped: P L^3 / (192 E I).
  const auto half =
      displacements(test::nastran(text + "CBAR,2,1,2,3,0.,1.,0.,GGG\n,,6\n").model, {{{1, 1}, 1.0}, {{1, 2}, 1.0}});
  EXPECT_NEAR(half[7], 7.0 / (768.0 * e * 4e-9), 1e-14 * moved[7]);
  EXPECT_NEAR(half[8], 1.0 / (192.0 * e * 1e-9), 1e-14 * moved[8]);
}

/// A pull at the node of an eccentric cantilever bends it by P e: its tip moves by P e L^2 / (2 E I).
TEST(NastranBeams, HaveOffsetsAndNeutralAxes) {
  const std::string head = aluminium + "SPC1,1,123456,1\nGRID,1\nGRID,2,,1.\n";
  const std::string plain = "PBEAM,1,1,1.E-4,4.E-9,1.E-9,,2.E-9\n,,,,,,,,\n,0.,0.\n";
  const double pull = 100.0, arm = 0.02;
  const auto tip = [&](const std::string& cards) {
    return Eigen::VectorXd(displacements(test::nastran(head + cards).model, {{{1, 0}, pull}}).tail<6>());
  };
  const auto by_offset = tip(plain + "CBEAM,1,1,1,2,0.,1.,0.,GGG\n,,,0.,0.,.02,0.,0.,.02\n");
  // Line above the nodes along z: pulled at its underside it bends upwards, and its end turns against y.
  EXPECT_NEAR(by_offset[2], pull * arm / (2.0 * e * 1e-9), 1e-14 * std::abs(by_offset[2]));
  EXPECT_LT(by_offset[4], 0.0);
  EXPECT_NEAR(by_offset[1], 0.0, 1e-16);
  // In element axes, and as neutral axis off the shear centre, it is the same.
  EXPECT_NEAR((tip(plain + "CBEAM,1,1,1,2,0.,1.,0.,GOO\n,,,0.,0.,.02,0.,0.,.02\n") - by_offset).norm(), 0.0,
              1e-14 * by_offset.norm());
  const std::string eccentric = "PBEAM,1,1,1.E-4,4.E-9,1.E-9,,2.E-9\n,,,,,,,,\n,0.,0.\n,,,,,0.,.02\n";
  EXPECT_NEAR((tip(eccentric + "CBEAM,1,1,1,2,0.,1.,0.\n") - by_offset).norm(), 0.0, 1e-14 * by_offset.norm());
  // N1 is along y.
  const auto along_y =
      tip("PBEAM,1,1,1.E-4,4.E-9,1.E-9,,2.E-9\n,,,,,,,,\n,0.,0.\n,,,,,.02,0.\nCBEAM,1,1,1,2,0.,1.,0.\n");
  EXPECT_NEAR(along_y[1], pull * arm / (2.0 * e * 4e-9), 1e-14 * std::abs(along_y[1]));
}

TEST(NastranBeams, AreFlexibleInShearByPbeam) {
  // K1 = K2 = 1 without a word, 0 is rigid: delta = L^3 / (3 E I) + L / (K G A).
  const std::string head = aluminium + "SPC1,1,123456,1\nGRID,1\nGRID,2,,1.\nCBEAM,1,1,1,2,0.,1.,0.\n";
  const auto tip = [&](const std::string& cards) {
    return displacements(test::nastran(head + cards).model, {{{1, 1}, 1.0}})[7];
  };
  const double bending = 1.0 / (3.0 * e * 4e-6), shear = 1.0 / (g * 1e-2);
  EXPECT_NEAR(tip("PBEAM,1,1,.01,4.E-6,4.E-6,,2.E-6\n"), bending + shear, 1e-14 * bending);
  EXPECT_NEAR(tip("PBEAM,1,1,.01,4.E-6,4.E-6,,2.E-6\n,,,,,,,,\n,.5,0.\n"), bending + 2.0 * shear, 1e-14 * bending);
  EXPECT_NEAR(tip("PBEAM,1,1,.01,4.E-6,4.E-6,,2.E-6\n,,,,,,,,\n,0.,0.\n"), bending, 1e-14 * bending);
  // A station at the other end, with its points of stress, before the factors: I1 from I to 3 I gives
  // int (1 - s)^2 / (1 + 2 s) ds L^3 / (E I) = (9 ln 3 - 8) / 8 L^3 / (E I); within the quadrature.
  const double tapered = (9.0 * std::log(3.0) - 8.0) / (8.0 * e * 2e-6);
  EXPECT_NEAR(tip("PBEAM,1,1,.01,2.E-6,4.E-6,,2.E-6\n,,,,,,,,\n,YES,1.,.01,6.E-6,4.E-6,,2.E-6\n,,,,,,,,\n,.5,0.\n"),
              tapered + 2.0 * shear, 1e-8 * tapered);
  EXPECT_NEAR(tip("PBEAM,1,1,.01,2.E-6,4.E-6,,2.E-6\n,,,,,,,,\n,NO,1.,.01,6.E-6,4.E-6,,2.E-6\n,.5,0.\n"),
              tapered + 2.0 * shear, 1e-8 * tapered);
}

TEST(NastranBeams, KeepAShearModulusOfTheirOwn) {
  const std::string text =
      "MAT1,1,7.E10,1.E10,.3,2700.\nSPC1,1,123456,1\nGRID,1\nGRID,2,,1.\nCBAR,1,1,1,2,0.,1.,0.\nPBAR,1,1,1.E-4,4.E-9,1."
      "E-9,2.E-9\n";
  const auto deck = test::nastran(text);
  EXPECT_NEAR(displacements(deck.model, {{{1, 3}, 1.0}})[9] * 1e10 * 2e-9, 1.0, 1e-14);
  EXPECT_TRUE(test::has_note(deck, "inconsistent E, G and NU"));
}

/// Two rods at 45 degrees hold a node: P L / (E A) / (2 sin^2). What the rods do not stiffen is held.
TEST(NastranRods, MakeATruss) {
  const auto deck = test::nastran(aluminium +
                                  "PROD,1,1,1.E-4\nSPC1,1,123456,1,2\nGRID,1,,-1.,1.\nGRID,2,,1.,1.\nGRID,3\n"
                                  "CROD,1,1,1,3\nCONROD,2,2,3,1,1.E-4\n");
  const auto moved = displacements(deck.model, {{{2, 1}, -1000.0}});
  EXPECT_NEAR(moved[13], -1000.0 * std::sqrt(2.0) / (e * 1e-4), 1e-14 * std::abs(moved[13]));
  EXPECT_TRUE(test::has_note(deck, "AUTOSPC"));
  EXPECT_NEAR(test::masses(deck.model).mass, rho * 1e-4 * 2.0 * std::sqrt(2.0), 1e-14);
  const auto found = frequencies(deck.model, 2);
  EXPECT_GT(found[0], 1.0);
}

TEST(NastranRods, TwistByJ) {
  const auto deck =
      test::nastran(aluminium + "PROD,1,1,1.E-4,3.E-9\nSPC1,1,123456,1\nGRID,1\nGRID,2,,2.\nCROD,1,1,1,2\n");
  EXPECT_NEAR(displacements(deck.model, {{{1, 3}, 1.0}})[9] * g * 3e-9, 2.0, 1e-14);
}

TEST(NastranSections, HaveTheirClosedForms) {
  // I of 200 x 100, flanges 10, web 6.
  const auto i = section_of_shape("I", {200, 100, 100, 6, 10, 10}, "PBARL 1");
  // roundings of each size, from areas of 1e3 to moments of 1e7
  EXPECT_NEAR(i.area, 2 * 1000 + 180 * 6, 1e-12);
  EXPECT_NEAR(i.i1, (100.0 * std::pow(200, 3) - 94.0 * std::pow(180, 3)) / 12.0, 1e-7);
  EXPECT_NEAR(i.i2, (2.0 * 10 * std::pow(100, 3) + 180.0 * std::pow(6, 3)) / 12.0, 1e-8);
  EXPECT_NEAR(i.torsion, (2.0 * 100 * 1000 + 190 * 216) / 3.0, 1e-9);
  EXPECT_NEAR(i.neutral_axis.norm(), 0.0, 1e-12);
  // Bar: width 20 along z, height 30 along y.
  const auto bar = section_of_shape("BAR", {20, 30}, "PBARL 1");
  EXPECT_NEAR(bar.i1, 20.0 * 27000 / 12.0, 1e-10);
  EXPECT_NEAR(bar.i2, 30.0 * 8000 / 12.0, 1e-10);
  const auto tube = section_of_shape("TUBE", {10, 8}, "PBARL 1");
  EXPECT_NEAR(tube.area, std::numbers::pi * 36, 1e-12);
  const auto box = section_of_shape("BOX", {60, 100, 4, 3}, "PBARL 1");
  EXPECT_NEAR(box.area, 60 * 100 - 54 * 92, 1e-12);
  EXPECT_NEAR(box.i1, (60.0 * 1e6 - 54.0 * std::pow(92, 3)) / 12.0, 1e-7);
  // Bredt, and the walls alone.
  EXPECT_NEAR(box.torsion,
              4.0 * std::pow(57.0 * 96.0, 2) / (2.0 * 57 / 4 + 2.0 * 96 / 3) + 2.0 * (57.0 * 64 + 96.0 * 27) / 3.0,
              1e-8);
  // The walls along the force take it: 5/6 of two of 100 x 3, or of 60 x 4.
  EXPECT_NEAR(box.k1 * box.area, 5.0 / 6.0 * 2 * 100 * 3, 1e-12);
  EXPECT_NEAR(box.k2 * box.area, 5.0 / 6.0 * 2 * 60 * 4, 1e-12);
}

/// Areas by the published formulas of each shape; shear centres where textbooks give them.
TEST(NastranSections, OfOpenWallsHaveTheirShearCentres) {
  const auto area = [](const std::string& shape, const std::vector<double>& d) {
    return section_of_shape(shape, d, "x").area;
  };
  EXPECT_NEAR(area("I1", {80, 6, 180, 200}), 6 * 180 + 20 * 86, 1e-12);
  EXPECT_NEAR(area("H", {80, 12, 100, 6}), 12 * 100 + 80 * 6, 1e-12);
  EXPECT_NEAR(area("T", {80, 100, 8, 6}), 80 * 8 + 92 * 6, 1e-12);
  EXPECT_NEAR(area("T1", {80, 100, 8, 6}), 80 * 8 + 100 * 6, 1e-12);
  EXPECT_NEAR(area("T2", {80, 100, 8, 6}), 80 * 8 + 92 * 6, 1e-12);
  EXPECT_NEAR(area("CHAN1", {50, 6, 80, 100}), 6 * 80 + 20 * 56, 1e-12);
  EXPECT_NEAR(area("CHAN2", {5, 6, 50, 100}), 2 * 5 * 50 + 90 * 6, 1e-12);
  EXPECT_NEAR(area("CROSS", {60, 6, 80, 5}), 80 * 6 + 60 * 5, 1e-12);
  EXPECT_NEAR(area("L", {60, 80, 5, 4}), 80 * 4 + 56 * 5, 1e-12);
  EXPECT_NEAR(area("Z", {40, 5, 80, 100}), 5 * 80 + 20 * 45, 1e-12);
  EXPECT_NEAR(area("HAT", {50, 3, 40, 20}), 3 * 40 + 2 * 47 * 3 + 2 * 3 * 20, 1e-12);
  // Channel: e = b^2 h^2 t / (4 I) beyond the web's middle line, thin walls [TG70].
  const double b = 50, h = 100, t = 0.1;
  const auto channel = section_of_shape("CHAN", {b + t / 2, h + t, t, t}, "x");
  const double inertia = t * h * h * h / 12.0 + 2.0 * b * t * h * h / 4.0;
  const double distance = b * b * h * h * t / (4.0 * inertia) + b * b * t / (2.0 * b * t + h * t);
  EXPECT_NEAR(std::abs(channel.neutral_axis[1]), distance, 1e-6 * distance);  // walls of .1 % of the height: found 4e-7
  EXPECT_NEAR(channel.neutral_axis[0], 0.0, 1e-13 * h);
  // Unequal angle: where the walls meet.
  const auto angle = section_of_shape("L", {60, 80, 1, 1}, "x");
  // the wall is 1 thick: found .12
  EXPECT_NEAR(std::abs(angle.neutral_axis[0]), 80.0 * 40.0 / 140.0, 0.25);
  EXPECT_NEAR(std::abs(angle.neutral_axis[1]), 60.0 * 30.0 / 140.0, 0.25);
}

TEST(NastranSections, AreToldWhereUnknownOrImpossible) {
  const std::string text = aluminium + "GRID,1\nGRID,2,,1.\nCBAR,1,1,1,2,0.,1.,0.\n";
  EXPECT_NE(test::nastran_problem(text + "PBARL,1,1,,DBOX\n,1.,2.\n").find("'DBOX' is not known"), std::string::npos);
  EXPECT_NE(test::nastran_problem(text + "PBARL,1,1,,TUBE\n,1.,2.\n").find("do not form"), std::string::npos);
  EXPECT_NE(test::nastran_problem(text + "PBARL,1,1,,BOX\n,4.,4.,2.,1.\n").find("do not form"), std::string::npos);
}

TEST(NastranBeams, AreToldWhereTheyHaveNoPlane) {
  const std::string text = aluminium + "PBAR,1,1,1.E-4,4.E-9,1.E-9,2.E-9\nGRID,1\nGRID,2,,1.\n";
  EXPECT_NE(test::nastran_problem(text + "CBAR,1,1,1,2,1.,0.,0.\n").find("parallel to its axis"), std::string::npos);
  EXPECT_NE(test::nastran_problem(text + "CBAR,1,1,1,1,0.,1.,0.\n").find("no length"), std::string::npos);
  EXPECT_NE(test::nastran_problem(text + "CBAR,1,1,1,2,0.,1.,0.,XYZ\n").find("OFFT"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
