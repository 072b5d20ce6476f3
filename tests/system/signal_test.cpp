// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <unsupported/Eigen/FFT>

#include "base/processor_time.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/oversampling.hpp"
#include "kalfem/records/record.hpp"
#include "kalfem/system/signals/deterministic.hpp"
#include "kalfem/system/signals/integrated_velocity.hpp"
#include "kalfem/system/signals/random_signal.hpp"
#include "kalfem/system/signals/remembered.hpp"
#include "kalfem/system/signals/sampled.hpp"
#include "kalfem/system/signals/streamed_spline.hpp"

namespace kalfem {
namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();

/// One-sided power spectral density of a record that repeats: |X_k|^2 2 / (N^2 df).
Eigen::ArrayXd periodogram(const Eigen::VectorXd& x, double sample_rate) {
  Eigen::FFT<double> fft;
  Eigen::VectorXcd X;
  fft.fwd(X, x);
  const double n = static_cast<double>(x.size());
  return X.head(x.size() / 2).array().abs2() * 2.0 / (n * sample_rate);
}

/// Largest difference of the given derivatives from central differences of the column before, relative to their rms.
double derivative_error(const Signal& signal, double start, double end) {
  constexpr double h = 1e-5;
  double worst = 0.0;
  const int points = 200;
  const double step = (end - start) / points;
  const auto at = signal.sample(start, step, points);
  const auto before = signal.sample(start - h, step, points);
  const auto after = signal.sample(start + h, step, points);
  for (int d = 1; d <= 2; ++d) {
    const Eigen::ArrayXd difference = (after.col(d - 1) - before.col(d - 1)) / (2 * h);
    const double size = std::max(1e-300, std::sqrt(at.col(d).square().mean()));
    worst = std::max(worst, (difference - at.col(d)).abs().maxCoeff() / size);
  }
  return worst;
}

TEST(Signals, DerivativesAreThoseOfTheValue) {
  // central differences with h = 1e-5: truncation (w h)^2 / 6 = 6e-7 at 30 Hz, rounding 1e-16 / 1e-5
  EXPECT_LT(derivative_error(*make_random({.rms = 3e-3, .seed = 7}), 0.1, 4.0), 3e-6);
  EXPECT_LT(derivative_error(*make_random({.rms = 3e-3, .fade_in = 0.0}), 0.1, 4.0), 3e-6);
  EXPECT_LT(derivative_error(*make_sine({.amplitude = 2, .frequency = 7, .phase = 0.3}), -1.0, 2.0), 2e-7);
  EXPECT_LT(derivative_error(*make_sine({.frequency = 7, .fade_in = 1.0}), 0.0, 2.0), 2e-7);
  EXPECT_LT(derivative_error(*make_swept_sine({.from = 1, .to = 30, .duration = 5}), 0.1, 4.9), 4e-6);
  EXPECT_LT(
      derivative_error(*make_swept_sine({.from = 30, .to = 1, .duration = 5, .sweep = Sweep::logarithmic}), 0.1, 4.9),
      5e-6);
  EXPECT_LT(derivative_error(*make_pulse({.start = 0.2, .duration = 0.5, .shape = PulseShape::smooth}), 0.0, 1.0),
            1e-7);
  EXPECT_LT(derivative_error(*make_pulse({.start = 0.2, .duration = 0.5}), 0.21, 0.69), 1e-8);
  EXPECT_LT(derivative_error(*make_step({.before = 40, .after = 0, .start = 0.2, .duration = 0.1}), 0.201, 0.299),
            5e-7);
  EXPECT_LT(derivative_error(*make_road_profile({.road_class = 'B', .speed = 10}), 0.1, 3.0), 3e-6);
}

TEST(Signals, StartFromRestWhenFadedIn) {
  for (const auto& signal :
       {make_random({}), make_road_profile({}), make_sine({.frequency = 3, .phase = 1, .fade_in = 0.2})})
    EXPECT_EQ(signal->sample(0.0, 1.0, 1).abs().maxCoeff(), 0.0);
}

TEST(RandomSignal, HasItsRmsAndItsBandExactly) {
  const double rate = 200.0, duration = 20.0;
  const auto signal =
      make_random({.rms = 3e-3, .lower = 0.5, .upper = 30, .duration = duration, .fade_in = 0.0, .seed = 7});
  const Eigen::VectorXd x = signal->sample(0.0, 1 / rate, Eigen::Index(rate * duration)).col(0);
  // rounding of the mean of 4000 squares
  EXPECT_NEAR(rms(x) / 3e-3, 1.0, 2e-15);

  const Eigen::ArrayXd psd = periodogram(x, rate);
  const double flat = 9e-6 / ((600 - 10 + 1) / duration);  // variance over 591 lines of 0.05 Hz
  // rounding of 591 equal lines
  EXPECT_LT((psd.segment(10, 591) / flat - 1.0).abs().maxCoeff(), 5e-12);
  // rounding, squared
  EXPECT_LT(psd.head(10).maxCoeff() / flat, 1e-26);
  EXPECT_LT(psd.tail(psd.size() - 601).maxCoeff() / flat, 1e-24);
}

TEST(RandomSignal, IsGaussianLike) {
  const Eigen::ArrayXd x = make_random({.duration = 60, .fade_in = 0.0})->sample(0.0, 0.005, 12000).col(0);
  EXPECT_NEAR(x.pow(4).mean(), 3.0, 0.25);  // kurtosis; 1770 independent values scatter by sqrt(24 / 1770) = 0.12
  // skewness scatters by sqrt(15 / 1770) = .09
  EXPECT_NEAR(x.pow(3).mean(), 0.0, 0.25);
}

TEST(RandomSignal, DoesNotDependOnThePartitionOfTheCall) {
  const auto signal = make_random({.duration = 160, .fade_in = 0.5});
  const auto whole = signal->sample(0.0, 5e-4, 300000);
  const auto part = signal->sample(100.0, 1e-3, 40000);
  const auto one = signal->sample(149.9995, 5e-4, 1);
  const Eigen::Array3d size = whole.abs().colwise().maxCoeff().transpose();
  for (int d = 0; d < 3; ++d) {
    for (Eigen::Index k = 0; k < part.rows(); k += 997)
      // rounding: found 0
      EXPECT_NEAR(part(k, d), whole(200000 + 2 * k, d), 1e-14 * size(d));
    EXPECT_NEAR(one(0, d), whole(299999, d), 1e-14 * size(d));
  }
}

TEST(RandomSignal, SeedsAndNamesAreIndependentAndReproducible) {
  const auto values = [](std::uint64_t seed, const char* name) {
    return Eigen::VectorXd(make_random({.fade_in = 0, .seed = seed, .name = name})->sample(0.0, 0.01, 2000).col(0));
  };
  EXPECT_EQ(values(1, "a"), values(1, "a"));
  // correlation of independent band-limited signals of 590 lines: about 1 / sqrt(590) = 0.04
  // 0.05 is a little above one standard deviation; found .012 and .006
  EXPECT_LT(std::abs(values(1, "a").dot(values(2, "a"))) / 2000, 0.05);
  EXPECT_LT(std::abs(values(1, "a").dot(values(1, "b"))) / 2000, 0.05);
}

TEST(RandomSignal, IsFast) {
  const auto signal = make_random({.lower = 0.5, .upper = 30, .duration = 20});
  const double begin = processor_seconds();
  const auto samples = signal->sample(0.0, 1.0 / 16000, 320000);
  const double elapsed = processor_seconds() - begin;
  EXPECT_TRUE(samples.allFinite());
  RecordProperty("seconds", std::to_string(elapsed));
  EXPECT_LT(elapsed, 10.0);  // about 0.2 s; the bound only catches a change of algorithm
}

TEST(RoadProfile, HasTheSpectrumOfItsClass) {
  EXPECT_DOUBLE_EQ(road_spectrum('A', 0.1), 16e-6);
  EXPECT_DOUBLE_EQ(road_spectrum('C', 0.1), 256e-6);
  EXPECT_NEAR(road_spectrum('C', 0.2), 64e-6, 1e-19);  // rounding
  // Averaged Hann periodograms of a window that is no period of the profile: leakage and scatter are real.
  const double speed = 15.0, rate = 200.0;
  const Eigen::Index n = 2000;
  const Eigen::ArrayXd window =
      1.0 - (Eigen::ArrayXd::LinSpaced(n, 0.0, double(n - 1)) * (2 * std::numbers::pi / n)).cos();
  Eigen::ArrayXd mean = Eigen::ArrayXd::Zero(n / 2);
  const int seeds = 200;
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto road = make_road_profile(
        {.road_class = 'C', .speed = speed, .duration = 43.0, .fade_in = 0, .seed = std::uint64_t(seed)});
    const Eigen::VectorXd r = road->sample(3.0, 1 / rate, n).col(0).array() * window;
    mean += periodogram(r, rate) / (seeds * window.square().mean());
  }
  for (const double f : {2.0, 5.0, 10.0, 20.0}) {
    // five neighbouring lines of 200 seeds: scatter about 1 / sqrt(200 * 5 / 2) = 4.5 %
    const auto line = Eigen::Index(std::lround(f * n / rate));
    const double expected = road_spectrum('C', f / speed) / speed;  // Gd(f) = Gd(n) / v
    // found .078 at one of four frequencies, 1.7 of its scatter
    EXPECT_NEAR(mean.segment(line - 2, 5).mean() / expected, 1.0, 0.10) << f << " Hz";
  }
}

