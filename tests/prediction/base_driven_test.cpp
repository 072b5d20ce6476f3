// SPDX-License-Identifier: Apache-2.0
#include "kalfem/prediction/base_driven.hpp"

#include <gtest/gtest.h>

#include "dynamics/closed_forms.hpp"
#include "kalfem/system/signals/random_signal.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The error of a predicted motion relative to the size of the true one.
double error(const MatrixXd& predicted, const MatrixXd& truth) { return (predicted - truth).norm() / truth.norm(); }

std::string message_of(const LinearModel& model, const std::vector<Index>& boundary) {
  try {
    const BaseDrivenSubstructure prediction(model, boundary);
  } catch (const InvalidInput& e) {
    return e.what();
  }
  return "";
}

SparseRows all_points(Index n) {
  SparseRows rows(n, n);
  rows.setIdentity();
  return rows;
}

/// Every degree of freedom of a body driven from the given start, without loads of its own.
PredictedMotion driven(const BaseDrivenSubstructure& body, const BoundaryMotion& boundary, const VectorXd& displacement,
                       const VectorXd& velocity, double sample_rate) {
  return body.predict(all_points(displacement.size()), boundary, {}, {0.0, displacement, velocity},
                      {.sample_rate = sample_rate});
}

class DrivenBody : public testing::Test {
protected:
  CoupledModel model =
      quarter_chain(10, {{"suspension", "wheel.w", "body.1", make_law("saturating"), saturating_parameters()}},
                    {{"road", InputKind::base_displacement, "wheel.ground"}, {"F", InputKind::force, "body.6"}});
  std::vector<SignalPtr> signals{
      make_random({.rms = 3e-3, .lower = 0.5, .upper = 30.0, .duration = 4.0, .fade_in = 0.3, .seed = 7}),
      make_random({.rms = 2.0, .lower = 1.0, .upper = 20.0, .duration = 4.0, .fade_in = 0.3, .seed = 8})};
  const LinearModel& body = *model.substructures()[1].model;

  [[nodiscard]] Trajectory simulated(double step, double duration, Index keep) const {
    auto start = at_rest(11, 0);
    start.displacement.tail(10).setLinSpaced(1e-3, 3e-3);  // not at rest: the interior starts with a motion of its own
    start.velocity.tail(10).setConstant(0.02);
    return simulate(model.system(), signals, start,
                    {.integrator = Integrator::newmark, .step = step, .duration = duration, .keep_every = keep})
        .trajectory;
  }
  [[nodiscard]] PredictedMotion predicted(const Trajectory& truth, bool with_force, Index exact_up_to = 400) const {
    return BaseDrivenSubstructure(body, {0}).predict(
        all_points(10), {truth.displacement.row(1), truth.velocity.row(1), truth.acceleration.row(1)},
        with_force ? force() : std::vector<AppliedInput>{},
        {0.0, truth.displacement.col(0).tail(10), truth.velocity.col(0).tail(10)},
        {.sample_rate = 1.0 / truth.step, .exact_up_to = exact_up_to, .newmark_substeps = 8});
  }
  [[nodiscard]] std::vector<AppliedInput> force() const {
    const VectorXd none = VectorXd::Zero(10);
    return {{{"F", "N", VectorXd::Unit(10, 5), none, none}, signals[1]}};
  }
};

TEST_F(DrivenBody, ByTheTrueBoundaryMotionEqualsTheWholeSimulation) {
  const auto error_at = [&](Index substeps) {
    const auto truth = simulated(1e-3 / 16, 2.0, 16 / substeps);
    const auto motion = predicted(truth, true);
    return Eigen::Array3d(error(motion.displacement, truth.displacement.bottomRows(10)),
                          error(motion.velocity, truth.velocity.bottomRows(10)),
                          error(motion.acceleration, truth.acceleration.bottomRows(10)));
  };
  // Boundary accelerations are taken as straight between samples, where the suspension's kinks bend them: second order
  // in the sampling interval.
  const Eigen::Array3d coarse = error_at(1), fine = error_at(8);
  // found .0096
  EXPECT_LT(coarse.maxCoeff(), 0.02) << coarse.transpose();
  // found 2e-4, and a ratio of .07: 64 for a smooth law
  EXPECT_LT(fine.maxCoeff(), 4e-4) << fine.transpose();
  EXPECT_LT((fine / coarse).maxCoeff(), 1.0 / 8) << (fine / coarse).transpose();
}

