// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/connector_forces.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>

#include "kalfem/base/random.hpp"
#include "system/law_bench.hpp"
#include "system/small_systems.hpp"

namespace kalfem {
namespace {

using Eigen::MatrixXd;

constexpr double step = 1e-3;  // [s]

LocallyNonlinearSystem connectors_only(const std::vector<LawCase>& cases) {
  LocallyNonlinearSystem system;
  for (const auto& of : cases) {
    const Eigen::VectorXd parameters =
        Eigen::Map<const Eigen::VectorXd>(of.parameters.data(), Eigen::Index(of.parameters.size()));
    system.connectors.push_back({of.label, of.law, parameters, {}, {}});
  }
  return system;
}

/// The compliance of masses m under Newmark's method: force resists, d = -h^2/4 f/m, v = -h/2 f/m, a = -f/m.
MatrixXd compliance(const MatrixXd& mobility) {
  MatrixXd H(3 * mobility.rows(), mobility.cols());
  H << -0.25 * step * step * mobility, -0.5 * step * mobility, -mobility;
  return H;
}

/// f with f = law(k_free + H f) by bisection: f - law falls with no f because the compliance is negative.
double by_bisection(const LawCase& of, const Eigen::Array3d& begin, const Eigen::Array3d& free, const MatrixXd& H,
                    double state) {
  const auto excess = [&](double f) {
    LawBench bench(of);
    bench.begin_deformation = begin[0];
    bench.begin_rate = begin[1];
    bench.begin_states.setConstant(state);
    bench.deformation = free[0] + H(0, 0) * f;
    bench.rate = free[1] + H(1, 0) * f;
    bench.acceleration = free[2] + H(2, 0) * f;
    bench.respond(step);
    return f - bench.force[0];
  };
  double lower = -1e9, upper = 1e9;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (lower + upper);
    (excess(middle) < 0.0 ? lower : upper) = middle;
  }
  return 0.5 * (lower + upper);
}

std::vector<LawCase> monotone_laws() {
  return {{"saturating", make_law("saturating"), {5e3, 20.0, 2e-3, 10.0, 10.0, 0.05}},
          {"sharp", make_law("saturating"), {5e3, 2e4, 1e-6, 10.0, 1e4, 1e-5}},
          {"gap", make_law("gap"), {1e9, 1e3, 4e-4, 6e-4, 2e3, 5.0}},
          {"coulomb", make_law("coulomb"), {1e3, 1e-6, 1e3, 1.0}},
          {"jenkins", make_law("jenkins"), {1e7, 5.0, 1e3, 1.0}},
          {"bilinear", make_law("bilinear"), {1e6, 5.0, 0.05, 1.0}},
          {"cubic", make_law("cubic"), {5e3, 1e12, 10.0, 1e3}},
          {"inerter", make_law("inerter"), {3.0}}};
}

TEST(ConnectorForces, SolveIsTheRootThatBisectionFinds) {
  RandomStream random(1, "roots");
  const MatrixXd H = compliance(MatrixXd::Constant(1, 1, 1.0 / 1.5));
  for (const auto& of : monotone_laws()) {
    ConnectorForces forces(connectors_only({of}));
    for (int trial = 0; trial < 50; ++trial) {
      Eigen::Array3d begin, free;
      begin << 2e-3 * random.normal(), 0.3 * random.normal(), 0.0;
      free << begin[0] + 5e-4 * random.normal(), begin[1] + 0.1 * random.normal(), 100.0 * random.normal();
      const double state = of.law->states().empty() ? 0.0 : begin[0];
      forces.begin_motion().row(0) = begin.transpose();
      forces.free_motion().row(0) = free.transpose();
      forces.begin_states().setConstant(state);
      const auto outcome = forces.solve(H, step);
      EXPECT_TRUE(outcome.converged && outcome.finite) << of.label << " trial " << trial;
      const double expected = by_bisection(of, begin, free, H, state);
      // The stopping rule leaves at most its tolerance of the force; bisection itself resolves 1e9 * 2e-16.
      EXPECT_NEAR(forces.force()(0, 0), expected, 1e-9 * std::abs(expected) + 1e-9) << of.label << " trial " << trial;
    }
  }
}

/// The dashpot of a stop acts at once: no force satisfies the equation where neither the open stop nor the closed one
/// does, and the one within the jump holds the motion at the gap.
TEST(ConnectorForces, AtAJumpTheMotionIsHeldThere) {
  const double gap = 4e-4, c_stop = 1e4;
  const LawCase stop{"gap", make_law("gap"), {1e5, c_stop, gap, 6e-4, 0.0, 0.0}};
  const MatrixXd H = compliance(MatrixXd::Constant(1, 1, 1.0 / 1.5));
  ConnectorForces forces(connectors_only({stop}));
  const double over = 1e-7, rate = 0.3, expected = over / -H(0, 0);
  ASSERT_LT(expected, c_stop * rate * 0.5);
  forces.free_motion().row(0) << gap + over, rate, 0.0;
  const auto outcome = forces.solve(H, step);
  EXPECT_TRUE(outcome.converged && outcome.finite);
  EXPECT_NEAR(forces.motion()(0, 0), gap, 1e-12);
  EXPECT_NEAR(forces.force()(0, 0), expected, 1e-6 * expected);
}

TEST(ConnectorForces, FourUncoupledConnectorsAreFourSingleOnes) {
  const auto laws = monotone_laws();
  const std::vector<LawCase> four(laws.begin(), laws.begin() + 4);
  const Eigen::Vector4d mobility(0.5, 1.0, 0.1, 2.0);
  ConnectorForces together(connectors_only(four));
  RandomStream random(2, "four");
  for (Eigen::Index column = 0; column < 8; ++column) {
    const double size = column < 4 ? 1e-3 : 0.2;
    together.free_motion()(0, column) = size * random.normal();
  }
  ASSERT_TRUE(together.solve(compliance(mobility.asDiagonal()), step).converged);
  for (Eigen::Index j = 0; j < 4; ++j) {
    ConnectorForces single(connectors_only({four[std::size_t(j)]}));
    for (Eigen::Index k = 0; k < 3; ++k) single.free_motion()(0, k) = together.free_motion()(0, 4 * k + j);
    ASSERT_TRUE(single.solve(compliance(MatrixXd::Constant(1, 1, mobility[j])), step).converged);
    const double f = single.force()(0, 0);
    // rounding: alike connectors take the same steps
    EXPECT_NEAR(together.force()(0, j), f, 1e-12 * std::abs(f) + 1e-12) << four[std::size_t(j)].label;
  }
}

TEST(ConnectorForces, CoupledConnectorsAtManyPointsSatisfyTheirEquations) {
  const auto laws = monotone_laws();
  const std::vector<LawCase> four{laws[0], laws[1], laws[2], laws[6]};
  MatrixXd mobility = MatrixXd::Constant(4, 4, 0.3);
  mobility.diagonal().array() += 0.5;
  const Eigen::Index points = 49;
  ConnectorForces forces(connectors_only(four));
  forces.resize(points);
  RandomStream random(4, "points");
  for (Eigen::Index i = 0; i < points; ++i)
    for (Eigen::Index j = 0; j < 8; ++j) forces.free_motion()(i, j) = (j < 4 ? 1e-3 : 0.2) * random.normal();
  ASSERT_TRUE(forces.solve(compliance(mobility), step).converged);
  for (Eigen::Index j = 0; j < 4; ++j) {
    LawBench bench(four[std::size_t(j)], points);
    bench.deformation = forces.motion().col(j);
    bench.rate = forces.motion().col(4 + j);
    bench.acceleration = forces.motion().col(8 + j);
    bench.respond(step);
    // the stopping rule's tolerance: found 2e-8
    EXPECT_LT((bench.force - forces.force().col(j)).abs().maxCoeff(), 1e-7 * bench.force.abs().maxCoeff())
        << four[std::size_t(j)].label;
  }
}

/// Laws of all kinds: vectorised and point by point, with and without states, with inertance.
std::vector<LawCase> all_kinds() {
  return {{"saturating", make_law("saturating"), {5e3, 20.0, 2e-3, 10.0, 10.0, 0.05}},
          {"jenkins", make_law("jenkins"), {4e4, 12.0, 1e3, 3.0}},
          {"coulomb", make_law("coulomb"), {12.0, 0.02, 1e3, 2.0}},
          {"bouc_wen", make_law("bouc_wen"), {4e4, 0.1, 1.0, 2e6, 1e6, 2.0, 3.0}},
          {"inerter", make_law("inerter"), {0.2}},
          {"gap", make_law("gap"), {1e5, 50.0, 4e-4, 6e-4, 2e3, 5.0}}};
}

/// Motion, states and first parameters that differ from point to point.
void draw_points(ConnectorForces& forces, const std::vector<LawCase>& laws) {
  RandomStream random(7, "points");
  const auto m = Eigen::Index(laws.size());
  for (Eigen::Index i = 0; i < forces.points(); ++i) {
    for (Eigen::Index j = 0; j < m; ++j) {
      forces.begin_motion()(i, j) = 1e-3 * random.normal();
      forces.begin_motion()(i, m + j) = 0.1 * random.normal();
      forces.free_motion()(i, j) = forces.begin_motion()(i, j) + 2e-4 * random.normal();
      forces.free_motion()(i, m + j) = forces.begin_motion()(i, m + j) + 0.05 * random.normal();
      forces.free_motion()(i, 2 * m + j) = 50.0 * random.normal();
      forces.parameter(j, 0)[i] = laws[std::size_t(j)].parameters[0] * (1.0 + 0.1 * random.normal());
    }
    for (Eigen::Index j = 0; j < forces.begin_states().cols(); ++j)
      forces.begin_states()(i, j) = 2e-4 * random.normal();
  }
}

/// The same point on its own.
void set_point(ConnectorForces& one, ConnectorForces& all, Eigen::Index i, Eigen::Index connectors) {
  one.begin_motion() = all.begin_motion().row(i);
  one.free_motion() = all.free_motion().row(i);
  one.begin_states() = all.begin_states().row(i);
  for (Eigen::Index j = 0; j < connectors; ++j) one.parameter(j, 0)[0] = all.parameter(j, 0)[i];
}

TEST(ConnectorForces, PointsDoNotFeelEachOther) {
  for (const int connectors : {1, 2, 3, 4, 5, 6}) {
    const auto kinds = all_kinds();
    const std::vector<LawCase> laws(kinds.begin(), kinds.begin() + connectors);
    MatrixXd mobility = MatrixXd::Constant(connectors, connectors, 0.1);
    mobility.diagonal().array() += 0.5;
    const MatrixXd H = compliance(mobility);
    MatrixXd instant = H;
    instant.topRows(2 * connectors).setZero();
    for (const int points : {1, 3, 4, 5, 7, 8, 9, 13, 16, 37})
      for (const double duration : {step, 0.0}) {
        ConnectorForces all(connectors_only(laws)), one(connectors_only(laws));
        all.resize(points);
        draw_points(all, laws);
        const MatrixXd& at = duration > 0.0 ? H : instant;
        ASSERT_TRUE(all.solve(at, duration).converged);
        for (Eigen::Index i = 0; i < points; ++i) {
          set_point(one, all, i, connectors);
          one.force().setZero();
          ASSERT_TRUE(one.solve(at, duration).converged);
          // A point that is done goes on with the others: it differs by the tolerance of 1e-8, squared, and rounding.
          const auto near = [](const auto& a, const auto& b, double scale) {
            return ((a - b).abs() <= 1e-9 * (a.abs() + scale)).all();
          };
          const auto label = std::to_string(connectors) + " connectors, point " + std::to_string(i) + " of " +
                             std::to_string(points) + ", duration " + std::to_string(duration);
          EXPECT_TRUE(near(all.force().row(i), one.force().row(0), 1e-3)) << label;
          EXPECT_TRUE(near(all.motion().row(i), one.motion().row(0), 1e-6)) << label;
          EXPECT_TRUE(near(all.states().row(i), one.states().row(0), 1e-6)) << label;
        }
      }
  }
}

TEST(ConnectorForces, MotionIsThatOfTheForces) {
  for (const int connectors : {1, 4, 6})
    for (const bool instant : {false, true}) {
      const auto kinds = all_kinds();
      const std::vector<LawCase> laws(kinds.begin(), kinds.begin() + connectors);
      MatrixXd mobility = MatrixXd::Constant(connectors, connectors, 0.1);
      mobility.diagonal().array() += 0.5;
      MatrixXd H = compliance(mobility);
      if (instant) H.topRows(2 * connectors).setZero();
      ConnectorForces forces(connectors_only(laws));
      forces.resize(13);
      draw_points(forces, laws);
      ASSERT_TRUE(forces.solve(H, instant ? 0.0 : step).converged);
      const Eigen::ArrayXXd expected = forces.free_motion() + (forces.force().matrix() * H.transpose()).array();
      // rounding of a product of up to eight terms, some of which cancel
      EXPECT_LT(((forces.motion() - expected).abs() / (expected.abs() + 1e-3)).maxCoeff(), 1e-12) << connectors;
    }
}

TEST(ConnectorForces, ParametersStayUntilTheyAreSetAgain) {
  const LawCase linear{"linear", make_law("linear"), {100.0, 0.0}};
  ConnectorForces forces(connectors_only({linear}));
  forces.resize(9);
  const MatrixXd none = MatrixXd::Zero(3, 1);
  const auto force = [&](double deformation) {
    forces.free_motion().col(0) = deformation;
    EXPECT_TRUE(forces.solve(none, 0.0).finite);
    EXPECT_EQ((forces.force() - forces.force()(0, 0)).abs().maxCoeff(), 0.0);
    return forces.force()(0, 0);
  };
  EXPECT_EQ(force(1.0), 100.0);
  forces.parameter(0, 0) = 200.0;
  EXPECT_EQ(force(1.0), 200.0);
  EXPECT_EQ(force(2.0), 400.0);
  forces.parameter(0, 0) = 300.0;
  EXPECT_EQ(force(1.0), 300.0);
  forces.resize(9);
  EXPECT_EQ(force(1.0), 100.0);
}

TEST(ConnectorForces, SmallPivotsAreExchanged) {
  // Linear laws with negative tangents: 1 - T H is any matrix one likes, and one correction solves it.
  const auto law = [](double stiffness) {
    return function_law([stiffness](double d, double) { return FunctionLaw::Value{stiffness * d, stiffness, 0.0}; });
  };
  for (const int connectors : {2, 3, 4, 5}) {
    MatrixXd J = MatrixXd::Constant(connectors, connectors, 1.0);  // zero pivots, and small ones after elimination
    J.diagonal().setZero();
    J(1, 1) = 1e-13;
    for (const double first : {0.0, 1e-14, -1e-9, 1e-5}) {
      J(0, 0) = first;
      std::vector<LawCase> laws;
      for (int j = 0; j < connectors; ++j) laws.push_back({"negative", law(j % 2 == 0 ? -100.0 : 100.0), {}});
      MatrixXd H = MatrixXd::Zero(3 * connectors, connectors);
      for (int j = 0; j < connectors; ++j)
        H.row(j) = (MatrixXd::Identity(connectors, connectors) - J).row(j) * (j % 2 == 0 ? -0.01 : 0.01);
      ConnectorForces forces(connectors_only(laws));
      forces.resize(11);
      for (Eigen::Index i = 0; i < 11; ++i)
        for (Eigen::Index j = 0; j < connectors; ++j) forces.free_motion()(i, j) = std::sin(double(3 * i + j) + 1.0);
      const auto outcome = forces.solve(H, step);
      ASSERT_TRUE(outcome.converged && outcome.finite);
      EXPECT_LE(outcome.iterations, 1);
      for (Eigen::Index j = 0; j < connectors; ++j) {
        const Eigen::ArrayXd expected = (j % 2 == 0 ? -100.0 : 100.0) * forces.motion().col(j);
        // rounding of forces of 100 N
        EXPECT_LT((forces.force().col(j) - expected).abs().maxCoeff(), 1e-12) << connectors << " " << first;
      }
    }
  }
}

TEST(ConnectorForces, CorrectionsThatOvershootAreHalvedAtTheirPoints) {
  // With H = -1 the equation is g(d) = d_free, g(d) = (d - 1)^3 + 0.01 (d - 1): flat where the solve starts.
  const auto law = function_law([](double d, double) {
    const double x = d - 1.0;
    return FunctionLaw::Value{x * x * x + 0.01 * x - d, 3.0 * x * x + 0.01 - 1.0, 0.0};
  });
  for (const int points : {1, 13}) {
    ConnectorForces forces(connectors_only({{"flat", law, {}}}));
    forces.resize(points);
    MatrixXd H = MatrixXd::Zero(3, 1);
    H(0, 0) = -1.0;
    for (Eigen::Index i = 0; i < points; ++i) forces.free_motion()(i, 0) = 0.5 * std::sin(double(i) + 1.0);
    forces.force() = forces.free_motion().col(0) - 1.0;
    const auto outcome = forces.solve(H, step);
    ASSERT_TRUE(outcome.converged && outcome.finite);
    EXPECT_LE(outcome.iterations, 10);  // without halving a correction of 50 comes back by a third each time
    for (Eigen::Index i = 0; i < points; ++i) {
      const double x = forces.motion()(i, 0) - 1.0;
      // the last step of Newton's method ends in rounding
      EXPECT_NEAR(x * x * x + 0.01 * x, forces.free_motion()(i, 0), 1e-13) << i;
    }
  }
}

TEST(ConnectorLaw, SaysWhetherItUsesTheAcceleration) {
  std::vector<LawCase> cases = monotone_laws();
  for (const auto& of : all_kinds()) cases.push_back(of);
  cases.push_back({"stribeck", make_law("stribeck"), {12.0, 18.0, 0.05, 0.005, 1e3, 2.0}});
  cases.push_back({"linear", make_law("linear"), {5e3, 10.0}});
  cases.push_back({"preload", make_law("preload"), {7.0}});
  cases.push_back({"polynomial", make_law("polynomial", {.parameters = {{"k1"}, {"c1"}}}), {5e3, 10.0}});
  cases.push_back({"linear_change", make_law("linear_change", {.nominal = {4e3, 8.0, 1.0}}), {5e3, 10.0, 2.0}});
  cases.push_back({"with", make_law("expression", {.parameters = {{"b"}}, .force = "x + b*a"}), {2.0}});
  cases.push_back({"without", make_law("expression", {.parameters = {{"ba"}}, .force = "x*ba + abs(v)"}), {2.0}});
  int users = 0;
  for (const auto& of : cases) {
    LawBench still(of), moving(of);
    const bool depends = still.step(step, 1e-4, 0.01, 0.0) != moving.step(step, 1e-4, 0.01, 5.0);
    EXPECT_EQ(of.law->uses_acceleration(), depends) << of.label;
    users += depends ? 1 : 0;
  }
  EXPECT_EQ(users, 4);  // two inerters, linear_change and the expression with `a`
}

TEST(ConnectorForces, StatesAtTheEndBelongToTheMotionAtTheEnd) {
  const LawCase jenkins{"jenkins", make_law("jenkins"), {1e7, 5.0, 1e3, 1.0}};
  ConnectorForces forces(connectors_only({jenkins}));
  forces.free_motion().row(0) << 1e-3, 0.5, 0.0;
  const auto H = compliance(MatrixXd::Constant(1, 1, 1.0));
  ASSERT_TRUE(forces.solve(H, step).converged);
  // Sliding: q = k_stick (d - slip) = f_slip.
  EXPECT_NEAR(forces.states()(0, 0), forces.motion()(0, 0) - 5.0 / 1e7, 1e-15);  // rounding
}

TEST(ConnectorForces, NoConnectorsIsNoWork) {
  ConnectorForces forces(LocallyNonlinearSystem{});
  EXPECT_TRUE(forces.solve(MatrixXd::Zero(0, 0), step).converged);
}

TEST(ConnectorForces, LawThatIsNotFiniteIsReported) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (const int connectors : {1, 4}) {
      const auto law = function_law([bad](double, double) { return FunctionLaw::Value{bad, 0.0, 0.0}; });
      ConnectorForces forces(connectors_only(std::vector<LawCase>(std::size_t(connectors), {"bad", law, {}})));
      const auto outcome = forces.solve(compliance(MatrixXd::Identity(connectors, connectors)), step);
      EXPECT_FALSE(outcome.finite) << bad << " " << connectors;
    }
}

TEST(ConnectorForces, MotionThatIsNotFiniteIsReported) {
  ConnectorForces forces(connectors_only({monotone_laws()[0]}));
  forces.free_motion()(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(forces.solve(compliance(MatrixXd::Identity(1, 1)), step).finite);
}

TEST(ConnectorForces, EquationWithoutARootEndsAsNotConverged) {
  const auto law = function_law([](double d, double) {
    return FunctionLaw::Value{1.0 + d + d * d, 1.0 + 2.0 * d, 0.0};
  });
  ConnectorForces forces(connectors_only({{"parabola", law, {}}}));
  MatrixXd H = MatrixXd::Zero(3, 1);
  H(0, 0) = 1.0;  // d = f, and f = 1 + f + f^2 has no real root
  forces.free_motion().setZero();
  forces.force().setConstant(0.3);
  const auto outcome = forces.solve(H, step);
  EXPECT_FALSE(outcome.converged);
  EXPECT_LE(outcome.iterations, ForceSolveOptions{}.max_iterations);
}

}  // namespace
}  // namespace kalfem
