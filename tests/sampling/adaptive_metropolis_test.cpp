// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/adaptive_metropolis.hpp"

#include <gtest/gtest.h>

#include "evidence_cases.hpp"
#include "kalfem/sampling/importance_sampler.hpp"
#include "linear_gaussian.hpp"

namespace kalfem {
namespace {

/// x_{k+1} = rho x_k + sqrt(1 - rho^2) e_k in every chain.
Eigen::MatrixXd autoregression(int draws, int chains, double rho) {
  RandomStream random(5, "autoregression");
  Eigen::MatrixXd x(draws, chains);
  for (int c = 0; c < chains; ++c) {
    x(0, c) = random.normal();
    for (int k = 1; k < draws; ++k) x(k, c) = rho * x(k - 1, c) + std::sqrt(1.0 - rho * rho) * random.normal();
  }
  return x;
}

TEST(Convergence, CountsWhatCorrelatedDrawsAreWorth) {
  // in closed form S (1 - rho) / (1 + rho)
  EXPECT_NEAR(effective_sample_size(autoregression(5000, 4, 0.0)), 20000.0, 2000.0);
  EXPECT_NEAR(effective_sample_size(autoregression(5000, 4, 0.8)), 20000.0 / 9.0, 0.1 * 20000.0 / 9.0);
  EXPECT_GT(effective_sample_size(autoregression(5000, 4, -0.5)), 35000.0);  // 60000: better than independent
}

TEST(Convergence, IsReachedByIndependentDraws) {
  const Convergence convergence = convergence_of(autoregression(1000, 4, 0.0));
  EXPECT_LT(convergence.r_hat, 1.005);
  EXPECT_TRUE(convergence.reached(4));
}

TEST(Convergence, SeesChainsApartOfDifferentWidthAndDrifting) {
  const Eigen::MatrixXd draws = autoregression(1000, 4, 0.0);
  Eigen::MatrixXd apart = draws, wide = draws, drifting = draws;
  apart.col(0).array() += 1.0;
  wide.col(0) *= 3.0;  // the same mean: only the folded draws tell
  drifting += Eigen::VectorXd::LinSpaced(1000, -1.0, 1.0).replicate(1, 4);
  for (const auto& spoilt : {apart, wide, drifting}) EXPECT_GT(convergence_of(spoilt).r_hat, 1.03);
  EXPECT_FALSE(convergence_of(Eigen::MatrixXd::Constant(100, 4, 1.0)).reached(4));
}

TEST(Convergence, RanksShareTies) {
  const Eigen::MatrixXd scores = rank_normalised(Eigen::Vector4d(2.0, 1.0, 2.0, 3.0));
  EXPECT_EQ(scores(0), scores(2));
  EXPECT_NEAR(scores(0), 0.0, 1e-12);
  EXPECT_NEAR(scores(1), -scores(3), 1e-12);
}

TEST(AdaptiveMetropolis, FindsThePosterior) {
  for (const auto& known : {yuen_case(), frame_case(), linear_gaussian_case(5)}) {
    const MetropolisResult result = sample_metropolis(known.posterior, {.draws = 8000});
    EXPECT_TRUE(result.converged) << known.name;
    const auto summary = summarise_samples(result.samples);
    for (std::size_t i = 0; i < summary.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const double error = 3.5 / std::sqrt(result.convergence[i].bulk_ess) * known.deviation[k];  // Monte Carlo errors
      EXPECT_NEAR(summary[i].mean, known.mean[k], error) << known.name;
      EXPECT_NEAR(summary[i].deviation, known.deviation[k], 1.5 * error) << known.name;
    }
    EXPECT_GT(result.acceptance.minCoeff(), 0.15);
    EXPECT_LT(result.acceptance.maxCoeff(), 0.4);
  }
}

TEST(AdaptiveMetropolis, TellsThatChainsAreInDifferentModes) {
  EXPECT_FALSE(sample_metropolis(blobs_case().posterior, {.chains = 8, .draws = 1000}).converged);
}

TEST(AdaptiveMetropolis, ContinuesBitForBitOnAnyNumberOfThreads) {
  const EvidenceCase known = yuen_case();
  MetropolisOptions options{.chains = 3, .warm_up = 250, .draws = 300};
  std::vector<MetropolisState> states;
  const auto whole =
      sample_metropolis(known.posterior, options, [&](const MetropolisState& state) { states.push_back(state); });
  options.threads = 3;
  for (const auto& state : states) {
    const auto continued = sample_metropolis(known.posterior, options, {}, &state);
    EXPECT_EQ(whole.samples.values, continued.samples.values);
    EXPECT_EQ(whole.state.evaluations, continued.state.evaluations);
  }
  EXPECT_EQ(whole.samples.draws_of(0).cols(), 3);
  EXPECT_THROW(sample_metropolis(linear_gaussian_case(5).posterior, options, {}, &states[0]), InvalidInput);
  EXPECT_THROW(sample_metropolis(known.posterior, {.chains = 3, .warm_up = 10, .draws = 10}, {}, &states.back()),
               InvalidInput);
}

TEST(AdaptiveMetropolis, NeedsAShortWarmUpFromAKnownCovariance) {
  for (const auto& known : {frame_case(), linear_gaussian_case(5)}) {
    MetropolisOptions options{.warm_up = 200, .draws = 6000};
    options.start = sample_importance(known.posterior, {.samples = 400}).approximation;
    const MetropolisResult result = sample_metropolis(known.posterior, options);
    EXPECT_TRUE(result.converged) << known.name;
    const auto summary = summarise_samples(result.samples);
    for (std::size_t i = 0; i < summary.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const double error = 3.5 / std::sqrt(result.convergence[i].bulk_ess) * known.deviation[k];
      EXPECT_NEAR(summary[i].mean, known.mean[k], error) << known.name;
      EXPECT_NEAR(summary[i].deviation, known.deviation[k], 1.5 * error) << known.name;
    }
  }
  EXPECT_FALSE(sample_metropolis(linear_gaussian_case(5).posterior, {.warm_up = 200, .draws = 6000}).converged);

  const EvidenceCase ten = linear_gaussian_case(10);
  MetropolisOptions options{.warm_up = 200};
  options.start = sample_importance(ten.posterior, {.samples = 400}).approximation;
  for (const auto& convergence : sample_metropolis(ten.posterior, options).convergence)
    EXPECT_GT(convergence.bulk_ess, 150.0);  // under 20 if the chains forget the covariance that they start with
}

TEST(AdaptiveMetropolis, StartsTwiceAsWideAsTheKnownApproximation) {
  constexpr int chains = 20000;
  Eigen::MatrixXd starts(2, chains);
  int calls = 0;  // the first ones are at the starts
  const Posterior posterior{JointPrior({{"a", NormalPrior{0.0, 1.0}}, {"b", NormalPrior{0.0, 1.0}}}),
                            [&](const Eigen::VectorXd& z) {
                              if (calls < chains) starts.col(calls++) = z;
                              return 0.0;
                            }};
  MetropolisOptions options{.chains = chains, .warm_up = 0, .draws = 8};
  options.start = NormalApproximation{Eigen::Vector2d(0.5, -1.0), Eigen::Matrix2d{{0.04, 0.03}, {0.03, 0.09}}};
  const MetropolisState state = sample_metropolis(posterior, options).state;
  const Eigen::Vector2d mean = starts.rowwise().mean();
  const Eigen::MatrixXd centred = starts.colwise() - mean;
  const Eigen::Matrix2d covariance = centred * centred.transpose() / chains;
  EXPECT_LT((mean - options.start->mean).norm(), 0.02);
  EXPECT_LT((covariance - 4.0 * options.start->covariance).norm(), 0.04);
  EXPECT_EQ(state.chains[0].covariance, options.start->covariance);  // no warm-up
}

TEST(AdaptiveMetropolis, ContinuesBitForBitFromAKnownStart) {
  const EvidenceCase known = frame_case();
  MetropolisOptions options{.chains = 3, .warm_up = 150, .draws = 200, .block = 50};
  options.start = sample_importance(known.posterior, {.samples = 200}).approximation;
  std::vector<MetropolisState> states;
  const auto whole =
      sample_metropolis(known.posterior, options, [&](const MetropolisState& state) { states.push_back(state); });
  options.threads = 2;
  for (const auto& state : states)
    EXPECT_EQ(whole.samples.values, sample_metropolis(known.posterior, options, {}, &state).samples.values);
}

TEST(AdaptiveMetropolis, RefusesAStartThatDoesNotFit) {
  const Posterior posterior = linear_gaussian_case(2).posterior;
  const Eigen::Matrix2d indefinite{{1.0, 2.0}, {2.0, 1.0}};
  for (const NormalApproximation& start :
       {NormalApproximation{Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()},
        NormalApproximation{Eigen::Vector2d::Zero(), indefinite}, NormalApproximation{Eigen::Vector2d::Zero(), {}}}) {
    MetropolisOptions options;
    options.start = start;
    EXPECT_THROW(sample_metropolis(posterior, options), InvalidInput);
  }
}

}  // namespace
}  // namespace kalfem
