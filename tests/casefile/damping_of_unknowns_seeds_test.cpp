// SPDX-License-Identifier: Apache-2.0
#include "casefile/damping_of_unknowns.hpp"

#include "kalfem/steps/run_study.hpp"

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The example's 20 s with 40 seeds of noise, from first guesses of a spring that are right, 20 % and 50 % off.
TEST(DampingOfUnknownsOverSeeds, EstimatesDoNotDependOnTheFirstGuessAndCoverTheTruth) {
  const std::array<const char*, 3> guesses = {"30", "36", "45"};
  std::vector<Study> studies;
  for (const std::string guess : guesses)
    studies.push_back(study_of(chain_case("20 s", "    body.3-4.stiffness: {initial: " + guess +
                                                      " kN/m, std: 30 %}\n"
                                                      "    body.damping.modal: {initial: 1.5 %, std: 50 %}\n")));
  const StudyResults simulated = run_study(studies[0], "simulate");
  const VectorXd truth = truth_of(studies[0]);
  constexpr int seeds = 40;
  std::array<Eigen::VectorXi, 3> covered;
  covered.fill(Eigen::VectorXi::Zero(truth.size()));
  VectorXd farthest = VectorXd::Zero(truth.size()), nis = VectorXd::Zero(3), mean = VectorXd::Zero(truth.size());
  for (int seed = 1; seed <= seeds; ++seed) {
    const StudyResults record = record_with_noise(simulated, static_cast<std::uint64_t>(seed));
    std::vector<LastEstimates> all;
    for (const auto& study : studies) all.push_back(estimates_of(study, record));
    for (std::size_t g = 0; g < all.size(); ++g) {
      const VectorXd z = (all[g].values - truth).cwiseQuotient(all[g].deviations);
      covered[g] += (z.array().abs() < 1.96).cast<int>().matrix();
      nis[Index(g)] += all[g].nis / seeds;
      if (g == 0) mean += z / seeds;
      farthest = farthest.cwiseMax((all[g].values - all[0].values).cwiseQuotient(all[0].deviations).cwiseAbs());
    }
  }
  for (std::size_t g = 0; g < guesses.size(); ++g) {
    std::printf("first guess %s kN/m: NIS %.4f; inside the 95 %% interval", guesses[g], nis[Index(g)]);
    for (Index i = 0; i < truth.size(); ++i) {
      std::printf(" %s %.1f %%", studies[0].augmented_model->options.unknowns[std::size_t(i)].name.c_str(),
                  100.0 * covered[g][i] / seeds);
      EXPECT_GE(covered[g][i], 36);
      EXPECT_LE(covered[g][i], 40);
    }
    std::printf("\n");
    EXPECT_NEAR(nis[Index(g)], 4.0, 0.08);
  }
  for (Index i = 0; i < truth.size(); ++i) {
    std::printf(
        "unknown %d: estimates of the three guesses differ by %.2f standard deviations at the most, mean error %+.2f\n",
        int(i), farthest[i], mean[i]);
    EXPECT_LT(farthest[i], 0.3);
  }
}

}  // namespace
}  // namespace kalfem::test