TEST(Wrappers, DelayShiftsScaleAndSumAdd) {
  const auto front = make_road_profile({.speed = 20});
  const double delay = 2.5 / 20;  // wheelbase / speed, 125 samples of 1 ms
  const auto rear = delayed(front, delay);
  const auto f = front->sample(0.0, 1e-3, 5000);
  const auto r = rear->sample(0.0, 1e-3, 5000);
  // rounding of the phase at another time: found 1e-13
  EXPECT_LT((r.bottomRows(4875) - f.topRows(4875)).abs().maxCoeff(), 1e-12 * f.abs().maxCoeff());
  EXPECT_EQ(r.topRows(125).abs().maxCoeff(), 0.0);  // before its fade-in the road is level
  const auto both = sum({front, scaled(rear, -2.0)})->sample(0.0, 1e-3, 5000);
  // the same sum
  EXPECT_LT((both - (f - 2.0 * r)).abs().maxCoeff(), 1e-15 * f.abs().maxCoeff());
}

TEST(SweptSine, RunsThroughItsFrequencies) {
  // turned cycles: linear mean of the ends, logarithmic T (to - from) / ln(to / from)
  const double pi = std::numbers::pi;
  const auto linear = make_swept_sine({.from = 2, .to = 9, .duration = 3})->sample(3.0, 1.0, 1);
  // rounding of a phase of 100 rad
  EXPECT_NEAR(linear(0, 0), std::sin(2 * pi * 16.5), 1e-14);
  EXPECT_NEAR(linear(0, 1), 2 * pi * 9 * std::cos(2 * pi * 16.5), 1e-12);
  const auto logarithmic =
      make_swept_sine({.from = 2, .to = 8, .duration = 3, .sweep = Sweep::logarithmic})->sample(1.5, 1.0, 1);
  const double cycles = 3.0 * (4.0 - 2.0) / std::log(4.0);
  EXPECT_NEAR(logarithmic(0, 0), std::sin(2 * pi * cycles), 1e-14);
  EXPECT_NEAR(logarithmic(0, 1), 2 * pi * 4 * std::cos(2 * pi * cycles), 1e-13);
}

