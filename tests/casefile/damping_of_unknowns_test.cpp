// SPDX-License-Identifier: Apache-2.0
#include "casefile/damping_of_unknowns.hpp"
#include "base/scratch_folder.hpp"

#include "kalfem/steps/prediction/outcome.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

// Damping that is formed from modes, or from M and K, follows the stiffness and the mass that the filter estimates. The
// first guess of these must not show in the estimates.

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Estimates from each text's first guesses on the record of the first.
std::vector<LastEstimates> from_each(const std::vector<std::string>& texts, VectorXd& truth) {
  std::vector<LastEstimates> all;
  StudyResults record;
  for (const auto& text : texts) {
    const Study study = study_of(text);
    if (all.empty()) {
      record = run_study(study, "simulate");
      truth = truth_of(study);
    }
    all.push_back(estimates_of(study, record));
  }
  return all;
}

/// The same estimates from every first guess to so many standard deviations, near the truth, with an NIS that is right.
void expect_no_trace_of_first_guesses(const std::vector<std::string>& texts, double within = 0.3) {
  VectorXd truth;
  const auto all = from_each(texts, truth);
  for (std::size_t g = 0; g < all.size(); ++g) {
    // 8000 samples of four channels: three standard errors of sqrt(8 / 8000); found .035
    EXPECT_NEAR(all[g].nis, 4.0, 0.1) << "guess " << g;
    for (Index i = 0; i < truth.size(); ++i) {
      // the accuracy that is stated for chains: found .28 of .3
      EXPECT_NEAR(all[g].values[i], all[0].values[i], within * all[0].deviations[i])
          << "guess " << g << ", unknown " << i;
      // four deviations: one record's noise, found 3.1
      EXPECT_NEAR(all[g].values[i], truth[i], 4.0 * all[g].deviations[i]) << "guess " << g << ", unknown " << i;
    }
    std::printf("guess %d: relinearised %d times, NIS %.3f;", int(g), all[g].linearisations, all[g].nis);
    for (Index i = 0; i < truth.size(); ++i)
      std::printf(" %.6g +- %.2g (%+.2f from guess 0, %+.2f from the truth)", all[g].values[i], all[g].deviations[i],
                  (all[g].values[i] - all[0].values[i]) / all[0].deviations[i],
                  (all[g].values[i] - truth[i]) / all[g].deviations[i]);
    std::printf("\n");
  }
}

std::string spring(const std::string& kilonewtons) {
  return "    body.3-4.stiffness: {initial: " + kilonewtons + " kN/m, std: 30 %}\n";
}

const std::string ratio = "    body.damping.modal: {initial: 1.5 %, std: 50 %}\n";

TEST(DampingOfUnknowns, ModalDampingFollowsASpring) {
  expect_no_trace_of_first_guesses({chain_case("8 s", spring("30") + ratio), chain_case("8 s", spring("36") + ratio),
                                    chain_case("8 s", spring("45") + ratio)});
}

TEST(DampingOfUnknowns, ModalDampingFollowsAMass) {
  const auto mass = [](const std::string& kg) { return "    body.5.mass: {initial: " + kg + " kg, std: 30 %}\n"; };
  expect_no_trace_of_first_guesses({chain_case("5 s", mass("1") + ratio), chain_case("5 s", mass("1.4") + ratio)});
}

TEST(DampingOfUnknowns, RayleighDampingFollowsASpring) {
  const auto text = [](const std::string& kilonewtons) {
    return with(
        chain_case("5 s", spring(kilonewtons) + "    body.damping.stiffness_factor: {initial: 0.3 ms, std: 50 %}\n"),
        "modal: 1 %", "stiffness_factor: 0.2 ms, mass_factor: 0.5 1/s");
  };
  expect_no_trace_of_first_guesses({text("30"), text("40")});
}

/// Modes of the whole structure follow its connectors as well: the slope of the suspension at rest is k + mu_k1 /
/// mu_k2.
TEST(DampingOfUnknowns, DampingOfTheWholeStructureFollowsSpringsAndConnectors) {
  const auto text = [](const std::string& kilonewtons, const std::string& mu_k1) {
    const auto whole = with(chain_case("5 s", spring(kilonewtons)), "    damping: {modal: 1 %}\n", "");
    return with(with(whole, "connectors:", "damping: {modal: 1 %}\n\nconnectors:"), "mu_k1: {initial: 10 N",
                "mu_k1: {initial: " + mu_k1 + " N");
  };
  expect_no_trace_of_first_guesses({text("30", "20"), text("40", "10")});
}

