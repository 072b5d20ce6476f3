// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "identification/updated_loop.hpp"
#include "kalfem/identification/finer_motion.hpp"
#include "kalfem/updating/gauss_newton.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// With hardly any noise what is left are errors of the method: straight boundary motion between the samples, nine of
/// them in a period of the fastest mode, made the damping 1.5 % too small.
TEST(UpdatedLoop, FindsTheDampingOfAStructureThatAnotherIntegratorSimulated) {
  const double duration = 4.0;
  const auto problem = shared(loop_problem(duration, 0.002));
  const auto record = loop_record(*problem, LoopSimulator(problem->structure, duration).run(), 1);
  const auto residual = loop_residual(problem, record);
  const auto found = minimise(residual, loop_setup(*problem->structure).parameters, {.search = {.cost_floor = 1e-6}});
  EXPECT_TRUE(found.usable()) << found.reason();
  const Eigen::Vector3d error = (found.parameters - loop_truth()).cwiseQuotient(loop_truth()).cwiseAbs();
  EXPECT_LT(error[0], 5e-4);
  EXPECT_LT(error[1], 5e-4);
  EXPECT_LT(error[2], 4e-3);
}

/// A sine of nine samples a period, between its samples.
TEST(FinerMotion, FollowsASineBetweenTheSamples) {
  const Index samples = 91, factor = 4;
  const auto sine = [](Index count, double step) {
    return Eigen::RowVectorXd::NullaryExpr(
        count, [=](Index k) { return std::sin(2.0 * EIGEN_PI / 9.0 * step * static_cast<double>(k)); });
  };
  const MatrixXd given = sine(samples, 1.0);
  const BoundaryMotion fine_motion = finer_motion({given, 2.0 * given, 3.0 * given}, factor);
  const MatrixXd expected = sine(factor * (samples - 1) + 1, 1.0 / static_cast<double>(factor));
  const auto inner = Eigen::seqN(20, factor * (samples - 1) - 39);
  EXPECT_LT((fine_motion.displacement - expected)(Eigen::all, inner).cwiseAbs().maxCoeff(), 1e-3);  // straight: 0.06
  EXPECT_LT((fine_motion.velocity - 2.0 * fine_motion.displacement).norm(), 1e-12);
  EXPECT_EQ(MatrixXd(fine_motion.acceleration(Eigen::all, Eigen::seqN(0, samples, factor))), MatrixXd(3.0 * given));
}

}  // namespace
}  // namespace kalfem::test
