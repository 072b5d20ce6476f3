// SPDX-License-Identifier: Apache-2.0
#include "cantilever.hpp"

// Structure::at() of numbers of finite elements.

namespace kalfem {
namespace {

using testing::HasSubstr;

constexpr const char* modulus = "beam.steel.youngs_modulus";

Structure beam_on_spring(double youngs_modulus = 210e9, double ratio = 0.01) {
  Structure s;
  s.add(cantilever(youngs_modulus).modal_damping({ratio}, 1e4));
  s.connect("spring", "beam.tip.z", "ground", law("linear", {{"k", 100.0}}));
  s.force("push", "beam.tip.z", {Eigen::VectorXd::Constant(101, 1.0), 100.0});
  return s;
}

/// The tip's motion after a push: frequency and damping of the beam are in it.
Eigen::VectorXd tip_of(const Structure& s) {
  return simulate(s, {.sensors = {{"tip", displacement("beam.tip.z")}}, .duration = 0.5, .sample_rate = 100.0})
      .record.values.row(0)
      .transpose();
}

TEST(StructureAt, SetsAMaterialOfFiniteElements) {
  const Structure moved = beam_on_spring(210e9).at({{modulus, 180e9}});
  EXPECT_EQ(moved.value(modulus), 180e9);
  EXPECT_LT((tip_of(moved) - tip_of(beam_on_spring(180e9))).norm(), 1e-12);
  EXPECT_GT((tip_of(moved) - tip_of(beam_on_spring(210e9))).norm(), 1e-4);
}

TEST(StructureAt, SetsTheDampingOfFiniteElements) {
  const Structure moved = beam_on_spring().at({{"beam.damping.modal", 0.1}});
  EXPECT_EQ(moved.value("beam.damping.modal"), 0.1);
  EXPECT_LT((tip_of(moved) - tip_of(beam_on_spring(210e9, 0.1))).norm(), 1e-12);
}

/// Bending of all beams about both axes by two: as twice the modulus, as there is nothing else in the tip's motion.
TEST(StructureAt, SetsAFactorOfABeam) {
  const Structure moved = beam_on_spring().at({{"beam.bar.bending_y", 2.0}, {"beam.bar.bending_z", 2.0}});
  EXPECT_EQ(moved.value("beam.bar.bending_y"), 2.0);
  EXPECT_EQ(std::ranges::count(moved.parameters(), "beam.bar.bending_y"), 1);
  const Eigen::VectorXd expected = tip_of(beam_on_spring(420e9));
  EXPECT_LT((tip_of(moved) - expected).norm(), 1e-6 * expected.norm());
}

TEST(StructureAt, TheLastValueCountsAndOthersStay) {
  const Structure twice = beam_on_spring().at({{modulus, 100e9}}).at({{modulus, 180e9}, {"spring.k", 200.0}});
  EXPECT_EQ(twice.value(modulus), 180e9);
  EXPECT_EQ(twice.value("spring.k"), 200.0);
  EXPECT_EQ(twice.value("beam.steel.density"), 7850.0);
}

TEST(StructureAt, ValuesThatMakeNoStructureAreRefused) {
  EXPECT_THAT(refusal_of([] {
                return beam_on_spring().at({{modulus, std::nan("")}});
              }),
              HasSubstr("at 'beam.steel.youngs_modulus': "));
  EXPECT_THAT(refusal_of([] { return beam_on_spring().at({{modulus, -1.0}}).points(); }), HasSubstr("steel"));
  EXPECT_THAT(refusal_of([] {
                return beam_on_spring().at({{"beam.steel.modulus", 1.0}});
              }),
              HasSubstr("at 'beam.steel.modulus': there is no parameter of that name"));
}

}  // namespace
}  // namespace kalfem