/// An accelerated base pulls at a mass with -m a, not at the first guess of it, which gave 45 to 62 deviations and an
/// NIS of 10. Some of the first samples' errors stays (1.5 deviations): the product of the prior's 30 % with the
/// deviations of the state, which the column of the gain leaves out.
TEST(DampingOfUnknowns, TheLoadOfAnAcceleratedBaseFollowsAMass) {
  const auto text = [](const std::string& kg) {
    const auto undamped = with(chain_case("5 s", "    body.5.mass: {initial: " + kg + " kg, std: 30 %}\n"),
                               "    damping: {modal: 1 %}\n", "    springs: [{from: 1, to: 10, damping: 5 N s/m}]\n");
    return with(undamped, "base_displacement: wheel.ground\n    random: {rms: 3 mm,",
                "base_acceleration: all\n    random: {rms: 5 m/s^2,");
  };
  expect_no_trace_of_first_guesses({text("1"), text("1.4")}, 2.0);
}

TEST(DampingOfUnknowns, AFirstGuessOfNothingIsRefusedWhereDampingFollowsIt) {
  try {
    study_of(chain_case("1 s", "    body.3-4.stiffness: {initial: 0 N/m, std: 10 kN/m}\n"));
    FAIL() << "it was accepted";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("start from a positive initial value"), std::string::npos) << error.what();
  }
  study_of(
      chain_case("1 s", "    wheel.k_w.stiffness: {initial: 0 N/m, std: 10 kN/m}\n"));  // carried by a connector alone
}

/// The chain with one more spring, of which the filter knows neither case's value, and the body's prediction.
std::string with_extra_spring(const std::string& given) {
  const auto text = chain_case("4 s", "    body.extra.stiffness: {initial: 6 kN/m, std: 30 %}\n") +
                    "\npredict:\n  substructure: body\n";
  return with(with(text, "stiffness: 30 kN/m}",
                   "stiffness: 30 kN/m}\n    springs: [{name: extra, from: 3, to: 6, stiffness: " + given + "}]"),
              "seed: 7}", "seed: 7, duration: 4 s}");
}

/// The same record, read from a file by a case that gives another spring: the prediction is made with the estimated
/// one.
TEST(DampingOfUnknowns, ThePredictionUsesTheEstimatedSpring) {
  const ScratchFolder folder("estimated-spring");
  const StudyResults right = run_study(study_of(with_extra_spring("5 kN/m")), "predict");
  ASSERT_EQ(right.failure, "");
  const auto& record = right.get<SimulationOutcome>().measurements;
  std::ofstream file(folder / "record.csv");
  file << "time";
  for (const auto& channel : record.channels) file << "," << channel.name;
  for (Index k = 0; k < record.samples(); ++k) {
    file << "\n" << record.time(k);
    for (const double value : record.values.col(k)) file << "," << value;
  }
  file.close();
  std::string text = with_extra_spring("15 kN/m");
  const auto begin = text.find("simulate:"), end = text.find("estimate:");
  text.replace(begin, end - begin,
               "record: {file: '" + (folder / "record.csv").string() + "', sample_rate: 1 kHz}\n\n");
  const StudyResults read = run_study(study_of(text), "predict");
  ASSERT_EQ(read.failure, "");
  ASSERT_EQ(read.get<PredictionOutcome>().points.size(), right.get<PredictionOutcome>().points.size());
  for (std::size_t i = 0; i < read.get<PredictionOutcome>().points.size(); ++i) {
    const auto& expected = right.get<PredictionOutcome>().points[i].mean;
    // found 2e-4
    EXPECT_LT((read.get<PredictionOutcome>().points[i].mean - expected).norm(), 5e-4 * expected.norm())
        << read.get<PredictionOutcome>().points[i].point;
  }
}

/// What does not change the linear part stays with its connector: nothing is relinearised.
TEST(DampingOfUnknowns, AnUnknownOfAnUndampedPartIsCarriedByItsConnectorAlone) {
  const Study study = study_of(chain_case("1 s",
                                          "    wheel.k_w.stiffness: {initial: 22 kN/m, std: 30 %}\n"
                                          "    body.3-4.damping: {initial: 1 N s/m, std: 100 %}\n"));
  EXPECT_TRUE(study.augmented_model->linear_unknowns.empty());
  for (const auto& unknown : study.augmented_model->options.unknowns)
    EXPECT_FALSE(unknown.in_linear_part) << unknown.name;
}

}  // namespace
}  // namespace kalfem::test