TEST(Pulse, HasTheImpulseItStates) {
  for (const auto& [shape, area] :
       {std::pair{PulseShape::half_sine, 2 / std::numbers::pi}, {PulseShape::smooth, 0.375}}) {
    const auto samples =
        make_pulse({.amplitude = 5, .start = 0.1, .duration = 0.02, .shape = shape})->sample(0.0, 1e-5, 20000);
    EXPECT_NEAR(samples.col(0).sum() * 1e-5, 5 * 0.02 * area, 4e-8);  // trapezoidal error (pi h / T)^2 / 12
    EXPECT_NEAR(samples.col(0).maxCoeff(), 5.0, 1e-14);               // a sample stands at the middle
  }
}

double spline_error(double rate, int derivative) {
  const auto n = Eigen::Index(2 * rate) + 1;
  const auto exact = make_sine({.frequency = 1.0, .phase = 0.4});
  const auto spline = make_sampled(exact->sample(0.0, 1 / rate, n).col(0), {.sample_rate = rate});
  const SignalSamples error = spline->sample(0.0, 2.0 / 4001, 4001) - exact->sample(0.0, 2.0 / 4001, 4001);
  return error.col(derivative).abs().maxCoeff();
}

TEST(SampledSignal, CubicSplineConvergesAtItsOrderUpToTheEnds) {
  for (const int derivative : {0, 1, 2}) {
    const double order = std::log2(spline_error(40, derivative) / spline_error(80, derivative));
    // found .20 for the second derivative, whose error at the ends still has a part of the next order
    EXPECT_NEAR(order, 4.0 - derivative, 0.25) << "derivative " << derivative;
  }
}

