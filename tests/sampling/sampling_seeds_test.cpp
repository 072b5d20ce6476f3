// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "evidence_cases.hpp"
#include "kalfem/sampling/importance_sampler.hpp"
#include "kalfem/sampling/tempered_sampler.hpp"
#include "linear_gaussian.hpp"

namespace kalfem {
namespace {

constexpr int seeds = 10;

struct OverSeeds {
  double median = 0.0, stated = 0.0, evaluations = 0.0;
  int covered = 0;   ///< seeds with the truth within two standard errors
  int reliable = 0;  ///< seeds that importance sampling calls so
  Eigen::VectorXd mean, deviation;
};

/// `run`: of a seed, the result and its number of likelihoods.
template <class Run>
OverSeeds over_seeds(const EvidenceCase& known, const Run& run) {
  OverSeeds over;
  std::vector<double> found;
  over.mean = over.deviation = Eigen::VectorXd::Zero(known.posterior.prior.size());
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto [result, evaluations] = run(static_cast<std::uint64_t>(seed));
    found.push_back(result.log_evidence);
    over.stated += result.log_evidence_deviation / seeds;
    over.evaluations += static_cast<double>(evaluations) / seeds;
    over.covered += std::abs(result.log_evidence - known.log_evidence) < 2.0 * result.log_evidence_deviation ? 1 : 0;
    const auto summary = summarise_samples(result.samples);
    for (std::size_t i = 0; i < summary.size(); ++i) {
      over.mean[static_cast<Eigen::Index>(i)] += summary[i].mean / seeds;
      over.deviation[static_cast<Eigen::Index>(i)] += summary[i].deviation / seeds;
    }
  }
  std::sort(found.begin(), found.end());
  over.median = 0.5 * (found[seeds / 2 - 1] + found[seeds / 2]);
  std::printf("%-26s ln Z %11.4f (exact %11.4f), stated error %.3f, covers in %d of %d, %.0f evaluations\n",
              known.name.c_str(), over.median, known.log_evidence, over.stated, over.covered, seeds, over.evaluations);
  return over;
}

OverSeeds run_seeds(const EvidenceCase& known, TemperedOptions options = {}) {
  options.threads = 2;
  return over_seeds(known, [&](std::uint64_t seed) {
    options.seed = seed;
    TemperedResult result = sample_tempered(known.posterior, options);
    const long long evaluations = result.state.evaluations;
    return std::pair(std::move(result), evaluations);
  });
}

OverSeeds run_seeds(const EvidenceCase& known, ImportanceOptions options) {
  int reliable = 0;
  OverSeeds over = over_seeds(known, [&](std::uint64_t seed) {
    options.seed = seed;
    ImportanceResult result = sample_importance(known.posterior, options);
    reliable += result.reliable() ? 1 : 0;
    const long long evaluations = result.evaluations;
    return std::pair(std::move(result), evaluations);
  });
  over.reliable = reliable;
  return over;
}

void print_posterior(const OverSeeds& over, const EvidenceCase& known) {
  for (Eigen::Index i = 0; i < known.mean.size(); ++i)
    std::printf("    %.5g +- %.4g (exact %.5g +- %.4g)\n", over.mean[i], over.deviation[i], known.mean[i],
                known.deviation[i]);
}

TEST(SamplingSeeds, EvidenceIsRightAndItsErrorHonest) {
  for (const auto& known : {yuen_case(), frame_case(), shells_case(2, -1.7456), shells_case(5, -5.6736),
                            shells_case(10, -14.5905), eggbox_case(), blobs_case()}) {
    const OverSeeds over = run_seeds(known);
    EXPECT_NEAR(over.median, known.log_evidence, 0.1) << known.name;
    EXPECT_GE(over.covered, 9) << known.name;
    EXPECT_LT(over.stated, 0.15) << known.name;
  }
}

TEST(SamplingSeeds, PosteriorOfModalData) {
  for (const auto& known : {yuen_case(), frame_case()}) {
    const OverSeeds over = run_seeds(known);
    print_posterior(over, known);
    for (Eigen::Index i = 0; i < 2; ++i) {
      EXPECT_NEAR(over.mean[i], known.mean[i], 0.03 * known.mean[i]);
      EXPECT_NEAR(over.deviation[i], known.deviation[i], 0.03 * known.deviation[i]);
    }
  }
}

TEST(SamplingSeeds, LinearGaussianProblems) {
  for (const int p : {2, 5, 10}) {
    const EvidenceCase known = linear_gaussian_case(p);
    const OverSeeds over = run_seeds(known);
    EXPECT_NEAR(over.median, known.log_evidence, 0.1) << p;
    EXPECT_GE(over.covered, 9) << p;
    for (Eigen::Index i = 0; i < p; ++i)  // mean of 10 runs of 2000 samples, worth half as many
      EXPECT_NEAR(over.mean[i], known.mean[i], 3.0 * std::sqrt(2.0 / (2000.0 * seeds)) * known.deviation[i]);
  }
}

std::vector<EvidenceCase> cases_with_one_mode() {
  return {yuen_case(), frame_case(), linear_gaussian_case(2), linear_gaussian_case(5), linear_gaussian_case(10)};
}

TEST(SamplingSeeds, ExpensiveLikelihoodsByTempering) {
  int covered = 0;
  for (const auto& known : cases_with_one_mode()) {
    const OverSeeds over = run_seeds(known, tempered_options_for_expensive_likelihoods());
    EXPECT_NEAR(over.median, known.log_evidence, 0.15) << known.name;
    EXPECT_LT(over.stated, 0.3) << known.name;
    EXPECT_GE(over.covered, 8) << known.name;
    covered += over.covered;
  }
  EXPECT_GE(covered, 43);  // of 50; 200 seeds of each case: 91 to 94 %
}

/// The table of docs/sampling.md from which the settings were chosen; ten minutes.
TEST(SamplingSeeds, DISABLED_SettingsForExpensiveLikelihoods) {
  constexpr int runs = 200;
  for (const auto& known : cases_with_one_mode())
    for (const double correlation : {0.1, 0.3, 0.45, 0.6}) {
      TemperedOptions options = tempered_options_for_expensive_likelihoods();
      options.correlation = correlation;
      options.threads = 2;
      std::vector<double> errors;
      double stated = 0.0, square = 0.0, evaluations = 0.0;
      int covered = 0;
      for (int seed = 1; seed <= runs; ++seed) {
        options.seed = static_cast<std::uint64_t>(seed);
        const TemperedResult result = sample_tempered(known.posterior, options);
        errors.push_back(result.log_evidence - known.log_evidence);
        stated += result.log_evidence_deviation / runs;
        square += errors.back() * errors.back() / runs;
        covered += std::abs(errors.back()) < 2.0 * result.log_evidence_deviation ? 1 : 0;
        evaluations += static_cast<double>(result.state.evaluations) / runs;
      }
      std::sort(errors.begin(), errors.end());
      std::printf(
          "%-26s correlation %.2f: median error %+.3f, root mean square %.3f, stated %.3f, covers in %d of %d, "
          "%.0f evaluations\n",
          known.name.c_str(), correlation, errors[runs / 2], std::sqrt(square), stated, covered, runs, evaluations);
    }
}

TEST(SamplingSeeds, ImportanceSamplingWithOneMode) {
  for (const int samples : {200, 500, 1000}) {
    std::printf("%d samples\n", samples);
    for (const auto& known : cases_with_one_mode()) {
      const OverSeeds over = run_seeds(known, ImportanceOptions{.samples = samples});
      EXPECT_NEAR(over.median, known.log_evidence, 0.05) << known.name;
      EXPECT_GE(over.covered, 9) << known.name;
      EXPECT_EQ(over.reliable, seeds) << known.name;
      EXPECT_LT(over.stated, 1.0 / std::sqrt(samples)) << known.name;
      if (samples < 1000) continue;
      if (known.mean.size() == 2) print_posterior(over, known);
      const double error = 3.0 / std::sqrt(0.6 * samples * seeds);
      for (Eigen::Index i = 0; i < known.mean.size(); ++i) {
        EXPECT_NEAR(over.mean[i], known.mean[i], error * known.deviation[i]) << known.name;
        EXPECT_NEAR(over.deviation[i], known.deviation[i], error * known.deviation[i]) << known.name;
      }
    }
  }
}

TEST(SamplingSeeds, ImportanceSamplingTellsWhereItFails) {
  for (const auto& known : {shells_case(2, -1.7456), shells_case(5, -5.6736), eggbox_case(), blobs_case()}) {
    const OverSeeds over = run_seeds(known, ImportanceOptions{});
    std::printf("    called reliable in %d of %d\n", over.reliable, seeds);
    EXPECT_EQ(over.reliable, 0) << known.name;
  }
}

TEST(SamplingSeeds, ImportanceSamplingSeldomTrustsACurvedRidge) {
  constexpr int runs = 40;
  int misled = 0;
  for (const auto& known : {ridge_case(), banana_case(0.3), banana_case(1.0), banana_case(3.0), banana_case(10.0)}) {
    double bias = 0.0, stated = 0.0;
    int reliable = 0, wrong = 0;
    for (int seed = 1; seed <= runs; ++seed) {
      const ImportanceResult result = sample_importance(known.posterior, {.seed = static_cast<std::uint64_t>(seed)});
      const double error = result.log_evidence - known.log_evidence;
      bias += error / runs;
      stated += result.log_evidence_deviation / runs;
      reliable += result.reliable() ? 1 : 0;
      wrong += result.reliable() && std::abs(error) > 3.0 * result.log_evidence_deviation ? 1 : 0;
    }
    std::printf("%-26s mean error of ln Z %.3f, stated error %.3f, called reliable in %d of %d, wrongly in %d\n",
                known.name.c_str(), bias, stated, reliable, runs, wrong);
    misled += wrong;
  }
  EXPECT_LE(misled, 10);  // of 200
}

TEST(SamplingSeeds, ImportanceSamplingHasNoBias) {
  // 400 runs tell a bias of a tenth of the standard error; samples kept from before a fit would have one of 2.5
  constexpr int runs = 400;
  for (const double efficiency : {0.5, 0.9}) {  // 0.9: the proposal is always fitted anew
    const EvidenceCase known = linear_gaussian_case(10);
    double bias = 0.0, square = 0.0, stated = 0.0;
    for (int seed = 1; seed <= runs; ++seed) {
      const ImportanceResult result =
          sample_importance(known.posterior, {.efficiency = efficiency, .seed = static_cast<std::uint64_t>(seed)});
      const double error = result.log_evidence - known.log_evidence;
      bias += error / runs;
      square += error * error / runs;
      stated += result.log_evidence_deviation / runs;
    }
    std::printf("%s, efficiency %.1f: bias of ln Z %.4f, root mean square error %.4f, stated error %.4f\n",
                known.name.c_str(), efficiency, bias, std::sqrt(square), stated);
    EXPECT_LT(std::abs(bias), 0.2 * std::sqrt(square));
    EXPECT_NEAR(stated, std::sqrt(square), 0.25 * stated);
  }
}

}  // namespace
}  // namespace kalfem
