// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "chain.hpp"
#include "kalfem/base/random.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double mass = 2.0, damping = 4.0, release = 5e-3, noise = 1e-3, rate = 100.0;
constexpr Index samples = 200;

/// A mass on a spring, let go from a known displacement: nothing of its record is unknown but the spring and the noise.
Structure one_mass(double dashpot = damping) {
  Structure s;
  s.add(lumped("body").mass("m", mass).spring("k", "ground", "m", 700.0, dashpot));
  return s;
}

/// x(t) = x_0 exp(-delta t) (cos w t + delta / w sin w t), without the library.
double motion(double t, double stiffness, double dashpot = damping) {
  const double delta = 0.5 * dashpot / mass, w = std::sqrt(stiffness / mass - delta * delta);
  return release * std::exp(-delta * t) * (std::cos(w * t) + delta / w * std::sin(w * t));
}

const Record& record_of_release() {
  static const Record record = [] {
    RandomStream random(5, "noise");
    const VectorXd x = VectorXd::NullaryExpr(
        samples, [&](Index k) { return motion(static_cast<double>(k) / rate, 800.0) + noise * random.normal(); });
    return make_record(rate, {{"x", x}});
  }();
  return record;
}

double log_likelihood(double stiffness, double dashpot = damping) {
  double sum = 0.0;
  for (Index k = 0; k < samples; ++k) {
    const double error =
        (record_of_release().values(0, k) - motion(static_cast<double>(k) / rate, stiffness, dashpot)) / noise;
    sum -= 0.5 * error * error + std::log(noise * std::sqrt(2.0 * std::numbers::pi));
  }
  return sum;
}

InferOptions question() {
  return {.sensors = {{"x", displacement("body.m"), noise}},
          .unknowns = {{"body.k.stiffness", {.initial = 780.0, .std = 40.0, .transform = ParameterTransform{}}}},
          .samples = 2000,
          .seed = 3,
          .initial_state = {{"body.m", {.displacement = release}}}};
}

struct Moments {
  double mean = 0.0, std = 0.0, log_evidence = 0.0;
};

/// The posterior of the stiffness by the trapezoidal rule over 4,000 points, under a prior's ln p(k).
template <class LogPrior>
Moments by_quadrature(double lower, double upper, const LogPrior& log_prior, double dashpot = damping) {
  constexpr Index points = 4000;
  const VectorXd k = VectorXd::LinSpaced(points, lower, upper);
  const VectorXd log_density =
      VectorXd::NullaryExpr(points, [&](Index i) { return log_likelihood(k[i], dashpot) + log_prior(k[i]); });
  const double largest = log_density.maxCoeff();
  VectorXd density = (log_density.array() - largest).exp();
  density[0] *= 0.5;
  density[points - 1] *= 0.5;
  const double mean = density.dot(k) / density.sum();
  return {mean, std::sqrt(density.dot((k.array() - mean).square().matrix()) / density.sum()),
          largest + std::log(density.sum() * (k[1] - k[0]))};
}

double log_normal_density(double x, double mean, double deviation) {
  return -0.5 * std::pow((x - mean) / deviation, 2) - std::log(deviation * std::sqrt(2.0 * std::numbers::pi));
}

Moments exact(double dashpot = damping) {
  return by_quadrature(
      700.0, 900.0, [](double k) { return log_normal_density(k, 780.0, 40.0); }, dashpot);
}

struct Accuracy {
  PosteriorMethod method;
  double moments, evidence;  ///< in posterior deviations, in ln Z
};

class InferOneMass : public testing::TestWithParam<Accuracy> {};

// Sampling errors of 2,000 samples are 0.02 deviations of the mean and 0.016 of the deviation, a few times as large for
// chains and for tempering, which moves its samples by chains. The posterior is nearly, not exactly, normal.
TEST_P(InferOneMass, AgreesWithQuadrature) {
  const auto [method, moments, evidence] = GetParam();
  InferOptions options = question();
  options.method = method;
  if (method == PosteriorMethod::metropolis) options.samples = 6000;  // draws of a chain are correlated
  const auto found = infer(one_mass(), record_of_release(), options);
  const auto expected = exact();
  const auto& k = found.parameter("body.k.stiffness");
  EXPECT_NEAR(k.mean, expected.mean, moments * expected.std);
  EXPECT_NEAR(k.std / expected.std, 1.0, moments);
  EXPECT_NEAR(k.interval_95.upper - k.interval_95.lower, 2.0 * 1.96 * expected.std,
              2.0 * moments * 1.96 * expected.std);
  EXPECT_EQ(k.unit, "N/m");
  EXPECT_EQ(k.prior_std, 40.0);
  EXPECT_THAT(found.warnings, testing::IsEmpty());
  EXPECT_NEAR(found.weights.sum(), 1.0, 1e-12);
  if (evidence > 0.0) {
    ASSERT_TRUE(found.log_evidence.has_value());
    EXPECT_NEAR(*found.log_evidence, expected.log_evidence, evidence);
  } else {
    EXPECT_FALSE(found.log_evidence.has_value());
  }
}

