// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/coupling.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/laws/law_library.hpp"
#include "system/small_systems.hpp"

namespace kalfem {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A wheel without dashpot on a moving ground, and a body on two connectors: one to the wheel, one to the ground.
CoupledModel structure(const std::optional<GlobalModalDamping>& damping) {
  LumpedSubstructure wheel{.name = "wheel", .masses = {{"w", 1.5}}, .springs = {{"tyre", "ground", "w", 2e4}}};
  LumpedSubstructure body{.name = "body",
                          .masses = {{"1", 1.0}, {"2", 2.0}, {"3", 0.5}},
                          .springs = {{"a", "1", "2", 3e4}, {"b", "2", "3", 1e4}}};
  VectorXd no_dashpot = saturating_parameters();
  no_dashpot[3] = no_dashpot[4] = 0.0;
  return CoupledModel({{"wheel", assemble(wheel)}, {"body", assemble(body)}},
                      {{"strut", "wheel.w", "body.1", make_law("saturating"), no_dashpot},
                       {"tie", "wheel.ground", "body.3", make_law("linear"), values({4e3, 0.0})}},
                      {{"F", InputKind::force, "body.2"}, {"road", InputKind::base_displacement, "wheel.ground"}},
                      damping);
}

/// The springs of the structure by hand, the saturating one with k + mu_k1 / mu_k2.
MatrixXd stiffness_by_hand() {
  const double strut = 5e3 + 20.0 / 2e-3;
  MatrixXd K = MatrixXd::Zero(4, 4);
  const auto add = [&](int i, int j, double k) {
    K(i, i) += k;
    if (j < 0) return;
    K(j, j) += k;
    K(i, j) -= k;
    K(j, i) -= k;
  };
  add(0, -1, 2e4);
  add(0, 1, strut);
  add(1, 2, 3e4);
  add(2, 3, 1e4);
  add(3, -1, 4e3);
  return K;
}

TEST(GlobalModalDamping, GivesEveryModeOfTheWholeItsRatio) {
  const std::vector<double> ratios{0.01, 0.03};
  const auto model = structure(GlobalModalDamping{ratios});
  const auto& system = model.system();
  // the same sums
  EXPECT_LT((MatrixXd(stiffness_at_rest(system)) - stiffness_by_hand()).norm(), 1e-15 * stiffness_by_hand().norm());
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(stiffness_by_hand(), MatrixXd(system.mass));
  const MatrixXd damping = modes.eigenvectors().transpose() * system.full_damping() * modes.eigenvectors();
  MatrixXd expected = MatrixXd::Zero(4, 4);
  for (int i = 0; i < 4; ++i) expected(i, i) = 2.0 * (i == 0 ? 0.01 : 0.03) * std::sqrt(modes.eigenvalues()[i]);
  EXPECT_LT((damping - expected).norm(), 1e-12 * expected.norm());  // the eigensolvers' rounding
}

TEST(GlobalModalDamping, DoesNotDragAtWhatMovesWithTheGround) {
  const auto damped = structure(GlobalModalDamping{{0.05}}), undamped = structure({});
  // Both springs and the tie stand on the one ground: the structure follows it as a whole.
  const VectorXd cross_damping = damped.system().full_damping() * VectorXd::Ones(4);
  const VectorXd carried = damped.system().inputs[1].rate - undamped.system().inputs[1].rate;
  EXPECT_GT(cross_damping.norm(), 1.0);
  // rounding of the modes, found 3e-16
  EXPECT_LT((cross_damping - carried).norm(), 1e-13 * cross_damping.norm());
  EXPECT_EQ(damped.system().inputs[0].rate, undamped.system().inputs[0].rate);
}

TEST(GlobalModalDamping, BeyondItsLimitModesHaveTheRateOfTheLastOne) {
  const auto model = structure(GlobalModalDamping{{0.02}, 15.0});
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(stiffness_by_hand(), MatrixXd(model.system().mass));
  const VectorXd omega = modes.eigenvalues().cwiseSqrt();
  const auto below = (omega.array() <= 2.0 * std::numbers::pi * 15.0).count();
  ASSERT_GT(below, 0);
  ASSERT_LT(below, 4);
  const VectorXd rates =
      (modes.eigenvectors().transpose() * model.system().full_damping() * modes.eigenvectors()).diagonal();
  for (Eigen::Index i = 0; i < 4; ++i)
    // rounding of the modes
    EXPECT_NEAR(rates[i], 0.04 * omega[std::min(i, below - 1)], 1e-14 * omega[3]) << i;
}

TEST(GlobalModalDamping, IsRefusedBesideModalDampingAndWithoutElasticity) {
  const auto message_of = [](const std::function<void()>& work) -> std::string {
    try {
      work();
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message_of([] { structure(GlobalModalDamping{{-0.1}}); }).find("ratio"), std::string::npos);
  const auto bottomless = function_law([](double, double) {
    return FunctionLaw::Value{0.0, std::numeric_limits<double>::infinity(), 0.0};
  });
  LumpedSubstructure body{.name = "body", .masses = {{"x", 1.0}}, .springs = {{"s", "ground", "x", 1e3}}};
  EXPECT_NE(message_of([&] {
              CoupledModel({{"body", assemble(body)}}, {{"odd", "body.ground", "body.x", bottomless, VectorXd()}}, {},
                           GlobalModalDamping{{0.01}});
            }).find("'odd'"),
            std::string::npos);
}

}  // namespace
}  // namespace kalfem