TEST_F(DrivenBody, NewmarkAndExactSteppingAgree) {
  const auto truth = simulated(1e-3 / 16, 1.0, 4);
  const auto exact = predicted(truth, true), stepped = predicted(truth, true, 0);
  // found 4e-5
  EXPECT_LT(error(stepped.acceleration, exact.acceleration), 1e-4);  // (omega h)^2 / 12 at 50 Hz and 31 us
  EXPECT_GT(error(stepped.acceleration, exact.acceleration), 1e-9);  // and they are two ways
}

TEST_F(DrivenBody, ModalDampingOfLowRankEqualsTheDenseMatrix) {
  const auto truth = simulated(1e-3 / 4, 1.0, 4);
  LinearModel low_rank = body;
  low_rank.modal_damping.modes = normal_modes(body.mass, body.stiffness);
  low_rank.modal_damping.rates = VectorXd::LinSpaced(10, 1.0, 30.0);
  LinearModel dense = body;
  const MatrixXd mass_weighted_modes = body.mass * low_rank.modal_damping.modes.shapes;
  dense.damping += SparseMatrix(
      MatrixXd(mass_weighted_modes * low_rank.modal_damping.rates.asDiagonal() * mass_weighted_modes.transpose())
          .sparseView());
  const auto predict = [&](const LinearModel& damped, Index exact_up_to) {
    return BaseDrivenSubstructure(damped, {0})
        .predict(all_points(10), {truth.displacement.row(1), truth.velocity.row(1), truth.acceleration.row(1)}, force(),
                 {0.0, truth.displacement.col(0).tail(10), truth.velocity.col(0).tail(10)},
                 {.sample_rate = 1.0 / truth.step, .exact_up_to = exact_up_to});
  };
  for (const Index exact_up_to : {0, 400}) {
    // found 1e-12: rounding of a thousand steps
    EXPECT_LT(error(predict(low_rank, exact_up_to).acceleration, predict(dense, exact_up_to).acceleration), 2e-11);
    EXPECT_GT(error(predict(body, exact_up_to).acceleration, predict(dense, exact_up_to).acceleration), 1e-2);
  }
}

TEST_F(DrivenBody, WithoutTheAppliedForceTheDifferenceShows) {
  const auto truth = simulated(1e-3 / 4, 1.0, 4);
  EXPECT_GT(error(predicted(truth, false).acceleration, truth.acceleration.bottomRows(10)), 0.02);
}

TEST_F(DrivenBody, BoundaryOfTwoKeepsItsOrder) {
  const auto truth = simulated(1e-3 / 8, 1.0, 2);
  const BaseDrivenSubstructure prediction(body, {9, 0});
  EXPECT_EQ(prediction.boundary(), (std::vector<Index>{9, 0}));
  EXPECT_EQ(prediction.interior().size(), 8u);
  const std::vector<Index> ends{10, 1};
  const auto motion = prediction.predict(
      all_points(10),
      {truth.displacement(ends, Eigen::all), truth.velocity(ends, Eigen::all), truth.acceleration(ends, Eigen::all)},
      force(), {0.0, truth.displacement.col(0).tail(10), truth.velocity.col(0).tail(10)},
      {.sample_rate = 1.0 / truth.step});
  // found 5e-4: straight boundary accelerations, second order in h
  EXPECT_LT(error(motion.acceleration, truth.acceleration.bottomRows(10)), 1.5e-3);
  // the boundary is handed through: rounding
  EXPECT_LT(error(motion.displacement.row(9), truth.displacement.row(10)), 3e-14);
}

