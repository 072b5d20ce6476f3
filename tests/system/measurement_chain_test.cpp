// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/sensors/measurement_chain.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/system/signals/random_signal.hpp"

namespace kalfem {
namespace {

constexpr double pi = std::numbers::pi;

MeasurementChain chain_of(ChainSection section) { return MeasurementChain({.sections = {section}}); }
double decibel(const MeasurementChain& chain, double f) {
  return 20 * std::log10(std::abs(chain.frequency_response(f)));
}

TEST(Butterworth, MagnitudeIsItsClosedForm) {
  for (int order = 1; order <= 12; ++order) {
    const auto low = chain_of(FilterSection{.order = order, .cutoff = 100});
    const auto high = chain_of(FilterSection{.band = FilterBand::high_pass, .order = order, .cutoff = 100});
    EXPECT_EQ(low.states(), order);
    for (const double f : {1.0, 30.0, 100.0, 250.0, 5000.0}) {
      // rounding of powers up to 24
      EXPECT_NEAR(std::norm(low.frequency_response(f)) * (1 + std::pow(f / 100, 2 * order)), 1.0, 5e-14);
      EXPECT_NEAR(std::norm(high.frequency_response(f)) * (1 + std::pow(100 / f, 2 * order)), 1.0, 5e-14);
    }
    EXPECT_NEAR(decibel(low, 100), -3.0103, 1e-7);                           // five digits of 10 lg 2: 4e-8
    EXPECT_NEAR(decibel(low, 1e5) - decibel(low, 1e6), 20.0 * order, 1e-5);  // order 1 lacks (100 / 1e5)^2: 4e-6 dB
  }
}

TEST(Butterworth, PolesOfTheRealisationLieOnTheCircle) {
  const auto chain = chain_of(FilterSection{.order = 8, .cutoff = 2000});
  const Eigen::VectorXcd poles = chain.realise().A.eigenvalues();
  for (const auto& pole : poles) {
    // rounding of an 8 x 8 eigenvalue problem, by other libraries more
    EXPECT_NEAR(std::abs(pole) / (2 * pi * 2000), 1.0, 2e-13);
    EXPECT_LT(pole.real(), 0.0);
  }
}

TEST(BandPass, EdgesAreThreeDecibelDownAndTheCentreIsUnity) {
  for (const auto family : {FilterFamily::butterworth, FilterFamily::bessel})
    for (const int order : {1, 2, 3, 5, 12}) {
      const auto chain = chain_of(FilterSection{
          .family = family, .band = FilterBand::band_pass, .order = order, .cutoff = 0.5, .upper_cutoff = 400});
      EXPECT_EQ(chain.states(), 2 * order);
      EXPECT_NEAR(decibel(chain, 0.5), -3.0103, 1e-7);  // five digits of 10 lg 2
      EXPECT_NEAR(decibel(chain, 400), -3.0103, 1e-7);
      EXPECT_NEAR(decibel(chain, std::sqrt(200.0)), 0.0, 5e-13);  // rounding in dB: 9e-16 times the order
    }
}

TEST(Bessel, PolesAndBandwidthAreThePublishedOnes) {
  // Roots of theta_3 and theta_4, and the half-power frequencies of unit-delay filters: Zverev, Handbook of Filter
  // Synthesis (1967), tables of Bessel filters.
  const auto cubic = bessel_polynomial_roots(3);
  ASSERT_EQ(cubic.size(), 2u);
  for (const auto& pole : cubic) {
    if (pole.imag() == 0)
      // the table prints ten decimals
      EXPECT_NEAR(pole.real(), -2.3221853546, 1e-10);
    else
      EXPECT_LT(std::abs(pole - std::complex(-1.8389073227, 1.7543809598)), 1e-10);
  }
  const double half_power[] = {1.0, 1.3616541, 1.7556724, 2.1139177, 2.4274107, 2.7033950};
  for (int order = 1; order <= 6; ++order)
    EXPECT_NEAR(std::abs(bessel_polynomial_roots(order)[0]) / std::abs(bessel_poles(order)[0]), half_power[order - 1],
                // the table prints seven decimals
                2e-7);
}

TEST(Bessel, RootsSatisfyTheirPolynomialAtEveryOrder) {
  for (int order = 1; order <= 12; ++order) {
    // sum of the roots -n(n+1)/2 and product (2n)! / (n! 2^n) = 1 3 5 ... (2n - 1)
    std::complex<double> sum = 0, product = 1;
    for (const auto& root : bessel_polynomial_roots(order)) {
      sum += root.imag() == 0 ? root.real() : 2 * root.real();
      product *= root.imag() == 0 ? -root.real() : std::norm(root);
    }
    double odd = 1;
    for (int k = 1; k <= order; ++k) odd *= 2 * k - 1;
    // rounding of the roots: their polynomial's coefficients reach 3e11
    EXPECT_NEAR(sum.real() / (-0.5 * order * (order + 1)), 1.0, 1e-11) << order;
    EXPECT_NEAR(product.real() / odd, 1.0, 5e-11) << order;
  }
}

TEST(Bessel, GroupDelayIsMaximallyFlat) {
  const double fc = 100.0;
  for (const int order : {4, 8}) {
    const auto chain = chain_of(FilterSection{.family = FilterFamily::bessel, .order = order, .cutoff = fc});
    EXPECT_NEAR(decibel(chain, fc), -3.0103, 1e-7);  // five digits of 10 lg 2
    const auto delay = [&](double f) {
      const double h = 1e-3;
      return -std::arg(chain.frequency_response(f + h) / chain.frequency_response(f - h)) / (4 * pi * h);
    };
    const double half_power = std::abs(bessel_polynomial_roots(order)[0]) / std::abs(bessel_poles(order)[0]);
    const double unit = half_power / (2 * pi * fc);
    EXPECT_NEAR(delay(0.01) / unit, 1.0, 1e-10);  // a difference of phases, (f / fc)^2n below rounding
    // the delay falls with (f / fc)^2n: found 1.2e-4 for order 4
    EXPECT_NEAR(delay(0.5 * fc) / unit, 1.0, order == 4 ? 3e-4 : 2e-7);
  }
}

double delay_error_degrees(int order, double f_delay) {
  const auto chain = chain_of(DelaySection{.delay = 1e-3, .order = order});
  const auto ratio = chain.frequency_response(f_delay / 1e-3) * std::polar(1.0, 2 * pi * f_delay);
  // an all-pass: rounding
  EXPECT_NEAR(std::abs(ratio), 1.0, 5e-15);
  return std::abs(std::arg(ratio)) * 180 / pi;
}

TEST(Delay, PhaseErrorIsWhatTheTableSays) {
  // the limits of the documented table; found .10, .65, .05 and .11 degrees
  EXPECT_LT(delay_error_degrees(6, 1.0), 1.0);
  EXPECT_LT(delay_error_degrees(2, 0.25), 0.7);
  EXPECT_LT(delay_error_degrees(4, 0.5), 0.1);
  EXPECT_LT(delay_error_degrees(8, 1.5), 0.5);
  EXPECT_GT(delay_error_degrees(4, 1.0), 1.0);  // why the default is not 4
}

TEST(Delay, DelaysABandLimitedSignal) {
  const auto signal = make_random({.rms = 1, .lower = 1, .upper = 100, .duration = 4, .fade_in = 0.5});
  const double delay = 2.5e-3, rate = 20000;
  const Eigen::VectorXd x = signal->sample(0, 1 / rate, 40000).col(0);
  const Eigen::VectorXd truth = signal->sample(-delay, 1 / rate, 40000).col(0);
  const Eigen::VectorXd y = chain_of(DelaySection{.delay = delay}).filter(x, rate);
  // straight lines between samples: (w h)^2 / 12 = 8e-5 at 100 Hz; phase error at f delay = 0.25 far below
  // found 4e-5
  EXPECT_LT((y - truth).norm() / truth.norm(), 1e-4);
}

TEST(Filter, SineReachesTheFrequencyResponse) {
  const MeasurementChain chain({.sections = {FilterSection{.order = 8, .cutoff = 200},
                                             FilterSection{.band = FilterBand::high_pass, .order = 2, .cutoff = 2},
                                             ResonanceSection{.frequency = 900, .damping = 0.05},
                                             DelaySection{.delay = 1e-3}, GainSection{.gain = -3.0}}});
  EXPECT_EQ(chain.states(), 18);
  const double f = 60, rate = 50000;
  const Eigen::Index n = 150000;
  const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(n, 0, double(n - 1) / rate);
  const Eigen::ArrayXd y = chain.filter((2 * pi * f * t).sin().matrix(), rate, FilterStart::zero);
  const auto H = chain.frequency_response(f);
  const Eigen::ArrayXd steady = std::abs(H) * (2 * pi * f * t + std::arg(H)).sin();
  // transients of the 2 Hz high-pass after 2 s: exp(-9 * 2) = 2e-8; straight lines: (w h)^2 / 12 = 5e-6
  // found 5e-6
  EXPECT_LT((y - steady).tail(50000).abs().maxCoeff() / std::abs(H), 1e-5);
}

TEST(Filter, RealisationHasTheSameResponseAsTheSections) {
  const MeasurementChain chain(
      {.sections = {FilterSection{.family = FilterFamily::bessel, .order = 7, .cutoff = 300},
                    FilterSection{.band = FilterBand::band_pass, .order = 3, .cutoff = 1, .upper_cutoff = 2000},
                    DelaySection{.delay = 2e-3, .order = 4}}});
  const auto [A, B, C, D] = chain.realise();
  const Eigen::MatrixXcd identity = Eigen::MatrixXcd::Identity(A.rows(), A.cols());
  for (const double f : {0.1, 3.0, 150.0, 900.0}) {
    const std::complex<double> s(0, 2 * pi * f);
    const Eigen::VectorXcd x = (s * identity - A).partialPivLu().solve(B.cast<std::complex<double>>());
    const std::complex<double> H = (C.cast<std::complex<double>>() * x)(0) + D;
    EXPECT_LT(std::abs(H - chain.frequency_response(f)), 1e-14) << f;  // rounding
  }
}

TEST(Filter, IsExactForAStraightLine) {
  const double tau = 1 / (2 * pi * 10);
  const auto chain = chain_of(FilterSection{.order = 1, .cutoff = 10});
  const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(101, 0, 10);  // steps of six time constants
  const Eigen::ArrayXd y = chain.filter((3.0 * t).matrix(), 10.0);
  // ramp response 3 (t - tau + tau exp(-t / tau))
  EXPECT_LT((y - 3 * (t - tau + tau * (-t / tau).exp())).abs().maxCoeff(), 1e-13);  // rounding of a ramp of 30
}

TEST(Filter, StartsSteadyOrFromZero) {
  const auto chain =
      MeasurementChain({.sections = {FilterSection{.order = 12, .cutoff = 3000}, GainSection{.gain = 2}}});
  const Eigen::VectorXd constant = Eigen::VectorXd::Constant(2000, 9.81);
  // rounding of 2000 steps
  EXPECT_LT((chain.filter(constant, 20000).array() - 19.62).abs().maxCoeff(), 1e-13);
  const Eigen::VectorXd rising = chain.filter(constant, 20000, FilterStart::zero);
  EXPECT_EQ(rising(0), 0.0);
  EXPECT_NEAR(rising(1999), 19.62, 1e-12);
  const auto high = chain_of(FilterSection{.band = FilterBand::high_pass, .order = 4, .cutoff = 1});
  EXPECT_LT(high.filter(constant, 20000).cwiseAbs().maxCoeff(), 2e-11);
}

TEST(MeasurementChain, EmptyIsTheIdentity) {
  const MeasurementChain identity;
  EXPECT_TRUE(identity.is_identity());
  EXPECT_EQ(identity.states(), 0);
  EXPECT_EQ(identity.realise().D, 1.0);
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(5, 0, 1);
  EXPECT_EQ(identity.filter(x, 1.0), x);
  EXPECT_TRUE(chain_of(DelaySection{.delay = 0.0}).is_identity());
}

TEST(MeasurementChain, RefusesBadSectionsAllAtOnce) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const MeasurementChainOptions options{
      .sections = {FilterSection{.order = 13, .cutoff = nan},
                   FilterSection{.band = FilterBand::band_pass, .cutoff = 5, .upper_cutoff = 5},
                   DelaySection{.delay = -1, .order = 3}, ResonanceSection{.frequency = 0, .damping = nan},
                   GainSection{.gain = 0}}};
  EXPECT_EQ(validate(options).issues().size(), 8u);
  EXPECT_THROW(MeasurementChain{options}, InvalidInput);
  const auto chain = chain_of(FilterSection{.cutoff = 1});
  EXPECT_THROW((void)chain.filter(Eigen::Vector2d(0, nan), 10), InvalidInput);
  EXPECT_THROW((void)chain.filter(Eigen::Vector2d(0, 1), 0), InvalidInput);
}

}  // namespace
}  // namespace kalfem
