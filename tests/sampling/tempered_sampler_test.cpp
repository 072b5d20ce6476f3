// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/tempered_sampler.hpp"

#include <gtest/gtest.h>

#include "evidence_cases.hpp"
#include "kalfem/base/interruption.hpp"
#include "linear_gaussian.hpp"

namespace kalfem {
namespace {

/// One seed: three standard errors, and these small enough to tell something.
void expect_evidence(const EvidenceCase& known, const TemperedOptions& options = {}) {
  const TemperedResult result = sample_tempered(known.posterior, options);
  EXPECT_TRUE(result.finished);
  EXPECT_NEAR(result.log_evidence, known.log_evidence, 3.0 * result.log_evidence_deviation) << known.name;
  EXPECT_LT(result.log_evidence_deviation, 0.15) << known.name;
}

TEST(TemperedSampler, FindsTheEvidenceOfModalData) {
  expect_evidence(yuen_case());
  expect_evidence(frame_case());
}

TEST(TemperedSampler, FindsTheEvidenceOfSeveralModes) {
  expect_evidence(blobs_case());
  expect_evidence(shells_case(2, -1.7456));
  expect_evidence(shells_case(5, -5.6736));
  expect_evidence(eggbox_case());
}

TEST(TemperedSampler, FindsThePosteriorOfModalData) {
  for (const auto& known : {yuen_case(), frame_case()}) {
    const auto summary = summarise_samples(sample_tempered(known.posterior, {.samples = 4000}).samples);
    for (Eigen::Index i = 0; i < 2; ++i) {
      const auto& parameter = summary[static_cast<std::size_t>(i)];
      EXPECT_NEAR(parameter.mean, known.mean[i], 0.03 * known.mean[i]);
      EXPECT_NEAR(parameter.deviation, known.deviation[i],
                  0.06 * known.deviation[i]);  // sampled: 1 / sqrt(2 N), correlated
      EXPECT_LT(parameter.q2_5, parameter.q16);
      EXPECT_LT(parameter.q84, parameter.q97_5);
    }
  }
}

TEST(TemperedSampler, IsExactOnLinearGaussianProblems) {
  for (const int p : {2, 5, 10}) {
    const EvidenceCase known = linear_gaussian_case(p);
    const TemperedOptions options{.samples = 4000};
    const TemperedResult result = sample_tempered(known.posterior, options);
    EXPECT_NEAR(result.log_evidence, known.log_evidence, 3.0 * result.log_evidence_deviation) << p;
    const auto summary = summarise_samples(result.samples);
    const double error = std::sqrt(2.0 / options.samples);  // samples are worth half as many independent ones, at least
    for (Eigen::Index i = 0; i < p; ++i) {
      EXPECT_NEAR(summary[static_cast<std::size_t>(i)].mean, known.mean[i], 3.0 * error * known.deviation[i]);
      EXPECT_NEAR(summary[static_cast<std::size_t>(i)].deviation, known.deviation[i], 3.0 * error * known.deviation[i]);
    }
  }
}

TEST(TemperedSampler, HandlesLikelihoodsFarBelowTheRangeOfDoubles) {
  EvidenceCase known = yuen_case();
  known.posterior.log_likelihood = [original = known.posterior.log_likelihood](const Eigen::VectorXd& x) {
    return original(x) - 1e6;
  };
  known.log_evidence -= 1e6;
  expect_evidence(known);
}

TEST(TemperedSampler, CountsImpossibleModels) {
  // possible for x < 0.25 only: Z = 1/4
  const Posterior posterior{uniform_box(1, 0.0, 1.0),
                            [](const Eigen::VectorXd& x) { return x[0] < 0.25 ? 0.0 : std::nan(""); }};
  const TemperedResult result = sample_tempered(posterior);
  EXPECT_NEAR(result.log_evidence, std::log(0.25), 3.0 * result.log_evidence_deviation);
  EXPECT_LT(result.samples.values.maxCoeff(), 0.25);
  const Posterior nowhere{uniform_box(1, 0.0, 1.0), [](const Eigen::VectorXd&) { return std::nan(""); }};
  EXPECT_THROW(sample_tempered(nowhere), InvalidInput);
}

void expect_same(const TemperedState& a, const TemperedState& b) {
  EXPECT_EQ(a.z, b.z);
  EXPECT_EQ(a.log_likelihood, b.log_likelihood);
  EXPECT_EQ(a.log_evidence(), b.log_evidence());
  EXPECT_EQ(a.log_evidence_deviation(), b.log_evidence_deviation());
  EXPECT_EQ(a.evaluations, b.evaluations);
}

TEST(TemperedSampler, DoesNotDependOnThreads) {
  const EvidenceCase known = yuen_case();
  const TemperedState one = sample_tempered(known.posterior, {.samples = 300}).state;
  expect_same(one, sample_tempered(known.posterior, {.samples = 300, .threads = 3}).state);
}

TEST(TemperedSampler, ContinuesBitForBit) {
  for (const int length : {1, 100}) {
    const EvidenceCase known = yuen_case();
    const TemperedOptions options{.samples = 300, .max_chain_length = length};
    std::vector<TemperedState> states;
    const auto whole =
        sample_tempered(known.posterior, options, [&](const TemperedState& state) { states.push_back(state); });
    for (const auto& state : states)
      expect_same(whole.state, sample_tempered(known.posterior, options, {}, &state).state);
    EXPECT_THROW(sample_tempered(known.posterior, {.samples = 400}, {}, &states[0]), InvalidInput);
  }
}

TEST(TemperedSampler, StopsWhenAsked) {
  int asked = 0;
  const StopQuestion question = [&] { return ++asked > 1000; };
  const StopScope scope(&question);
  EXPECT_THROW(sample_tempered(yuen_case().posterior, {.samples = 300}), Interrupted);
}

TEST(TemperedSampler, RefusesBadOptions) {
  EXPECT_THROW(sample_tempered(yuen_case().posterior, {.samples = 3}), InvalidInput);
  EXPECT_EQ(validate(TemperedOptions{.acceptance = 2.0, .min_moves = 0, .threads = 0}).issues().size(), 3U);
}

TEST(TemperedSampler, TellsWhenItIsNotFinished) {
  EXPECT_FALSE(sample_tempered(yuen_case().posterior, {.samples = 300, .max_stages = 1}).finished);
}

}  // namespace
}  // namespace kalfem
