// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "identification/chain_structure.hpp"
#include "kalfem/identification/released_elements.hpp"

namespace kalfem::test {
namespace {

using Eigen::MatrixXd;

bool follows(const StructurePtr& structure, const std::string& name) {
  return linear_part_follows(structure->parts, parameter(*structure, name));
}

TEST(ReleasedElements, AreSpringsDashpotsAndMassesBesideWhatLawsHave) {
  const auto structure = chain_structure();
  const auto can = [&](const std::string& name) {
    return can_be_released(structure->parts, parameter(*structure, name));
  };
  for (const std::string name : {"suspension.mu_k1", "wheel.k_w.stiffness", "wheel.k_w.damping", "wheel.w.mass"})
    EXPECT_TRUE(can(name)) << name;
  for (const std::string name : {"body.damping.modal", "body.damping.modal.1", "body.damping.mass_factor"})
    EXPECT_FALSE(can(name)) << name;
}

TEST(ReleasedElements, AreNoMassesOverAnAcceleratedBase) {
  auto parts = chain_parts();
  parts.inputs = {{"quake", InputKind::base_acceleration, ""}};
  const auto structure = chain_structure(parts);
  EXPECT_FALSE(can_be_released(structure->parts, parameter(*structure, "wheel.w.mass")));
  EXPECT_TRUE(can_be_released(structure->parts, parameter(*structure, "wheel.k_w.stiffness")));
}

TEST(ReleasedElements, ChangeTheDampingThatIsMadeOfThem) {
  const auto chain = chain_structure();  // modal damping of the body alone
  EXPECT_TRUE(follows(chain, "body.1-2.stiffness"));
  EXPECT_TRUE(follows(chain, "body.1.mass"));
  EXPECT_FALSE(follows(chain, "body.1-2.damping"));
  EXPECT_FALSE(follows(chain, "wheel.k_w.stiffness"));
  EXPECT_FALSE(follows(chain, "wheel.w.mass"));
  EXPECT_FALSE(follows(chain, "suspension.k"));

  auto parts = chain_parts();
  parts.substructures[0].rayleigh.stiffness_factor = 1e-4;
  const auto by_stiffness = chain_structure(parts);
  EXPECT_TRUE(follows(by_stiffness, "wheel.k_w.stiffness"));
  EXPECT_FALSE(follows(by_stiffness, "wheel.w.mass"));

  parts.substructures[0].rayleigh = {.mass_factor = 1.0};
  EXPECT_TRUE(follows(chain_structure(parts), "wheel.w.mass"));
}

TEST(ReleasedElements, ChangeGlobalModalDampingWhereTheyShapeModes) {
  auto parts = chain_parts();
  parts.substructures[1].modal_damping.clear();
  parts.damping = GlobalModalDamping{};
  const auto structure = chain_structure(parts);
  for (const std::string name : {"wheel.k_w.stiffness", "wheel.w.mass", "suspension.k", "suspension.mu_k1"})
    EXPECT_TRUE(follows(structure, name)) << name;
  for (const std::string name : {"wheel.k_w.damping", "suspension.c", "suspension.mu_c1"})
    EXPECT_FALSE(follows(structure, name)) << name;
}

TEST(ReleasedElements, ArePositiveByNatureWhereTheyAreSpringsOrMasses) {
  const auto structure = chain_structure();
  const auto positive = [&](const std::string& name) { return is_positive_by_nature(parameter(*structure, name)); };
  EXPECT_TRUE(positive("wheel.k_w.stiffness"));
  EXPECT_TRUE(positive("wheel.w.mass"));
  EXPECT_FALSE(positive("wheel.k_w.damping"));
  EXPECT_FALSE(positive("suspension.mu_k1"));
}

TEST(ReleasedElements, KeepTheConnectorOfALawsParameter) {
  auto parts = chain_parts();
  const auto target = release(parts, parameter(*chain_structure(), "suspension.mu_c1"), 16.0);
  EXPECT_EQ(target.connector, 0);
  EXPECT_EQ(target.parameter, 4);
  EXPECT_EQ(parts.connectors.size(), 1u);
  EXPECT_EQ(parts.connectors[0].parameters[4], 16.0);
}

TEST(ReleasedElements, ShareAConnectorWhereTheyAreOfOneSpring) {
  const auto structure = chain_structure();
  auto parts = structure->parts;
  const auto stiffness = release(parts, parameter(*structure, "wheel.k_w.stiffness"), 1.9e4);
  const auto damping = release(parts, parameter(*structure, "wheel.k_w.damping"), 5.0);
  const auto mass = release(parts, parameter(*structure, "wheel.w.mass"), 1.4);
  const auto other = release(parts, parameter(*structure, "body.1.mass"), 1.0);
  EXPECT_EQ(stiffness.connector, damping.connector);
  EXPECT_NE(stiffness.parameter, damping.parameter);
  EXPECT_NE(mass.connector, stiffness.connector);
  EXPECT_NE(mass.connector, other.connector);
  EXPECT_EQ(parts.connectors.size(), 4u);
  EXPECT_EQ(parts.substructures.size(), 3u);  // one inertial frame for both masses
  // The linear part holds the nominal values.
  EXPECT_EQ(parts.substructures[0].springs[0].stiffness, 1.9e4);
  EXPECT_EQ(parts.substructures[0].springs[0].damping, 5.0);
  EXPECT_EQ(parts.substructures[0].masses[0].mass, 1.4);
  EXPECT_EQ(couple(parts).system().size(), 11);
}

/// Newmark's motion of the wheel and the end of the body over a fifth of a second.
MatrixXd motion_of(const StructureParts& parts) {
  const CoupledModel model = couple(parts);
  const auto& system = model.system();
  const auto result = simulate(system, chain_structure()->signals, at_rest(system.size(), system.connector_states()),
                               {.integrator = Integrator::newmark, .step = 5e-4, .duration = 0.2});
  EXPECT_FALSE(result.failure);
  return result.trajectory.displacement;
}

class ReleasedElement : public testing::TestWithParam<const char*> {};

/// K z + (k - k0) d is the same as K with k in it: the motion must be, whatever the value in the linear part.
TEST_P(ReleasedElement, MovesAsTheElementWithThatValueDoes) {
  const auto structure = chain_structure();
  const Parameter element = parameter(*structure, GetParam());
  const double nominal = 0.8 * element.value + 1.0, value = 1.3 * element.value + 4.0;
  auto direct = structure->parts, released = structure->parts;
  ASSERT_TRUE(set_parameter(direct, element, value));
  const auto target = release(released, element, nominal);
  const MatrixXd at_nominal = motion_of(released);
  released.connectors[static_cast<std::size_t>(target.connector)].parameters[target.parameter] = value;
  const MatrixXd moved = motion_of(released), expected = motion_of(direct);
  const double largest = expected.cwiseAbs().maxCoeff();
  EXPECT_LT((moved - expected).cwiseAbs().maxCoeff(), 1e-9 * largest);
  EXPECT_GT((at_nominal - expected).cwiseAbs().maxCoeff(), 1e-4 * largest);
}
INSTANTIATE_TEST_SUITE_P(Chain, ReleasedElement,
                         testing::Values("wheel.k_w.stiffness", "wheel.k_w.damping", "wheel.w.mass"));

}  // namespace
}  // namespace kalfem::test