INSTANTIATE_TEST_SUITE_P(
    Methods, InferOneMass,
    testing::Values(Accuracy{PosteriorMethod::importance, 0.08, 0.02}, Accuracy{PosteriorMethod::laplace, 0.1, 0.02},
                    Accuracy{PosteriorMethod::tempered, 0.15, 0.3}, Accuracy{PosteriorMethod::metropolis, 0.15, 0.0},
                    Accuracy{PosteriorMethod::filter, 0.15, 0.1}),
    [](const auto& each) { return "method" + std::to_string(static_cast<int>(each.param.method)); });

/// The system is linear, so the filter's likelihood is exact: rounding is all that differs.
TEST(Infer, HasTheExactLikelihoodAtEverySample) {
  const auto found = infer(one_mass(), record_of_release(), question());
  for (Index i = 0; i < found.samples.cols(); i += 100)
    EXPECT_NEAR(found.log_likelihood[i], log_likelihood(found.samples(0, i)), 1e-6);
  EXPECT_THAT(found.likelihood, HasSubstr("by the filter"));
  EXPECT_GT(found.evaluations, 2000);
}

/// A uniform prior that cuts the likelihood where it is largest.
TEST(Infer, TakesPriorsOfOtherShapes) {
  InferOptions options = question();
  options.unknowns = {{"body.k.stiffness"}};
  options.priors = {{"body.k.stiffness", UniformPrior{690.0, 795.0}}};
  const auto found = infer(one_mass(), record_of_release(), options);
  const auto expected = by_quadrature(690.0, 795.0, [](double) { return -std::log(105.0); });
  EXPECT_NEAR(found.parameters[0].mean, expected.mean, 0.08 * expected.std);
  EXPECT_NEAR(*found.log_evidence, expected.log_evidence, 0.05);
  EXPECT_LE(found.samples.maxCoeff(), 795.0);
}

/// Against a grid of the closed form over both.
TEST(Infer, CorrelatesTwoParameters) {
  InferOptions options = question();
  options.unknowns.push_back({"body.k.damping", {.initial = 4.5, .std = 1.5, .transform = ParameterTransform{}}});
  const auto found = infer(one_mass(), record_of_release(), options);
  double total = 0.0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  const double reference = log_likelihood(800.0);
  for (double k = 740.0; k < 860.0; k += 1.0)
    for (double c = 1.0; c < 8.0; c += 0.1) {
      const Eigen::Vector2d theta(k - 800.0, c);
      const double density = std::exp(log_likelihood(k, c) - reference + log_normal_density(k, 780.0, 40.0) +
                                      log_normal_density(c, 4.5, 1.5));
      total += density;
      mean += density * theta;
      second += density * theta * theta.transpose();
    }
  mean /= total;
  const Eigen::Matrix2d covariance = second / total - mean * mean.transpose();
  EXPECT_NEAR(found.parameters[0].mean, mean[0] + 800.0, 0.1 * std::sqrt(covariance(0, 0)));
  EXPECT_NEAR(found.parameters[1].mean, mean[1], 0.1 * std::sqrt(covariance(1, 1)));
  EXPECT_NEAR(found.parameters[1].std / std::sqrt(covariance(1, 1)), 1.0, 0.1);
  EXPECT_NEAR(found.correlation(0, 1), covariance(0, 1) / std::sqrt(covariance(0, 0) * covariance(1, 1)), 0.08);
  EXPECT_THAT(found.identifiability, HasSubstr("determine"));
}

