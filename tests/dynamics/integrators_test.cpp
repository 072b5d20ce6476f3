// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "dynamics/closed_forms.hpp"
#include "kalfem/system/signals/deterministic.hpp"

namespace kalfem {
namespace {

struct Case {
  std::string name;
  Integrator integrator;
};

class EveryIntegrator : public testing::TestWithParam<Case> {};
class AlphaFamily : public EveryIntegrator {};

double displacement_at_end(const CoupledModel& model, const std::vector<SignalPtr>& signals, const InitialState& start,
                           Integrator integrator, double T, int steps) {
  const auto result =
      simulate(model.system(), signals, start,
               {.integrator = integrator, .step = T / steps, .duration = T, .keep_every = steps, .hht_alpha = -0.1});
  EXPECT_FALSE(result.failure);
  return result.trajectory.displacement(0, 1);
}

/// Slope of log error over log step, by least squares.
double order_of(const std::vector<double>& steps, const std::vector<double>& errors) {
  Eigen::MatrixXd A(Eigen::Index(steps.size()), 2);
  Eigen::VectorXd b(A.rows());
  for (Eigen::Index i = 0; i < b.size(); ++i) {
    A.row(i) << std::log(steps[std::size_t(i)]), 1.0;
    b[i] = std::log(errors[std::size_t(i)]);
  }
  return A.colPivHouseholderQr().solve(b)[0];
}

TEST_P(AlphaFamily, LinearOscillatorConvergesWithOrderTwo) {
  const DampedOscillator body{1.0, 0.8, 400.0};
  const double T = 2.37;  // 7.54 periods: whole periods hide errors of period
  const double truth = body.free(1e-3, 0.02, T)[0];
  const auto model = oscillator(body.m, body.c, body.k);
  std::vector<double> steps, errors;
  for (const int count : {400, 800, 1600, 3200}) {
    steps.push_back(T / count);
    errors.push_back(std::abs(
        displacement_at_end(model, {make_constant(0.0)}, start_at(1e-3, 0.02), GetParam().integrator, T, count) -
        truth));
  }
  EXPECT_NEAR(order_of(steps, errors), 2.0, 0.05);  // the next term of the expansion is a few per cent here
}

/// The schemes with numerical damping hold an acceleration of an earlier time, which is not what they give out.
TEST_P(AlphaFamily, AccelerationConvergesWithOrderTwo) {
  const DampedOscillator body{1.0, 0.8, 400.0};
  const double T = 2.37;
  const Eigen::Vector2d end = body.free(1e-3, 0.02, T);
  const double truth = -(body.c * end[1] + body.k * end[0]) / body.m;
  const auto model = oscillator(body.m, body.c, body.k);
  std::vector<double> steps, errors;
  for (const int count : {400, 800, 1600, 3200}) {
    steps.push_back(T / count);
    const auto result = simulate(model.system(), {make_constant(0.0)}, start_at(1e-3, 0.02),
                                 {.integrator = GetParam().integrator, .step = T / count, .duration = T});
    errors.push_back(std::abs(result.trajectory.acceleration(0, count) - truth));
  }
  // found .035: the acceleration's next term
  EXPECT_NEAR(order_of(steps, errors), 2.0, 0.1);
}

TEST_P(EveryIntegrator, SaturatingConnectorConvergesWithOrderTwo) {
  const DampedOscillator body{1.0, 0.5, 300.0};
  const auto parameters = saturating_parameters();
  const auto law = [p = parameters.data()](double d, double v) {
    return p[0] * d + p[1] * d / (p[2] + std::abs(d)) + p[3] * v + p[4] * v / (p[5] + std::abs(v));
  };
  const SineOptions sine{.amplitude = 60.0, .frequency = 4.3, .phase = 0.4};
  const auto applied = [&](double t) { return sine.amplitude * std::sin(2 * M_PI * sine.frequency * t + sine.phase); };
  const double T = 0.83;
  // 2 10^6 steps: the kinks of the law at 0 reduce Runge-Kutta to order 2-3, some 1e-12 of the amplitude
  static const double reference = runge_kutta(body, applied, law, 0.0, 0.0, T, 2000000)[0];
  const auto model =
      oscillator(body.m, body.c, body.k, {{"strut", "body.ground", "body.x", make_law("saturating"), parameters}});
  std::vector<double> steps, errors;
  for (const int count : {500, 1000, 2000, 4000, 8000}) {
    steps.push_back(T / count);
    errors.push_back(std::abs(
        displacement_at_end(model, {make_sine(sine)}, at_rest(1, 0), GetParam().integrator, T, count) - reference));
  }
  // The law's kinks add errors of the same order whose size varies with where in the step they fall.
  EXPECT_NEAR(order_of(steps, errors), 2.0, 0.04);
  EXPECT_LT(errors.back(), 4e-5 * std::abs(reference));  // found 2e-5 for the coarsest scheme: second order in h
}

const Case newmark{"newmark", Integrator::newmark}, hht{"hht", Integrator::hht_alpha},
    generalized{"generalized_alpha", Integrator::generalized_alpha}, exact{"exact", Integrator::exact};
const auto name_of = [](const auto& suite) { return suite.param.name; };

INSTANTIATE_TEST_SUITE_P(All, AlphaFamily, testing::Values(newmark, hht, generalized), name_of);
INSTANTIATE_TEST_SUITE_P(All, EveryIntegrator, testing::Values(newmark, hht, generalized, exact), name_of);

SimulationResult undamped(Integrator integrator, double omega, double h, int steps, double radius = 0.8) {
  const auto model = oscillator(1.0, 0.0, omega * omega);
  return simulate(
      model.system(), {make_constant(0.0)}, start_at(1.0, 0.0),
      {.integrator = integrator, .step = h, .duration = steps * h, .hht_alpha = -0.3, .spectral_radius = radius});
}

TEST(Newmark, AverageAccelerationElongatesThePeriodByItsLeadingTerm) {
  const double omega = 10.0;
  for (const double product : {0.05, 0.1, 0.2}) {  // omega h
    const double h = product / omega;
    const auto d = undamped(Integrator::newmark, omega, h, 40).trajectory.displacement;
    // Undamped: d_{k+1} + d_{k-1} = 2 cos(omega_h h) d_k.
    const double seen = std::acos((d(0, 21) + d(0, 19)) / (2 * d(0, 20))) / h;
    const double elongation = omega / seen - 1.0;
    // the next term of the series in omega h, found 0.07 (omega h)^2 at most
    EXPECT_NEAR(elongation / (product * product / 12.0), 1.0, 0.1 * product * product) << product;
    EXPECT_NEAR(std::tan(seen * h / 2), product / 2, 6e-14);  // the closed form of the trapezoidal rule
  }
}

TEST(Newmark, AverageAccelerationKeepsTheEnergy) {
  const double omega = 40.0;
  const auto motion = undamped(Integrator::newmark, omega, 0.013, 5000).trajectory;
  const Eigen::ArrayXd energy =
      motion.velocity.row(0).array().square() / (omega * omega) + motion.displacement.row(0).array().square();
  // found 3e-14: 5000 roundings
  EXPECT_LT((energy - 1.0).abs().maxCoeff(), 3e-13);
}

TEST(GeneralizedAlpha, HighFrequenciesDecayByTheSpectralRadius) {
  const auto decay = [](Integrator integrator, double radius) {
    const auto motion = undamped(integrator, 1e5, 1.0, 240, radius).trajectory;
    const auto size = [&](Eigen::Index k) { return motion.displacement.middleCols(k, 20).norm(); };
    return std::pow(size(200) / size(100), 0.01);
  };
  // Multiple roots at infinity bring a factor k^2 at most: (200/100)^(2/100) is 1.4 %.
  EXPECT_NEAR(decay(Integrator::generalized_alpha, 0.8), 0.8, 0.8 * 0.015);
  EXPECT_NEAR(decay(Integrator::generalized_alpha, 0.5), 0.5, 0.5 * 0.015);
  EXPECT_NEAR(decay(Integrator::hht_alpha, 0.0), 0.7 / 1.3, 0.7 / 1.3 * 0.015);  // (1 + alpha) / (1 - alpha)
}

TEST(HhtAlpha, LowFrequenciesAreHardlyDamped) {
  const auto motion = undamped(Integrator::hht_alpha, 1.0, 0.02, 315).trajectory;  // one period
  EXPECT_GT(motion.displacement.row(0).tail(20).maxCoeff(), 0.999);
}

TEST(InternalStates, ExactAndNewmarkAgreeOnBoucWenHysteresis) {
  const ConnectorDescription hysteresis{"h", "body.ground", "body.x", make_law("bouc_wen"),
                                        values({2e4, 0.1, 1.0, 800.0, 200.0, 1.0, 5.0})};
  const auto model = oscillator(2.0, 3.0, 1e3, {hysteresis});
  const auto force = make_sine({.amplitude = 40.0, .frequency = 6.0, .fade_in = 0.1});
  const auto run = [&](Integrator integrator, double h, Eigen::Index keep) {
    const auto result = simulate(model.system(), {force}, at_rest(1, 1),
                                 {.integrator = integrator, .step = h, .duration = 1.0, .keep_every = keep});
    EXPECT_FALSE(result.failure);
    return result.trajectory;
  };
  const auto fine = run(Integrator::exact, 1e-4, 10), other = run(Integrator::newmark, 1e-4, 10);
  const auto coarse = run(Integrator::exact, 1e-3, 1);
  const double d = fine.displacement.norm(), z = fine.connector_states.norm();
  // Second order, omega h = 0.02 at the elastic frequency: found 4e-6 and 8e-6, 2e-4 at the coarse step.
  EXPECT_LT((fine.displacement - other.displacement).norm(), 1e-5 * d);
  EXPECT_LT((fine.connector_states - other.connector_states).norm(), 2e-5 * z);
  EXPECT_LT((fine.displacement - coarse.displacement).norm(), 4e-4 * d);
  EXPECT_GT(fine.connector_states.cwiseAbs().maxCoeff(), 3e-4);  // it does yield: 1/(beta+gamma) is 1e-3
}

TEST(EnergyBalance, WorkOfTheRoadIsStoredOrDissipated) {
  const auto model =
      quarter_chain(10, {{"strut", "wheel.w", "body.1", make_law("saturating"), saturating_parameters()}},
                    {{"road", InputKind::base_displacement, "wheel.ground"}});
  const auto& system = model.system();
  const double h = 2e-5;
  const auto road = make_sine({.amplitude = 4e-3, .frequency = 9.0, .fade_in = 0.1});
  for (const auto integrator : {Integrator::newmark, Integrator::exact}) {
    const auto motion =
        simulate(system, {road}, at_rest(11, 0), {.integrator = integrator, .step = h, .duration = 0.7}).trajectory;
    const Eigen::RowVectorXd drive = system.inputs[0].value.transpose() * motion.velocity;
    const Eigen::RowVectorXd cross_damping = system.inputs[0].rate.transpose() * motion.velocity;
    const Eigen::RowVectorXd strut = system.connectors[0].deformation.transpose() * motion.velocity;
    const Eigen::RowVectorXd internal =
        (motion.velocity.array() * (system.damping * motion.velocity).array()).colwise().sum();
    const Eigen::RowVectorXd power =
        (drive.array() * motion.inputs.row(0).array() + cross_damping.array() * motion.inputs.row(1).array() -
         strut.array() * motion.force.row(0).array())
            .matrix() -
        internal;
    const double work = h * (power.sum() - 0.5 * (power[0] + power[power.size() - 1]));
    const double dissipated = h * (internal.sum() + (strut.array() * motion.force.row(0).array()).sum());
    const Eigen::VectorXd z = motion.displacement.rightCols(1), v = motion.velocity.rightCols(1);
    const double stored = 0.5 * v.dot(system.mass * v) + 0.5 * z.dot(system.stiffness * z);
    // Trapezoidal rule and integrator are of second order in omega h of up to 0.03: found 2e-7 of the work.
    EXPECT_NEAR(work, stored, 4e-7 * dissipated);
    EXPECT_GT(dissipated, 0.5 * stored);  // both sides of the balance count
  }
}

}  // namespace
}  // namespace kalfem
