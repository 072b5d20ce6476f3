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
  EXPECT_EQ(body.place().offset, 1);
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

/// The body's response to the motion of its boundary is the one that the whole chain has, although it does not know the
/// wheel, the suspension or the road. Boundary motion is straight between samples: of second order in omega dt.
TEST(DrivenSubstructure, MovesAsInTheWholeChain) {
  const auto structure = chain_structure();
  const auto whole = simulate_chain(*structure, {}, 2.0).trajectory;
  const DrivenSubstructure body(*structure, couple(structure->parts), "body");
  const BoundaryMotion motion{whole.displacement.row(1), whole.velocity.row(1), whole.acceleration.row(1)};
  const auto predicted = body.predict(all_of_the_body(), motion, {}, {.sample_rate = chain_rate});
  const MatrixXd error = predicted.acceleration - whole.acceleration.bottomRows(10);
  const double largest = whole.acceleration.bottomRows(10).norm();
  EXPECT_LT(error.norm(), 2e-3 * largest);
  EXPECT_GT(largest, 0.0);
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