TEST(SampledSignal, ReproducesAnyCubicFromFourSamplesOn) {
  for (const Eigen::Index n : {4, 5, 9}) {
    const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(n, 1.0, 1.0 + 0.5 * double(n - 1));
    const auto spline = make_sampled((t.pow(3) - 2 * t.square() + 5).matrix(), {.sample_rate = 2, .start = 1});
    const double x = 1.0 + 0.3 * double(n - 1);
    const auto s = spline->sample(x, 1.0, 1);
    // rounding of a spline's solution
    EXPECT_NEAR(s(0, 0), x * x * x - 2 * x * x + 5, 4e-14);
    EXPECT_NEAR(s(0, 1), 3 * x * x - 4 * x, 1e-14);
    EXPECT_NEAR(s(0, 2), 6 * x - 4, 1e-13);
  }
  const auto parabola = make_sampled(Eigen::Vector3d(0, 1, 4), {})->sample(1.5, 1, 1);
  // rounding
  EXPECT_NEAR(parabola(0, 0), 2.25, 1e-15);
  EXPECT_NEAR(parabola(0, 2), 2.0, 1e-15);
  EXPECT_NEAR(make_sampled(Eigen::Vector2d(0, 1), {})->sample(0.5, 1, 1)(0, 0), 0.5, 1e-15);
}

/// Largest error of a signal through samples of a sine at a part of their rate, between them and away from the ends,
/// beside its amplitude.
double error_at(double part_of_rate, const std::function<SignalPtr(const Eigen::VectorXd&)>& make) {
  constexpr int samples = 400;
  const auto sine = [&](double time) { return std::sin(2.0 * std::numbers::pi * part_of_rate * time + 0.4); };
  const auto signal = make(Eigen::VectorXd::NullaryExpr(samples, [&](Eigen::Index k) { return sine(double(k)); }));
  const auto found = signal->sample(50.0, 0.1, 3000);
  double worst = 0.0;
  for (Eigen::Index i = 0; i < found.rows(); ++i)
    worst = std::max(worst, std::abs(found(i, 0) - sine(50.0 + 0.1 * double(i))));
  return worst;
}

TEST(SampledSignal, IsBandLimitedWhereASplineWouldLoseContent) {
  const auto make = [](const Eigen::VectorXd& samples) { return make_sampled(samples, {}); };
  EXPECT_LT(error_at(0.1, make), 2e-3);
  EXPECT_LT(error_at(0.3, make), 3e-3);  // a spline through the samples alone: 0.05
  EXPECT_LT(error_at(0.4, make), 5e-3);  // 0.25
  EXPECT_LT(error_at(0.44, make), 6e-3);
}

