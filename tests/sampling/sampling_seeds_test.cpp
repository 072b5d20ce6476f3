#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "evidence_cases.hpp"
#include "kalfem/sampling/tempered_sampler.hpp"
#include "linear_gaussian.hpp"

namespace kalfem {
namespace {

constexpr int seeds = 10;

struct OverSeeds {
  double median = 0.0, stated = 0.0, evaluations = 0.0;
  int covered = 0;  ///< seeds with the truth within two standard errors
  Eigen::VectorXd mean, deviation;
};

OverSeeds run_seeds(const EvidenceCase& known, const TemperedOptions& asked = {}) {
  OverSeeds over;
  std::vector<double> found;
  over.mean = over.deviation = Eigen::VectorXd::Zero(known.posterior.prior.size());
  for (int seed = 1; seed <= seeds; ++seed) {
    TemperedOptions options = asked;
    options.seed = static_cast<std::uint64_t>(seed);
    options.threads = 2;
    const TemperedResult result = sample_tempered(known.posterior, options);
    found.push_back(result.log_evidence);
    over.stated += result.log_evidence_deviation / seeds;
    over.evaluations += static_cast<double>(result.state.evaluations) / seeds;
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
    for (Eigen::Index i = 0; i < 2; ++i) {
      std::printf("    %.5g +- %.4g (exact %.5g +- %.4g)\n", over.mean[i], over.deviation[i], known.mean[i],
                  known.deviation[i]);
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

}  // namespace
}  // namespace kalfem
