// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/importance_sampler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "evidence_cases.hpp"
#include "kalfem/base/interruption.hpp"
#include "linear_gaussian.hpp"

namespace kalfem {
namespace {

/// Two narrow modes at (1, 1) and (-1, -1) of one height, with Z of both together.
EvidenceCase two_modes(double width) {
  const auto likelihood = [=](const Eigen::VectorXd& x) {
    const auto mode = [&](double centre) { return log_normal(x[0], centre, width) + log_normal(x[1], centre, width); };
    const double one = mode(1.0), other = mode(-1.0);
    return std::max(one, other) + std::log1p(std::exp(-std::abs(one - other)));
  };
  return {"two modes",
          {JointPrior({{"a", NormalPrior{0.0, 1.0}}, {"b", NormalPrior{0.0, 1.0}}}), likelihood},
          std::log(2.0) + 2.0 * log_normal(1.0, 0.0, std::sqrt(1.0 + width * width))};
}

bool warns(const ImportanceResult& result, const std::string& part) {
  for (const auto& warning : result.warnings)
    if (warning.find(part) != std::string::npos) return true;
  return false;
}

/// Three standard errors, and these small enough to tell something.
void expect_evidence(const EvidenceCase& known, const ImportanceOptions& options = {}) {
  const ImportanceResult result = sample_importance(known.posterior, options);
  EXPECT_TRUE(result.reliable()) << known.name;
  EXPECT_TRUE(result.warnings.empty()) << known.name;
  EXPECT_NEAR(result.log_evidence, known.log_evidence, 3.0 * result.log_evidence_deviation) << known.name;
  EXPECT_LT(result.log_evidence_deviation, 0.03) << known.name;
  EXPECT_NEAR(result.samples.weights.sum(), 1.0, 1e-12);
}

TEST(ImportanceSampler, FindsTheEvidenceOfModalData) {
  expect_evidence(yuen_case());
  expect_evidence(frame_case());
}

TEST(ImportanceSampler, IsUnbiasedOnLinearGaussianProblems) {
  for (const int p : {1, 2, 5, 10}) expect_evidence(linear_gaussian_case(p));
}

TEST(ImportanceSampler, FindsThePosterior) {
  for (const auto& known : {yuen_case(), frame_case(), linear_gaussian_case(5)}) {
    const ImportanceResult result = sample_importance(known.posterior, {.samples = 4000});
    const auto summary = summarise_samples(result.samples);
    const double error = 3.5 / std::sqrt(result.effective_samples);
    for (std::size_t i = 0; i < summary.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      EXPECT_NEAR(summary[i].mean, known.mean[k], error * known.deviation[k]) << known.name;
      EXPECT_NEAR(summary[i].deviation, known.deviation[k], error * known.deviation[k]) << known.name;
    }
  }
}

TEST(ImportanceSampler, FindsPosteriorsAThousandTimesNarrowerThanThePriorUnderLargeLikelihoods) {
  expect_evidence(
      {"narrow",
       {JointPrior({{"a", UniformPrior{0.0, 1.0}}, {"b", UniformPrior{100.0, 300.0}}}),
        [](const Eigen::VectorXd& x) { return log_normal(x[0], 0.7, 1e-4) + log_normal(x[1], 180.0, 0.02) - 1e6; }},
       -std::log(200.0) - 1e6});
}

TEST(ImportanceSampler, HandlesBoundsThatCutThePosterior) {
  expect_evidence({"rises to the bound",
                   {uniform_box(1, 0.0, 1.0), [](const Eigen::VectorXd& x) { return 30.0 * x[0]; }},
                   30.0 - std::log(30.0)});
  expect_evidence({"cut",
                   {uniform_box(1, 0.0, 1.0), [](const Eigen::VectorXd& x) { return log_normal(x[0], 0.1, 0.1); }},
                   std::log(0.5 * std::erfc(-std::sqrt(0.5)))});
  // half of the prior impossible, beside the maximum: Z = Phi(0) / 2
  expect_evidence({"impossible half",
                   {JointPrior({{"a", NormalPrior{0.0, 1.0}}, {"b", NormalPrior{0.0, 1.0}}}),
                    [](const Eigen::VectorXd& x) { return x[0] < -0.001 ? std::nan("") : 0.0; }},
                   std::log(0.5 * std::erfc(-0.001 * std::sqrt(0.5)))});
}

TEST(ImportanceSampler, StaysWithThePriorWhereTheDataSayNothing) {
  const Posterior flat{uniform_box(3, 0.0, 1.0), [](const Eigen::VectorXd&) { return 2.0; }};
  expect_evidence({"no information", flat, 2.0});
  const ImportanceResult result = sample_importance(flat);
  EXPECT_LT((result.approximation.covariance - Eigen::MatrixXd::Identity(3, 3)).cwiseAbs().maxCoeff(), 0.2);
}

TEST(ImportanceSampler, TellsOfAPosteriorThatItHardlyReaches) {
  int wrong = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const ImportanceResult result = sample_importance(banana_case(3.0).posterior, {.samples = 200, .seed = seed});
    EXPECT_FALSE(result.reliable());
    EXPECT_TRUE(warns(result, "sample_tempered"));
    wrong += std::abs(result.log_evidence - banana_case(3.0).log_evidence) > 0.5 ? 1 : 0;
  }
  EXPECT_GE(wrong, 8);  // so the verdict is right
  for (const auto& known : {shells_case(2, -1.7456), shells_case(5, -5.6736), eggbox_case()})
    EXPECT_FALSE(sample_importance(known.posterior).reliable()) << known.name;
}

TEST(ImportanceSampler, NeedsBothALightTailAndEnoughSamplesToBeReliable) {
  ImportanceResult result;
  result.samples.values = Eigen::MatrixXd::Zero(1, 1000);
  result.k_hat = 0.66;  // the limit for 1000 samples is 0.667
  result.effective_samples = 100.0;
  EXPECT_TRUE(result.reliable());
  result.k_hat = 0.67;
  EXPECT_FALSE(result.reliable());
  result.k_hat = 0.66;
  result.effective_samples = 99.0;
  EXPECT_FALSE(result.reliable());
}

TEST(ImportanceSampler, IsAsWideAsThePriorWhereTheSearchEndsOnASaddle) {
  // the search starts and ends halfway between the modes, where the likelihood is curved upwards
  const EvidenceCase known = two_modes(0.4);
  const ImportanceResult result = sample_importance(known.posterior, {.prior_share = 0.0, .efficiency = 0.0});
  EXPECT_TRUE(result.reliable());
  EXPECT_NEAR(result.log_evidence, known.log_evidence, 3.0 * result.log_evidence_deviation);
  EXPECT_LT(result.log_evidence_deviation, 0.08);
}

TEST(ImportanceSampler, ShareOfThePriorShowsAModeThatTheSearchMissed) {
  const EvidenceCase known = two_modes(0.2);
  const Eigen::VectorXd start = Eigen::Vector2d(0.9, 0.9);
  EXPECT_FALSE(sample_importance(known.posterior, {.start = start}).reliable());
}

TEST(ImportanceSampler, CannotSeeAModeThatNoSampleHits) {
  const EvidenceCase known = two_modes(0.005);
  const Eigen::VectorXd start = Eigen::Vector2d(0.9, 0.9);
  const ImportanceResult blind = sample_importance(known.posterior, {.prior_share = 0.0, .start = start});
  EXPECT_TRUE(blind.reliable());  // wrongly
  EXPECT_NEAR(blind.log_evidence, known.log_evidence - std::log(2.0), 0.1);
}

TEST(ImportanceSampler, CoversTheModesThatTheSearchFinds) {
  expect_evidence(two_modes(0.005), {.random_starts = 10});
  expect_evidence(blobs_case(), {.random_starts = 10});
}

TEST(ImportanceSampler, DoesNotDependOnThreads) {
  for (const auto& posterior : {yuen_case().posterior, banana_case(1.0).posterior}) {
    const auto one = sample_importance(posterior, {.samples = 400}),
               two = sample_importance(posterior, {.samples = 400, .threads = 2});
    EXPECT_EQ(one.samples.values, two.samples.values);
    EXPECT_EQ(one.samples.weights, two.samples.weights);
    EXPECT_EQ(one.log_evidence, two.log_evidence);
    EXPECT_EQ(one.k_hat, two.k_hat);
    EXPECT_EQ(one.evaluations, two.evaluations);
  }
}

TEST(ImportanceSampler, CountsEveryLikelihood) {
  std::atomic<long long> calls = 0;
  for (Posterior posterior : {yuen_case().posterior, banana_case(1.0).posterior}) {
    posterior.log_likelihood = [&, original = posterior.log_likelihood](const Eigen::VectorXd& x) {
      ++calls;
      return original(x);
    };
    calls = 0;
    const ImportanceResult result = sample_importance(posterior, {.random_starts = 2, .threads = 2});
    EXPECT_EQ(result.evaluations, calls);
  }
}

TEST(ImportanceSampler, ReportsItsProgress) {
  std::vector<double> fractions;
  const auto progress = [&](std::string_view, double fraction) { fractions.push_back(fraction); };
  sample_importance(yuen_case().posterior, {.samples = 200}, progress);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.front(), 0.0);
  EXPECT_EQ(fractions.back(), 1.0);
  EXPECT_GT(fractions.size(), 10U);
}