/// Where the closed form has fallen by 1.92 from its largest value.
TEST(Infer, ProfilesTheLikelihood) {
  InferOptions options = question();
  options.profile = {"body.k.stiffness"};
  const auto found = infer(one_mass(), record_of_release(), options);
  ASSERT_EQ(found.profiles.size(), 1U);
  const VectorXd k = VectorXd::LinSpaced(20001, 750.0, 850.0);
  const VectorXd fall = k.unaryExpr([](double value) { return log_likelihood(value); });
  double lower = k[0], upper = k[0];
  for (Index i = 0; i < k.size(); ++i)
    if (fall[i] > fall.maxCoeff() - 1.9207) {
      if (lower == k[0]) lower = k[i];
      upper = k[i];
    }
  const double width = upper - lower;
  ASSERT_TRUE(found.profiles[0].lower && found.profiles[0].upper);
  EXPECT_NEAR(*found.profiles[0].lower, lower, 0.03 * width);  // between points 0.1 widths apart
  EXPECT_NEAR(*found.profiles[0].upper, upper, 0.03 * width);
}

TEST(Infer, PredictsTheRecord) {
  const auto found = infer(one_mass(), record_of_release(), question());
  ASSERT_EQ(found.bands.size(), 1U);
  EXPECT_EQ(found.bands[0].sensor, "x");
  EXPECT_NEAR(found.bands[0].coverage, 0.95, 0.05);
  VectorXd truth(samples);
  for (Index k = 0; k < samples; ++k) truth[k] = motion(static_cast<double>(k) / rate, 800.0);
  EXPECT_LT((found.bands[0].mean - truth).cwiseAbs().maxCoeff(), noise);
  InferOptions options = question();
  options.predictions = 0;
  EXPECT_TRUE(infer(one_mass(), record_of_release(), options).bands.empty());
}

TEST(Infer, GivesTheSameBitsForOneSeedOnAnyNumberOfThreads) {
  InferOptions options = question();
  options.samples = 200;
  options.threads = 1;
  const auto one = infer(one_mass(), record_of_release(), options);
  options.threads = 3;
  EXPECT_EQ(infer(one_mass(), record_of_release(), options).samples, one.samples);
  options.seed = 4;
  EXPECT_NE(infer(one_mass(), record_of_release(), options).samples, one.samples);
}

TEST(Infer, IntegratesOutWhatIsNotAskedFor) {
  InferOptions options = question();
  options.unknowns.push_back({"body.k.damping", {.initial = 4.5, .std = 1.5, .transform = ParameterTransform{}}});
  options.parameters = {"body.k.stiffness"};
  const auto found = infer(one_mass(), record_of_release(), options);
  ASSERT_EQ(found.parameters.size(), 1U);
  EXPECT_NEAR(found.parameters[0].mean, exact().mean, 0.5 * exact().std);
  EXPECT_TRUE(found.bands.empty());  // a simulation needs the damping too
}

/// Three dampings that are stated: their probabilities by quadrature over the stiffness that is not known.
/// Of the stiffness, with the mass integrated out: by quadrature over both, without the library. The mass has a
/// log-normal prior about 2 kg, the stiffness a normal one.
Moments with_uncertain_mass(double of_mass, double initial, double std) {
  double weights = 0.0, first = 0.0, second = 0.0, reference = 0.0;
  for (int i = -60; i <= 60; ++i)
    for (int j = -60; j <= 60; ++j) {
      const double u = 4.0 * of_mass * i / 60.0, m = mass * std::exp(u), k = m * 400.0 * (1.0 + 0.03 * j / 60.0);
      const double delta = 0.5 * damping / m, w = std::sqrt(k / m - delta * delta);
      double log = -0.5 * std::pow(u / of_mass, 2) - 0.5 * std::pow((k - initial) / std, 2) + u;  // dk = m d(k/m)
      for (Index n = 0; n < samples; ++n) {
        const double t = static_cast<double>(n) / rate;
        const double x = release * std::exp(-delta * t) * (std::cos(w * t) + delta / w * std::sin(w * t));
        log -= 0.5 * std::pow((record_of_release().values(0, n) - x) / noise, 2);
      }
      if (weights == 0.0) reference = log;
      const double weight = std::exp(log - reference - 100.0);
      weights += weight;
      first += weight * k;
      second += weight * k * k;
    }
  const double mean = first / weights;
  return {mean, std::sqrt(second / weights - mean * mean)};
}

