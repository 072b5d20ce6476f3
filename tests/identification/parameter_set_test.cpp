// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <set>

#include "identification/chain_structure.hpp"

namespace kalfem::test {
namespace {

TEST(ParameterSet, FindsNumbersOfConnectorsAndElementsByName) {
  const ParameterSet parameters(*chain_structure());
  const auto check = [&](const std::string& name, const std::string& owner, const std::string& unit, double value) {
    const auto found = parameters.find(name);
    ASSERT_TRUE(found) << name;
    EXPECT_EQ(found->name, name);
    EXPECT_EQ(found->owner, owner) << name;
    EXPECT_EQ(found->unit, unit) << name;
    EXPECT_EQ(found->value, value) << name;
    EXPECT_EQ(found->of_connector(), owner == "suspension") << name;
  };
  check("suspension.mu_k1", "suspension", "N", true_mu_k1);
  check("suspension.c", "suspension", "N s/m", 10.0);
  check("wheel.k_w.stiffness", "wheel", "N/m", wheel_stiffness);
  check("wheel.k_w.damping", "wheel", "N s/m", 0.0);
  check("wheel.w.mass", "wheel", "kg", 1.5);
  check("body.3-4.stiffness", "body", "N/m", body_stiffness);
  check("body.damping.modal.1", "body", "-", 0.01);
  check("body.damping.stiffness_factor", "body", "s", 0.0);
}

TEST(ParameterSet, FindsNothingUnderANameThatIsNotWhole) {
  const ParameterSet parameters(*chain_structure());
  for (const std::string name : {"", "suspension", "suspension.mu", "mu_k1", "Suspension.mu_k1", "wheel.k_w",
                                 "body.10-11.stiffness", "body.damping.modal.2", "wheel.damping.modal"})
    EXPECT_FALSE(parameters.find(name)) << name;
}

TEST(ParameterSet, NamesEachParameterOnceAndFindsIt) {
  const ParameterSet parameters(*chain_structure());
  const std::set<std::string> once(parameters.names().begin(), parameters.names().end());
  EXPECT_EQ(once.size(), parameters.names().size());
  // 6 of the law; wheel: spring 2, mass 1, factors 2; body: springs 18, masses 10, ratios 2, factors 2
  EXPECT_EQ(once.size(), 6u + 5u + 32u);
  for (const auto& name : once) EXPECT_TRUE(parameters.find(name)) << name;
}

/// Of every parameter: setting it moves its value and, the common ratio left out, no other one.
TEST(ParameterSet, SetsAParameterAndNoOther) {
  const auto structure = chain_structure();
  const ParameterSet before(*structure);
  for (const auto& name : before.names()) {
    StructureData changed = *structure;
    const double value = 1.1 * before.find(name)->value + 1.0;
    ASSERT_TRUE(set_parameter(changed.parts, *before.find(name), value)) << name;
    const ParameterSet after(changed);
    for (const auto& other : before.names()) {
      const bool same =
          other == name || (other.starts_with("body.damping.modal") && name.starts_with("body.damping.modal"));
      EXPECT_EQ(after.find(other)->value, same ? value : before.find(other)->value) << name << " moves " << other;
    }
  }
}

TEST(ParameterSet, SaysThatPartsHaveNoSuchOwner) {
  const auto structure = chain_structure();
  auto parts = structure->parts;
  parts.substructures.erase(parts.substructures.begin());
  parts.connectors.clear();
  EXPECT_FALSE(set_parameter(parts, parameter(*structure, "wheel.k_w.stiffness"), 1.0));
  EXPECT_FALSE(set_parameter(parts, parameter(*structure, "suspension.mu_k1"), 1.0));
  EXPECT_TRUE(set_parameter(parts, parameter(*structure, "body.1-2.stiffness"), 1.0));
  EXPECT_EQ(parts.substructures[0].springs[0].stiffness, 1.0);
}

}  // namespace
}  // namespace kalfem::test
