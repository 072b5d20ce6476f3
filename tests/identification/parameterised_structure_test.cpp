// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "identification/chain_structure.hpp"
#include "kalfem/identification/parameterised_structure.hpp"

namespace kalfem::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// theta = [stiffness of two springs of the body; mass of the wheel; ratio of the body's modes; mu_k1]
std::vector<StructureBinding> bindings_of(const StructureData& structure) {
  return {{0, parameter(structure, "body.1-2.stiffness")},
          {0, parameter(structure, "body.2-3.stiffness")},
          {1, parameter(structure, "wheel.w.mass")},
          {2, parameter(structure, "body.damping.modal")},
          {3, parameter(structure, "suspension.mu_k1")}};
}

VectorXd theta(double stiffness, double mass, double ratio) {
  VectorXd values(4);
  values << stiffness, mass, ratio, 77.0;
  return values;
}

TEST(ParameterisedStructure, HasTheNumbersOfTheta) {
  const auto chain = chain_structure();
  const ParameterisedStructure structure(chain, bindings_of(*chain), 4);
  const auto at = structure.at(theta(2.8e4, 1.7, 0.02));
  EXPECT_TRUE(at.in_basis.empty());
  const auto& [wheel, body] = std::tie(at.parts.substructures[0], at.parts.substructures[1]);
  EXPECT_EQ(body.springs[0].stiffness, 2.8e4);
  EXPECT_EQ(body.springs[1].stiffness, 2.8e4);
  EXPECT_EQ(body.springs[2].stiffness, body_stiffness);
  EXPECT_EQ(wheel.masses[0].mass, 1.7);
  EXPECT_EQ(wheel.springs[0].stiffness, wheel_stiffness);
  EXPECT_EQ(body.modal_damping, std::vector<double>{0.02});
  // Connectors' parameters are left to who couples the parts.
  EXPECT_EQ(at.parts.connectors[0].parameters[1], true_mu_k1);
}

TEST(ParameterisedStructure, NearAThetaIsTheStructureAtIt) {
  const auto chain = chain_structure();
  const ParameterisedStructure structure(chain, bindings_of(*chain), 4);
  const auto here = structure.at(theta(3e4, 1.5, 0.01));
  const VectorXd moved = theta(3.1e4, 1.4, 0.03);
  const CoupledModel near = couple(structure.near(here, moved)), at = couple(structure.at(moved).parts);
  EXPECT_TRUE(MatrixXd(near.system().stiffness) == MatrixXd(at.system().stiffness));
  EXPECT_TRUE(MatrixXd(near.system().mass) == MatrixXd(at.system().mass));
  EXPECT_TRUE(MatrixXd(near.system().damping) == MatrixXd(at.system().damping));
}

TEST(ParameterisedStructure, GivesTheMatricesOfASubstructureAndTheirDerivatives) {
  const auto chain = chain_structure();
  const ParameterisedStructure structure(chain, bindings_of(*chain), 4);
  const auto body = structure.model_of("body");
  ASSERT_TRUE(body);
  const VectorXd here = theta(3e4, 1.5, 0.01), there = theta(3e4 + 1.0, 1.5, 0.01);
  const MatrixXd difference = MatrixXd(body->at(there).model.stiffness) - MatrixXd(body->at(here).model.stiffness);
  EXPECT_LT((difference - MatrixXd(body->derivatives(here)[0].stiffness)).norm(), 1e-9);
  EXPECT_NEAR(difference(1, 1), 2.0, 1e-9);           // both springs end at the second mass
  EXPECT_TRUE(body->derivatives(here)[1].is_zero());  // of the wheel
}

TEST(ParameterisedStructure, HasNoModelUnderAnotherName) {
  const auto chain = chain_structure();
  const ParameterisedStructure structure(chain, {}, 0);
  EXPECT_TRUE(structure.model_of("wheel"));
  EXPECT_FALSE(structure.model_of("suspension"));
  EXPECT_FALSE(structure.model_of(""));
}

TEST(ParameterisedStructure, RefusesANegativeMass) {
  const auto chain = chain_structure();
  const ParameterisedStructure structure(chain, bindings_of(*chain), 4);
  const auto assembled = [&](double mass) {
    return refusal([&] { couple(structure.at(theta(3e4, mass, 0.01)).parts); });
  };
  EXPECT_EQ(assembled(1.0), "");
  EXPECT_NE(assembled(-1.0).find("mass"), std::string::npos);
}

TEST(ParameterisedStructure, OutlivesThePointerThatItWasMadeOf) {
  auto chain = chain_structure();
  const ParameterisedStructure structure(chain, bindings_of(*chain), 4);
  chain.reset();
  EXPECT_EQ(couple(structure.at(theta(3e4, 1.5, 0.01)).parts).system().size(), 11);
}

}  // namespace
}  // namespace kalfem::test