/// The amplitude that the spline through the samples of a sine loses: 1 / (1 + sum over k of (f / (f - k))^4), Unser
/// (1999).
TEST(SampledSignal, KnowsWhatASplineWouldTake) {
  for (const double f : {0.08, 0.12, 0.2, 0.3}) {
    const Eigen::VectorXd samples =
        Eigen::VectorXd::NullaryExpr(2000, [&](Eigen::Index k) { return std::sin(2.0 * EIGEN_PI * f * double(k)); });
    double images = 0.0;
    for (int k = -50; k <= 50; ++k)
      if (k != 0) images += std::pow(f / (f - k), 4);
    EXPECT_NEAR(kalfem::spline_error(samples) / images, 1.0, 0.2) << f;
  }
  EXPECT_EQ(kalfem::spline_error(Eigen::VectorXd::Constant(100, 3.0)), 0.0);
}

/// A sum of sines up to 0.4 of the rate, known between the samples and behind the last one. As far as it says that it
/// is determined the signal is right to what the kernel lets through of such content (5e-3 of a crest, above) and a
/// thousandth of its rms; in its last interval it is wrong by several hundredths.
TEST(SampledSignal, KnowsHowFarItsSamplesDetermineIt) {
  constexpr Eigen::Index samples = 400;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> frequency(0.05, 0.4), phase(0.0, 2.0 * EIGEN_PI);
  std::vector<std::pair<double, double>> sines(40);
  for (auto& [f, p] : sines) f = frequency(random), p = phase(random);
  const auto value = [&](double t) {
    double sum = 0.0;
    for (const auto& [f, p] : sines) sum += std::sin(2.0 * EIGEN_PI * f * t + p);
    return sum / std::sqrt(0.5 * 40.0);
  };
  const auto signal = make_sampled(
      Eigen::VectorXd::NullaryExpr(samples, [&](Eigen::Index k) { return value(static_cast<double>(k)); }), {});
  const double until = signal->determined_until(), last = samples - 1.0;
  EXPECT_LE(until, last - 10.0);
  EXPECT_GE(until, last - 32.0);
  const auto wrong_by = [&](double t) { return std::abs(signal->sample(t, 1.0, 1)(0, 0) - value(t)); };
  double largest = 0.0;
  for (double t = until - 20.5; t < until; t += 0.25) largest = std::max(largest, wrong_by(t));
  EXPECT_LT(largest, 1e-2);
  EXPECT_GT(wrong_by(last - 0.5), 0.05);
  EXPECT_EQ(kalfem::delayed(signal, 3.0)->determined_until(), until + 3.0);
  EXPECT_EQ(kalfem::sum({signal, kalfem::make_constant(1.0)})->determined_until(), until);
}

TEST(SampledSignal, IsDeterminedUpToItsEndWhereItHasDiedAway) {
  Eigen::VectorXd blow = Eigen::VectorXd::Zero(200);
  blow[20] = 0.4, blow[21] = 1.0, blow[22] = 0.3;
  EXPECT_EQ(make_sampled(blow, {})->determined_until(), 199.0);
}

