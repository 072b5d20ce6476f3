#include "kalfem/system/connector_forces.hpp"

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
      EXPECT_NEAR(forces.force()(0, 0), expected, 1e-7 * std::abs(expected) + 1e-6) << of.label << " trial " << trial;
    }
  }
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
    EXPECT_NEAR(together.force()(0, j), f, 1e-8 * std::abs(f) + 1e-9) << four[std::size_t(j)].label;
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
    EXPECT_LT((bench.force - forces.force().col(j)).abs().maxCoeff(), 1e-6 * bench.force.abs().maxCoeff())
        << four[std::size_t(j)].label;
  }
}

TEST(ConnectorForces, StatesAtTheEndBelongToTheMotionAtTheEnd) {
  const LawCase jenkins{"jenkins", make_law("jenkins"), {1e7, 5.0, 1e3, 1.0}};
  ConnectorForces forces(connectors_only({jenkins}));
  forces.free_motion().row(0) << 1e-3, 0.5, 0.0;
  const auto H = compliance(MatrixXd::Constant(1, 1, 1.0));
  ASSERT_TRUE(forces.solve(H, step).converged);
  // Sliding: q = k_stick (d - slip) = f_slip.
  EXPECT_NEAR(forces.states()(0, 0), forces.motion()(0, 0) - 5.0 / 1e7, 1e-12);
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
  // f = 1 - f + sign flip of the rate: the law's force jumps across the only crossing, so no f satisfies it.
  const auto law = function_law([](double, double v) { return FunctionLaw::Value{v > 0.0 ? -1.0 : 1.0, 0.0, 0.0}; });
  ConnectorForces forces(connectors_only({{"jump", law, {}}}));
  MatrixXd H = MatrixXd::Zero(3, 1);
  H(1, 0) = 1.0;  // f = -1 gives v < 0 and so f = 1, which gives v > 0 and so f = -1
  forces.free_motion().setZero();
  const auto outcome = forces.solve(H, step);
  EXPECT_FALSE(outcome.converged);
  EXPECT_LE(outcome.iterations, ForceSolveOptions{}.max_iterations);
}

}  // namespace
}  // namespace kalfem