/// k / m is what the record tells, and the decay something of m.
TEST(Infer, IntegratesOutStatedNumbers) {
  InferOptions options = question();
  options.unknowns[0].prior = {.initial = 780.0, .std = 200.0, .transform = ParameterTransform{}};
  const auto expected = with_uncertain_mass(0.05, 780.0, 200.0);
  const double exact = infer(one_mass(), record_of_release(), options).parameters[0].std;
  options.known_to = {{.name = "body.m.mass", .deviation = 0.05}};
  const auto found = infer(one_mass(), record_of_release(), options);
  ASSERT_EQ(found.parameters.size(), 1U);
  EXPECT_EQ(found.samples.rows(), 1);
  EXPECT_LT(exact, 0.01 * 800.0);
  EXPECT_NEAR(found.parameters[0].std, expected.std, 0.1 * expected.std);  // 2000 samples leave 2 %
  EXPECT_NEAR(found.parameters[0].mean, expected.mean, 0.15 * expected.std);
}

/// A gain of the sensor is no state: it is sampled along, and not among the parameters. The release is known exactly,
/// so that the amplitude tells the gain, and the stiffness owes it nothing.
TEST(Infer, IntegratesOutStatedGains) {
  InferOptions options = question();
  const auto exact = infer(one_mass(), record_of_release(), options).parameters[0];
  options.known_to = {{.name = "x.gain", .deviation = 0.02}};
  const auto found = infer(one_mass(), record_of_release(), options);
  ASSERT_EQ(found.parameters.size(), 1U);
  EXPECT_EQ(found.samples.rows(), 1);
  EXPECT_NEAR(found.parameters[0].mean, exact.mean, exact.std);
  EXPECT_NEAR(found.parameters[0].std, exact.std, 0.2 * exact.std);
}

TEST(Infer, RefusesStatedNumbersThatItCannotIntegrateOut) {
  InferOptions options = question();
  options.known_to = {{.name = "body.q.mass", .deviation = 0.05}, {.name = "body.k.stiffness", .deviation = 0.05}};
  const auto message = refusal_of([&] { infer(one_mass(), record_of_release(), options); });
  EXPECT_THAT(message, HasSubstr("known_to.body.q.mass: no fixed number has this name"));
  EXPECT_THAT(message, HasSubstr("known_to.body.k.stiffness: it is estimated"));
  options.known_to = {{.name = "gains", .deviation = 0.02}};
  options.method = PosteriorMethod::filter;
  EXPECT_THAT(refusal_of([&] { infer(one_mass(), record_of_release(), options); }),
              HasSubstr("known_to: it states how well 'sensors.x.gain' is known"));
}

