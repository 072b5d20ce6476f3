// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <memory>
#include <numbers>

#include "identification/chain_structure.hpp"
#include "kalfem/identification/driven_substructure.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Rows that give every degree of freedom of the body.
SparseRows all_of_the_body() {
  SparseRows rows(10, 10);
  rows.setIdentity();
  return rows;
}

TEST(DrivenSubstructure, HasItsBoundaryWhereConnectorsTouchIt) {
  const auto structure = chain_structure();
  const CoupledModel model = couple(structure->parts);
  const DrivenSubstructure body(*structure, model, "body");
  EXPECT_EQ(body.points(), std::vector<std::string>{"body.1"});
  EXPECT_EQ(body.place().dofs.front(), 1);
  EXPECT_EQ(std::ssize(body.place().dofs), body.place().part.model->size());
}

/// A boundary that moves at constant speed carries the body along as a rigid one.
TEST(DrivenSubstructure, FollowsASteadyBoundaryRigidly) {
  const auto structure = chain_structure();
  const DrivenSubstructure body(*structure, couple(structure->parts), "body");
  const double speed = 0.3;
  const auto ramp = Eigen::RowVectorXd::LinSpaced(201, 0.0, 0.2 * speed);
  const BoundaryMotion motion{ramp, Eigen::RowVectorXd::Constant(201, speed), Eigen::RowVectorXd::Zero(201)};
  const auto predicted = body.predict(all_of_the_body(), motion, {}, {.sample_rate = chain_rate});
  EXPECT_LT((predicted.displacement - ramp.replicate(10, 1)).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LT((predicted.velocity.array() - speed).abs().maxCoeff(), 1e-11);
  EXPECT_LT(predicted.acceleration.cwiseAbs().maxCoeff(), 1e-8);
}

/// Error of the body's accelerations when every `stride`th sample of the boundary's true motion drives it.
double error_with_every(Index stride, const StructurePtr& structure, const Trajectory& whole) {
  const DrivenSubstructure body(*structure, couple(structure->parts), "body");
  const auto samples = Eigen::seq(0, whole.samples() - 1, stride);
  const BoundaryMotion motion{whole.displacement(1, samples), whole.velocity(1, samples),
                              whole.acceleration(1, samples)};
  const auto predicted =
      body.predict(all_of_the_body(), motion, {}, {.sample_rate = chain_rate / static_cast<double>(stride)});
  const MatrixXd expected = whole.acceleration.bottomRows(10)(Eigen::all, samples);
  return (predicted.acceleration - expected).norm() / expected.norm();
}

/// The body moves as in the whole chain, although it knows neither the wheel nor the suspension nor the road. Boundary
/// motion is straight between samples, so that the error is of second order in their distance.
TEST(DrivenSubstructure, MovesAsInTheWholeChain) {
  const auto structure = chain_structure();
  const auto whole = simulate_chain(*structure, {}, 2.0).trajectory;
  const double fine = error_with_every(1, structure, whole), coarse = error_with_every(2, structure, whole);
  EXPECT_LT(fine, 0.004);  // found .003
  EXPECT_NEAR(coarse / fine, 4.0, 0.8);
}

TEST(DrivenSubstructure, OutlivesTheModelThatItWasMadeOf) {
  const auto structure = chain_structure();
  auto model = std::make_unique<CoupledModel>(couple(structure->parts));
  const DrivenSubstructure body(*structure, *model, "body");
  const std::weak_ptr<const LinearModel> matrices = model->substructures()[1].model;
  model.reset();
  EXPECT_FALSE(matrices.expired());
  EXPECT_EQ(body.place().part.name, "body");
  EXPECT_EQ(body.place().part.model->size(), 10);
}

TEST(DrivenSubstructure, OfAnotherNameIsRefused) {
  const auto structure = chain_structure();
  const CoupledModel model = couple(structure->parts);
  const std::string text = refusal([&] { DrivenSubstructure(*structure, model, "bodi"); });
  EXPECT_NE(text.find("bodi"), std::string::npos) << text;
  // The wheel is all boundary.
  EXPECT_NE(refusal([&] { DrivenSubstructure(*structure, model, "wheel"); }), "");
}

}  // namespace
}  // namespace kalfem::test