TEST(SampledSignal, KeepsItsSamplesWhereItIsOversampled) {
  std::mt19937 random(5);
  const Eigen::VectorXd samples =
      Eigen::VectorXd::NullaryExpr(100, [&] { return std::normal_distribution<double>()(random); });
  const auto signal = make_sampled(samples, {.sample_rate = 10.0, .start = 1.0});
  EXPECT_LT((signal->sample(1.0, 0.1, 100).col(0).matrix() - samples).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_TRUE(signal->covers(1.0, 10.9));
  EXPECT_FALSE(signal->covers(1.0, 10.91));
}

TEST(StreamedSpline, IsTheSplineOfAllSamplesUpToItsDelay) {
  constexpr double rate = 100.0;
  const Eigen::VectorXd samples =
      Eigen::VectorXd::NullaryExpr(200, [](Eigen::Index k) { return std::sin(0.5 * double(k)) + 0.01 * double(k); });
  const auto whole = make_sampled(samples, {.sample_rate = rate});
  for (const Eigen::Index delay : {1, 4, 8, 16}) {
    StreamedSpline spline(samples[0], rate);
    const double tolerance = 2.0 * std::pow(0.27, double(delay));
    Eigen::Index at = 0;
    for (Eigen::Index k = 1; k < samples.size() + delay; ++k) {
      if (k < samples.size()) spline.add(samples[k]);
      if (k == delay) {
        const SignalSamples first = spline.first(), expected = whole->sample(0.0, 1.0, 1);
        EXPECT_LT((first - expected).abs().maxCoeff(), tolerance * 0.25 * rate * rate);
      }
      if (spline.ahead() <= delay && k < samples.size()) continue;
      if (spline.ahead() == 0) break;
      const SignalSamples found = spline.move(4), expected = whole->sample(double(at) / rate, 0.25 / rate, 5);
      ++at;
      EXPECT_EQ(found(4, 0), samples[at]);
      EXPECT_LT((found.col(1) - expected.col(1)).abs().maxCoeff(), tolerance * 0.5 * rate) << at;
      EXPECT_LT((found.col(2) - expected.col(2)).abs().maxCoeff(), tolerance * 0.5 * rate * rate) << at;
    }
    EXPECT_EQ(at, samples.size() - 1);
  }
}

TEST(IntegratedVelocity, IsTheDisplacementWithoutItsDrift) {
  constexpr double rate = 200.0, w = 2.0 * std::numbers::pi * 4.0;
  const Eigen::VectorXd velocity = Eigen::VectorXd::NullaryExpr(
      2001, [&](Eigen::Index k) { return 0.3 + w * std::cos(w * double(k) / rate); });  // 0.3: a geophone's offset
  const auto motion = integrated_velocity(make_sampled(velocity, {.sample_rate = rate}), {0.0, rate, 2001});
  const auto found = motion->sample(0.0, 0.37 / rate, 5000);
  for (Eigen::Index k = 0; k < found.rows(); ++k) {
    const double phase = w * 0.37 / rate * double(k);
    ASSERT_NEAR(found(k, 0), std::sin(phase), 2e-3);
    ASSERT_NEAR(found(k, 1), w * std::cos(phase), 1e-3 * w);
    ASSERT_NEAR(found(k, 2), -w * w * std::sin(phase), 5e-3 * w * w);
  }
  EXPECT_LT(derivative_error(*motion, 1.0, 9.0), 1e-4);
}

TEST(SampledSignal, LinearIsStraightBetweenItsSamples) {
  const auto line =
      make_sampled(Eigen::Vector3d(0, 2, -1), {.sample_rate = 10, .interpolation = Interpolation::linear});
  const auto s = line->sample(0.05, 0.05, 3);  // 0.05, 0.10, 0.15
  // rounding
  EXPECT_NEAR(s(0, 0), 1.0, 1e-15);
  EXPECT_NEAR(s(0, 1), 20.0, 4e-15);
  EXPECT_NEAR(s(1, 1), -30.0, 4e-15);
  // the time .15 s is rounded to 3e-17 of a slope of 30
  EXPECT_NEAR(s(2, 0), 0.5, 7e-15);
  EXPECT_EQ(s.col(2).abs().maxCoeff(), 0.0);
}

TEST(SampledSignal, EndsWhereItsSamplesEnd) {
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(101, 0.0, 10.0);
  const auto strict = make_sampled(values, {.sample_rate = 100});
  EXPECT_TRUE(strict->covers(0.0, 1.0));
  EXPECT_FALSE(strict->covers(0.0, 1.01));
  EXPECT_FALSE(delayed(strict, 0.1)->covers(0.0, 1.0));
  EXPECT_NO_THROW((void)strict->sample(0.0, 0.001, 1001));
  EXPECT_THROW((void)strict->sample(0.0, 0.001, 1002), InvalidInput);
  EXPECT_THROW((void)strict->sample(-0.01, 0.001, 5), InvalidInput);
  const auto held = make_sampled(values, {.sample_rate = 100, .beyond = BeyondRecord::hold});
  const auto s = held->sample(-1.0, 3.0, 2);
  EXPECT_EQ(s(0, 0), 0.0);
  EXPECT_EQ(s(1, 0), 10.0);
  EXPECT_EQ(s.rightCols(2).abs().maxCoeff(), 0.0);
}

TEST(Signals, RefuseBadOptionsAllAtOnce) {
  EXPECT_EQ(validate(RandomSignalOptions{.rms = nan, .lower = 5, .upper = 1, .duration = -1}).issues().size(), 4u);
  EXPECT_THROW(make_random({.lower = 1.01, .upper = 1.02, .duration = 1}), InvalidInput);
  EXPECT_THROW(make_random({.lower = 1, .upper = 1e12, .duration = 1e12}), InvalidInput);
  EXPECT_THROW(make_sine({.frequency = nan}), InvalidInput);
  EXPECT_THROW(make_sine({.frequency = 0}), InvalidInput);
  EXPECT_THROW(make_swept_sine({.from = 0}), InvalidInput);
  EXPECT_THROW(make_pulse({.duration = 0}), InvalidInput);
  EXPECT_THROW(make_step({.duration = nan}), InvalidInput);
  EXPECT_THROW(make_constant(nan), InvalidInput);
  EXPECT_THROW(make_road_profile({.road_class = 'I'}), InvalidInput);
  EXPECT_THROW(make_road_profile({.speed = 0}), InvalidInput);
  EXPECT_THROW(make_sampled(Eigen::Vector3d(0, nan, 1), {}), InvalidInput);
  EXPECT_THROW(make_sampled(Eigen::VectorXd(1), {}), InvalidInput);
  EXPECT_THROW(delayed(make_constant(1), nan), InvalidInput);
  EXPECT_THROW(scaled(nullptr, 1), InvalidInput);
  for (const auto& signal : {make_constant(1), make_sine({}), make_random({}), make_pulse({})}) {
    EXPECT_THROW((void)signal->sample(nan, 1, 1), InvalidInput);
    EXPECT_THROW((void)signal->sample(0, 0, 1), InvalidInput);
    EXPECT_THROW((void)signal->sample(0, 1, -1), InvalidInput);
    EXPECT_EQ(signal->sample(0, 1, 0).rows(), 0);
  }
}

/// Counts what it is asked for.
class Counting final : public Signal {
public:
  SignalSamples sample(double start, double step, Eigen::Index count) const override {
    ++calls;
    return signal->sample(start, step, count);
  }
  bool covers(double, double end) const override { return end < 5.0; }

  SignalPtr signal = make_random({.rms = 1.0, .seed = 2});
  mutable int calls = 0;
};

TEST(RememberedSignal, GivesTheSameSamplesAndAsksOnce) {
  const auto counting = std::make_shared<Counting>();
  const auto kept = remembered(counting);
  const SignalSamples expected = counting->signal->sample(0.5, 1e-3, 2000);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE((kept->sample(0.5, 1e-3, 2000) == expected).all());
  EXPECT_EQ(counting->calls, 1);
  EXPECT_TRUE(kept->covers(0.0, 4.0));
  EXPECT_FALSE(kept->covers(0.0, 6.0));
}

TEST(RememberedSignal, AsksForAnotherStartStepOrNumber) {
  const auto counting = std::make_shared<Counting>();
  const auto kept = remembered(counting);
  for (const auto& [start, step, count] :
       {std::tuple{0.0, 1e-3, 2000}, {0.1, 1e-3, 2000}, {0.0, 2e-3, 2000}, {0.0, 1e-3, 2001}})
    EXPECT_TRUE((kept->sample(start, step, count) == counting->signal->sample(start, step, count)).all());
  EXPECT_EQ(counting->calls, 4);
}

TEST(RememberedSignal, ForgetsTheOldestCalls) {
  const auto counting = std::make_shared<Counting>();
  const auto kept = remembered(counting);
  for (int i = 0; i < 9; ++i) (void)kept->sample(i, 1e-3, 1000);
  (void)kept->sample(8.0, 1e-3, 1000);
  EXPECT_EQ(counting->calls, 9);
  (void)kept->sample(0.0, 1e-3, 1000);
  EXPECT_EQ(counting->calls, 10);
}

TEST(RememberedSignal, RefusesWhatTheSignalRefuses) {
  EXPECT_THROW((void)remembered(make_random({}))->sample(0.0, -1.0, 2000), InvalidInput);
  EXPECT_THROW((void)remembered(make_random({}))->sample(nan, 1.0, 2000), InvalidInput);
}

}  // namespace
}  // namespace kalfem