TEST(CompareStructures, HasTheProbabilitiesOfQuadrature) {
  const std::vector<double> dashpots{3.4, 4.0, 4.8};
  std::vector<CandidateStructure> candidates;
  VectorXd evidence(3);
  for (std::size_t i = 0; i < 3; ++i) {
    candidates.push_back({"c = " + std::to_string(i), one_mass(dashpots[i])});
    evidence[static_cast<Index>(i)] = exact(dashpots[i]).log_evidence;
  }
  const auto found = compare(candidates, record_of_release(), question());
  ASSERT_EQ(found.size(), 3U);
  const VectorXd weight = (evidence.array() - evidence.maxCoeff()).exp();
  double sum = 0.0, before = 1.0;
  for (const auto& each : found) {
    const Index i = each.name.back() - '0';
    EXPECT_EQ(each.failure, "");
    EXPECT_NEAR(each.log_evidence, evidence[i], 0.03);
    EXPECT_NEAR(each.probability, weight[i] / weight.sum(), 0.02);
    EXPECT_NEAR(each.occam, each.log_evidence - each.log_likelihood, 1e-12);
    EXPECT_LE(each.probability, before);
    ASSERT_EQ(each.parameters.size(), 1U);
    EXPECT_NEAR(each.parameters[0].mean, exact(dashpots[static_cast<std::size_t>(i)]).mean, 0.1 * exact().std);
    EXPECT_EQ(each.parameters[0].prior_mean, 780.0);
    sum += before = each.probability;
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
  EXPECT_EQ(found[0].words, "");
  EXPECT_NE(found[2].words, "");
}

/// A law with a parameter of its own that the record does not need costs it: k is common, the cubic term is not.
TEST(CompareStructures, ChargesForParametersThatTheRecordDoesNotNeed) {
  Structure cubic = one_mass();
  cubic.connect("stop", "ground", "body.m", law("cubic", {{"k", 0.0}, {"k3", 0.0}, {"c", 0.0}}));
  InferOptions options = question();
  options.samples = 300;
  const auto found = compare({{"linear", one_mass()}, {"cubic", cubic, {{"stop.k3", {.initial = 0.0, .std = 1e8}}}}},
                             record_of_release(), options);
  EXPECT_EQ(found[0].name, "linear");
  EXPECT_GT(found[0].probability, 0.5);
  EXPECT_EQ(found[1].parameters.size(), 2U);
  EXPECT_LT(found[1].occam, found[0].occam);
}

TEST(CompareStructures, RefusesWrongArgumentsByTheirPlace) {
  InferOptions options = question();
  options.method = PosteriorMethod::metropolis;
  options.likelihood = LikelihoodKind::simulation;
  const std::vector<CandidateStructure> candidates{{"one", one_mass()},
                                                   {"one", one_mass(), {{"mount.k", {.initial = 1.0}}}}};
  const auto message = refusal_of([&] { return compare(candidates, record_of_release(), options); });
  for (const auto& part : {"candidates[1] 'one': candidates[0] has that name too",
                           "likelihood: structures are compared", "method: metropolis gives no evidence",
                           "candidates[1] 'one': unknowns[1] 'mount.k': there is no parameter 'mount.k'"})
    EXPECT_THAT(message, HasSubstr(part));
  EXPECT_THAT(refusal_of([] { return compare({}, record_of_release(), question()); }),
              HasSubstr("candidates: 0 given"));
}

TEST(Infer, RefusesWrongArgumentsByTheirPlace) {
  InferOptions options = question();
  options.unknowns.push_back({"body.k.stifness"});
  options.sensors.push_back({"v", velocity("body.n"), 1.0});
  options.samples = 3;
  options.predictions = -1;
  options.correlation_time = -1.0;
  options.profile = {"body.k.stiffnes"};
  options.parameters = {"body.q"};
  options.priors = {{"body.k.stiffness", UniformPrior{2.0, 1.0}}, {"body.m.mass", NormalPrior{}}};
  const auto message = refusal_of([&] { return infer(one_mass(), record_of_release(), options); });
  for (const auto& part :
       {"unknowns[1] 'body.k.stifness': there is no parameter 'body.k.stifness' (did you mean 'body.k.stiffness'?)",
        "sensors[1] 'v': the record has no channel of that name", "samples: 3", "predictions: -1",
        "correlation_time: it is -1 s", "profile[0]: there is no unknown 'body.k.stiffnes'",
        "parameters[0]: there is no unknown 'body.q'",
        "priors[0] 'body.k.stiffness': ", "priors[1] 'body.m.mass': there is no unknown of that name"})
    EXPECT_THAT(message, HasSubstr(part));
}

TEST(Infer, RefusesWhatCannotBe) {
  const auto refusal = [](const auto& change) {
    InferOptions options = question();
    change(options);
    return refusal_of([&] { return infer(one_mass(), record_of_release(), options); });
  };
  EXPECT_THAT(refusal([](auto& options) { options.likelihood = LikelihoodKind::comparisons; }),
              HasSubstr("likelihood: comparisons, with a record"));
  EXPECT_THAT(refusal([](auto& options) { options.unknowns.clear(); }), HasSubstr("unknowns: the list is empty"));
  EXPECT_THAT(refusal([](auto& options) { options.unknowns[0].prior.random_walk = 1.0; }),
              HasSubstr("unknowns: none is constant"));
  EXPECT_THAT(refusal([](auto& options) {
                options.priors = {{"body.k.stiffness", UniformPrior{900.0, 1000.0}}};
              }),
              HasSubstr("excludes the initial value 780"));
  EXPECT_THAT(refusal([](auto& options) {
                options.method = PosteriorMethod::filter;
                options.priors = {{"body.k.stiffness", UniformPrior{700.0, 1000.0}}};
              }),
              HasSubstr("method: filter starts from the priors of `unknowns`"));
  EXPECT_THAT(
      refusal_of([] { return infer(one_mass(), record_of_release(), question()).parameter("body.k.stifness"); }),
      HasSubstr("did you mean"));
  EXPECT_THAT(refusal_of([] {
                return infer(chain_structure().base_displacement("road", "wheel.ground"), chain_record(),
                             {.sensors = chain_sensors(), .unknowns = {{"suspension.mu_k1"}}});
              }),
              HasSubstr("road"));
}

}  // namespace
}  // namespace kalfem
