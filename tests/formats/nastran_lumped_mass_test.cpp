// SPDX-License-Identifier: Apache-2.0
// The lumped mass of beams: as Nastran has it, translations of CBAR and rods, and the twist of CBEAM beside them.
#include <gtest/gtest.h>

#include "formats/nastran_decks.hpp"

namespace kalfem {
namespace {

constexpr double length = 2.0, density = 7800.0, area = 1e-4, i1 = 1e-8, i2 = 2e-8;

/// A cantilever of one element along x.
std::string cantilever(const std::string& element) {
  return "GRID,1,,0.,0.,0.,,123456\nGRID,2,,2.,0.,0.\nMAT1,1,2.E11,,.3,7800.\nPARAM,AUTOSPC,NO\n" + element;
}

const std::string bar = "CBAR,1,1,1,2,0.,1.,0.\nPBAR,1,1,1.E-4,1.E-8,2.E-8,3.E-8\n";
const std::string beam = "CBEAM,1,1,1,2,0.,1.,0.\nPBEAM,1,1,1.E-4,1.E-8,2.E-8,,3.E-8\n";

/// Diagonal of the mass of grid 2, x y z rx ry rz; off the diagonal there is nothing.
Eigen::VectorXd mass_of(const std::string& text) {
  const auto deck = test::nastran(text);
  const auto assembled = assemble(deck.model);
  const Eigen::MatrixXd mass(evaluate(assembled.mass, assembled.parameters));
  EXPECT_EQ((mass - Eigen::MatrixXd(mass.diagonal().asDiagonal())).norm(), 0.0);
  return mass.diagonal();
}

void expect_masses(const Eigen::VectorXd& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.size(), static_cast<Eigen::Index>(expected.size()));
  for (Eigen::Index i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i], expected[static_cast<std::size_t>(i)], 1e-12) << "motion " << i;
}

TEST(NastranLumpedMass, OfABarIsThatOfItsTranslations) {
  const double half = 0.5 * density * area * length;
  expect_masses(mass_of(cantilever(bar)), {half, half, half, 0.0, 0.0, 0.0});
}

TEST(NastranLumpedMass, OfABeamHasItsTwistToo) {
  const double half = 0.5 * density * area * length, twist = 0.5 * density * (i1 + i2) * length;
  expect_masses(mass_of(cantilever(beam)), {half, half, half, twist, 0.0, 0.0});
}

TEST(NastranLumpedMass, OfATaperedBeamHasItsTwistToo) {
  const auto found =
      mass_of(cantilever("CBEAM,1,1,1,2,0.,1.,0.\nPBEAM,1,1,1.E-4,1.E-8,2.E-8,,3.E-8\n,\n"
                         ",YES,1.,2.E-4,2.E-8,4.E-8,,6.E-8\n"));
  EXPECT_GT(found[3], 0.0);
  EXPECT_EQ(found[4], 0.0);
  EXPECT_EQ(found[5], 0.0);
}

/// A straight bar that nothing holds would turn about its line without stiffness and mass.
TEST(NastranLumpedMass, OfAFreeStraightBarHasItsTwist) {
  std::string text = cantilever(bar);
  text.replace(text.find(",,123456"), 8, "");
  const auto deck = test::nastran(text);
  EXPECT_TRUE(test::has_note(deck, "bars in one line"));
  const auto assembled = assemble(deck.model);
  const Eigen::VectorXd mass = evaluate(assembled.mass, assembled.parameters).diagonal();
  EXPECT_NEAR(mass[3], 0.5 * density * (i1 + i2) * length, 1e-12);
  EXPECT_EQ(mass[4], 0.0);
}

/// Coupled mass keeps the turn of its shapes.
TEST(NastranLumpedMass, IsNotThatOfCoupledMass) {
  const auto deck = test::nastran(cantilever("PARAM,COUPMASS,1\n" + bar));
  const auto assembled = assemble(deck.model);
  EXPECT_GT(evaluate(assembled.mass, assembled.parameters).diagonal().minCoeff(), 0.0);
}

}  // namespace
}  // namespace kalfem