TEST(BaseDriven, RigidMotionOfTheBoundaryIsFollowedWithoutDrift) {
  // A body held nowhere else rides on its boundary: after 200 s at constant velocity it still lies on it to rounding.
  const auto model = quarter_chain(5, {}, {}, 0.02);
  const BaseDrivenSubstructure body(*model.substructures()[1].model, {0});
  const Index samples = 20001;
  BoundaryMotion boundary{MatrixXd(1, samples), MatrixXd::Constant(1, samples, 0.5), MatrixXd::Zero(1, samples)};
  for (Index k = 0; k < samples; ++k) boundary.displacement(0, k) = 0.5 * 0.01 * static_cast<double>(k);
  const auto motion = driven(body, boundary, VectorXd::Zero(5), VectorXd::Constant(5, 0.5), 100.0);
  // rounding of 100 m
  EXPECT_LT((motion.displacement.rowwise() - boundary.displacement.row(0)).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT(motion.acceleration.cwiseAbs().maxCoeff(), 1e-12);
}

TEST(BaseDriven, ConstantAccelerationBendsTheBodyStatically) {
  // q = -K^-1 M 1 a once the damped motion has settled: for one mass m on a spring k below it, -m a / k.
  LumpedSubstructure pair;
  pair.masses = {{"base", 1.0}, {"top", 2.0}};
  pair.springs = {{"s", "base", "top", 800.0, 40.0}};
  const BaseDrivenSubstructure body(assemble(pair), {0});
  const double rate = 100.0, a = 3.0;
  const Index samples = 201;
  BoundaryMotion boundary{MatrixXd(1, samples), MatrixXd(1, samples), MatrixXd::Constant(1, samples, a)};
  for (Index k = 0; k < samples; ++k) {
    const double t = static_cast<double>(k) / rate;
    boundary.displacement(0, k) = 0.5 * a * t * t;
    boundary.velocity(0, k) = a * t;
  }
  const auto motion = driven(body, boundary, VectorXd::Zero(2), VectorXd::Zero(2), rate);
  const double lag = motion.displacement(1, samples - 1) - boundary.displacement(0, samples - 1);
  EXPECT_NEAR(lag, -2.0 * a / 800.0, 5e-11);  // exp(-10 rad/s 2 s) = 2e-9 of it is left to settle
  EXPECT_NEAR(motion.acceleration(1, samples - 1), a, 1.5e-8);
}

TEST(BaseDriven, MassAndDampingBetweenBoundaryAndInteriorCount) {
  // Consistent mass and a dashpot across: m_ii q'' + c q' + k q = -(m_ii + m_ib) a_b under a constant a_b settles at
  // q = -(m_ii + m_ib) a_b / k; the dashpot c_ib = -c sees no rigid motion.
  SparseMatrix mass(2, 2), damping(2, 2), stiffness(2, 2);
  const double k = 800.0, c = 40.0, a = 3.0, rate = 100.0;
  mass.coeffRef(0, 0) = mass.coeffRef(1, 1) = 2.0;
  mass.coeffRef(0, 1) = mass.coeffRef(1, 0) = 0.5;
  stiffness.coeffRef(0, 0) = stiffness.coeffRef(1, 1) = k;
  stiffness.coeffRef(0, 1) = stiffness.coeffRef(1, 0) = -k;
  damping = (c / k) * stiffness;
  const BaseDrivenSubstructure body({{"base", "top"}, mass, damping, stiffness, {}, {}, {}, false, {}}, {0});
  const Index samples = 201;
  BoundaryMotion boundary{MatrixXd(1, samples), MatrixXd(1, samples), MatrixXd::Constant(1, samples, a)};
  for (Index n = 0; n < samples; ++n) {
    const double t = static_cast<double>(n) / rate;
    boundary.displacement(0, n) = 0.5 * a * t * t;
    boundary.velocity(0, n) = a * t;
  }
  const auto motion = driven(body, boundary, VectorXd::Zero(2), VectorXd::Zero(2), rate);
  const double lag = motion.displacement(1, samples - 1) - boundary.displacement(0, samples - 1);
  // found 2e-11: what has not settled yet
  EXPECT_NEAR(lag, -2.5 * a / k, 5e-11);
}

TEST(BaseDriven, PartThatFloatsIsNamed) {
  LumpedSubstructure parts;
  parts.masses = {{"base", 1.0}, {"held", 1.0}, {"loose", 1.0}};
  parts.springs = {{"s", "base", "held", 1e4}};
  const auto message = message_of(assemble(parts), {0});
  EXPECT_NE(message.find("moves freely at 'loose'"), std::string::npos) << message;
}

TEST(BaseDriven, NoBoundaryOrNoInteriorIsRefused) {
  LumpedSubstructure pair;
  pair.masses = {{"a", 1.0}, {"b", 1.0}};
  pair.springs = {{"s", "a", "b", 1e4}};
  EXPECT_NE(message_of(assemble(pair), {}).find("no connector"), std::string::npos);
  EXPECT_NE(message_of(assemble(pair), {0, 1}).find("no degree of freedom other than"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
