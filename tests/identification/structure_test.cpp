// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "identification/chain_structure.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

TEST(StructureParts, CoupleToASystemInTheirOrder) {
  const CoupledModel model = couple(chain_parts());
  const auto& system = model.system();
  ASSERT_EQ(system.size(), 11);
  EXPECT_EQ(system.dofs.front(), "wheel.w");
  EXPECT_EQ(system.dofs.back(), "body.10");
  EXPECT_EQ(system.connectors.size(), 1u);
  // The road pushes the wheel by its spring, and nothing else.
  ASSERT_EQ(system.input_count(), 1);
  EXPECT_EQ(system.inputs[0].value[0], wheel_stiffness);
  EXPECT_TRUE(system.inputs[0].value.tail(10).isZero());
}

TEST(StructureParts, FreeBodyHasTheFrequenciesOfAUniformChain) {
  StructureParts parts;
  parts.substructures = {chain_body()};
  const CoupledModel model = couple(parts);
  const VectorXd squares = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(model.system().stiffness).eigenvalues();
  for (Index i = 0; i < 10; ++i) {  // unit masses
    const double omega =
        2.0 * std::sqrt(body_stiffness) * std::sin(static_cast<double>(i) * std::numbers::pi / (2.0 * 10.0));
    EXPECT_NEAR(squares[i], omega * omega, 1e-9 * body_stiffness) << i;
  }
}

TEST(StructureParts, NameAllTheirGrounds) {
  auto parts = chain_parts();
  EXPECT_EQ(ground_names(parts), std::vector<std::string>{"wheel.ground"});
  parts.substructures[1].grounds = {"left", "right"};
  EXPECT_EQ(ground_names(parts), (std::vector<std::string>{"wheel.ground", "body.left", "body.right"}));
}

TEST(StructureParts, AreRefusedWithEverythingThatDoesNotFit) {
  EXPECT_EQ(refusal([] { couple(chain_parts()); }), "");
  auto parts = chain_parts();
  parts.connectors[0].from = "wheel.v";
  auto second = parts.connectors[0];
  second.name = "damper";
  second.from = "wheel.w";
  second.to = "body.11";
  parts.connectors.push_back(second);
  const std::string text = refusal([&] { couple(parts); });
  EXPECT_NE(text.find("wheel.v"), std::string::npos) << text;
  EXPECT_NE(text.find("body.11"), std::string::npos) << text;
}

TEST(Structure, WithoutFiniteElementsIsItsOwnReference) {
  const auto structure = chain_structure();
  EXPECT_TRUE(structure->reduced_parts().empty());
  const auto reference = structure->reference_parts();
  EXPECT_EQ(reference.substructures.size(), 2u);
  EXPECT_EQ(reference.connectors.size(), 1u);
  EXPECT_EQ(couple(reference).system().dofs, couple(structure->parts).system().dofs);
}

}  // namespace
}  // namespace kalfem::test
