// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "chain.hpp"
#include "kalfem/api/filter_problem.hpp"
#include "kalfem/identification/own_information.hpp"

// Unknowns that the sensors cannot tell apart, before there is a record.

namespace kalfem {
namespace {

using Eigen::Index;

/// A mass on a spring and dashpot, moved by its ground or by a force.
Structure one_mass(bool by_ground) {
  Structure s;
  s.add(lumped("s").mass("m", 2.0).spring("k", "ground", "m", 800.0, 4.0));
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(801, 0.0, 4.0);
  const Samples samples{(7.0 * t.array()).sin() + (19.0 * t.array() + 1.0).sin() + (31.0 * t.array()).sin(), 200.0,
                        0.0};
  if (by_ground) return s.base_acceleration("shaker", samples);
  return s.force("shaker", "s.m", samples);
}

Identifiability told(const Structure& structure, std::vector<UnknownDescription> unknowns) {
  const auto made = make_filter_problem(
      structure, 200.0, {.sensors = {{"a", acceleration("s.m"), 1e-3}}, .unknowns = std::move(unknowns)});
  Record time;
  time.sample_rate = 200.0;
  time.values.resize(0, 801);
  const auto own = own_information(made.problem, time);
  return identifiability(own->information, own->parameters);
}

std::vector<UnknownDescription> all_numbers() {
  return {{"s.m.mass", {.std = 0.2}}, {"s.k.stiffness", {.std = 80.0}}, {"s.k.damping", {.std = 0.4}}};
}

std::ptrdiff_t undetermined(const Identifiability& found) {
  return std::ranges::count(found.combinations, false, &ParameterCombination::determined);
}

/// A known force tells its mass; a ground that is accelerated tells ratios alone: the product m^a k^a c^a of all three.
TEST(ToldBySensors, MassesAndStiffnessesTogetherScaleWithAnUnknownForce) {
  EXPECT_EQ(undetermined(told(one_mass(false), all_numbers())), 0);
  const auto found = told(one_mass(true), all_numbers());
  ASSERT_EQ(undetermined(found), 1);
  const auto& last = found.combinations.back();
  EXPECT_FALSE(last.determined);
  for (Index i = 1; i < 3; ++i) EXPECT_NEAR(last.direction[i], last.direction[0], 1e-3);  // in tenths of each
  for (const char* name : {"s.m.mass", "s.k.stiffness", "s.k.damping"})
    EXPECT_NE(found.text.find(name), std::string::npos) << found.text;
}

/// A gain of the only sensor acts like the force: all numbers together scale with it.
TEST(ToldBySensors, TheGainOfAllSensorsIsOneOfThem) {
  auto unknowns = all_numbers();
  unknowns.push_back({"sensors.a.gain", {.initial = 1.0, .std = 0.1}});
  const auto found = told(one_mass(false), unknowns);
  ASSERT_EQ(undetermined(found), 1);
  EXPECT_NE(found.text.find("sensors.a.gain"), std::string::npos) << found.text;
  unknowns.erase(unknowns.begin());  // with the mass known, the gain is
  EXPECT_EQ(undetermined(told(one_mass(false), unknowns)), 0);
}

}  // namespace
}  // namespace kalfem