TEST(ImportanceSampler, StopsWhenAsked) {
  for (const int calls : {10, 200}) {  // in the search, and among the samples
    int asked = 0;
    const StopQuestion question = [&] { return ++asked > calls; };
    const StopScope scope(&question);
    EXPECT_THROW(sample_importance(yuen_case().posterior), Interrupted);
  }
}

TEST(ImportanceSampler, RefusesWhatCannotBeSampled) {
  EXPECT_THROW(sample_importance(yuen_case().posterior, {.samples = 20}), InvalidInput);
  EXPECT_THROW(sample_importance(yuen_case().posterior, {.start = Eigen::Vector3d(1.0, 1.0, 1.0)}), InvalidInput);
  const ImportanceOptions bad{.degrees = 0, .prior_share = 1.0, .efficiency = 2.0, .decrement = 0.0, .threads = 0};
  EXPECT_EQ(validate(bad).issues().size(), 5U);
  const Posterior nowhere{uniform_box(1, 0.0, 1.0), [](const Eigen::VectorXd&) { return std::nan(""); }};
  EXPECT_THROW(sample_importance(nowhere), InvalidInput);
}

TEST(Resampling, DrawsEachSampleAsOftenAsItsWeightSays) {
  const ImportanceResult result = sample_importance(frame_case().posterior, {.samples = 300});
  constexpr int count = 1000;
  const SampleSet draws = resample(result.samples, count);
  EXPECT_EQ(draws.values.cols(), count);
  EXPECT_EQ(draws.draws, count);
  EXPECT_EQ(draws.weights.size(), 0);
  for (Eigen::Index i = 0; i < result.samples.values.cols(); ++i) {
    const auto times = (draws.values.row(0).array() == result.samples.values(0, i)).count();
    EXPECT_LT(std::abs(static_cast<double>(times) - count * result.samples.weights[i]), 1.0);
  }
  const auto before = summarise_samples(result.samples), after = summarise_samples(draws);
  EXPECT_NEAR(after[0].mean, before[0].mean, 0.02 * before[0].deviation);
  EXPECT_NEAR(after[0].deviation, before[0].deviation, 0.02 * before[0].deviation);
}

TEST(Resampling, NeverDrawsWhatHasNoWeight) {
  SampleSet samples{.names = {"a"},
                    .values = Eigen::RowVector4d(1.0, 2.0, 3.0, 4.0),
                    .log_likelihood = Eigen::Vector4d(1.0, 2.0, 3.0, 4.0),
                    .log_prior = Eigen::Vector4d::Zero(),
                    .weights = Eigen::Vector4d(0.0, 0.5, 0.5, 0.0),
                    .draws = 4};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SampleSet two = resample(samples, 2, seed);
    EXPECT_EQ(two.values, Eigen::RowVector2d(2.0, 3.0));
    EXPECT_EQ(two.log_likelihood, Eigen::Vector2d(2.0, 3.0));
  }
  samples.weights.resize(0);
  EXPECT_EQ(resample(samples, 4).values, samples.values);
  EXPECT_THROW(resample(samples, 0), InvalidInput);
  EXPECT_THROW(resample({}, 1), InvalidInput);
}

}  // namespace
}  // namespace kalfem
