// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "base/figures.hpp"
#include "command.hpp"

// The model aircraft of the European benchmark: updated on the re-test of one laboratory, a modification predicted.

namespace kalfem::test {
namespace {

struct GarteurCase {
  std::string name, modification;
};

void PrintTo(const GarteurCase& one, std::ostream* stream) { *stream << one.name; }

class GarteurUpdating : public testing::TestWithParam<GarteurCase> {
protected:
  void SetUp() override {
    if (!std::filesystem::exists(data_folder("garteur/nodes.csv")))
      KALFEM_ABSENT("no GARTEUR tables in " + data_folder().string());
    const ScratchFolder folder("garteur-" + GetParam().name);
    const auto outcome = run_command(
        "run " + example("garteur/" + GetParam().name + ".yaml") + " --out " + folder.path().string(), folder);
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    summary_ = read_summary(folder);
  }
  [[nodiscard]] double estimate(const std::string& parameter) const {
    return summary_["updating"]["parameters"]["plane." + parameter]["estimate"].get<double>();
  }
  void expect_fit() const {
    const auto& frequencies = summary_["updating"]["comparisons"]["frequencies"];
    const double error = frequencies["mean_frequency_error_final"];
    // docs/figures.txt: .07 and .11 %
    EXPECT_LT(error, 0.002);
    expect_figure("garteur." + GetParam().name + ".mean_error", error);
    expect_figure("garteur." + GetParam().name + ".mean_error_before",
                  frequencies["mean_frequency_error_initial"].get<double>());
  }

  void expect_plausible_parameters() const {
    // handbook values of aluminium alloys; the wing's case ends at 72.0
    EXPECT_GT(estimate("aluminium.youngs_modulus"), 70e9);
    EXPECT_LT(estimate("aluminium.youngs_modulus"), 72.2e9);
    // within 8 % of the alloy's
    EXPECT_NEAR(estimate("fittings.density"), 2700.0, 400.0);
    // Two steel bars of 15 x 15 x 100 mm weigh 0.353 kg.
    EXPECT_NEAR(estimate("tail.mass"), 0.353, 0.05);
  }

  void expect_prediction() const {
    const auto& prediction = summary_["prediction"][GetParam().modification];
    const auto &frequencies = prediction["frequencies_hz"], &deviations = prediction["frequencies_std_hz"];
    ASSERT_EQ(frequencies.size(), 10U);
    ASSERT_EQ(deviations.size(), 10U);
    const auto& modes = summary_["updating"]["comparisons"]["frequencies"]["modes"];
    double half_widths = 0.0;
    for (std::size_t i = 0; i < 10; ++i) {
      const double frequency = frequencies[i], before = modes[i]["model_hz"];
      // A mass lowers every frequency; as it moves in three directions, none falls below its third lower neighbour.
      EXPECT_LE(frequency, before * (1.0 + 1e-9)) << i + 1;
      if (i > 2) {
        EXPECT_GE(frequency, modes[i - 3]["model_hz"].get<double>() * (1.0 - 1e-9)) << i + 1;
      }
      // found .2 to 4.5 %
      EXPECT_GT(deviations[i].get<double>(), 1e-3 * frequency) << i + 1;
      EXPECT_LT(deviations[i].get<double>(), 5e-2 * frequency) << i + 1;
      half_widths += 1.96 * deviations[i].get<double>() / frequency;
      expect_figure("garteur." + GetParam().name + ".mode_" + std::to_string(i + 1), frequency);
      expect_figure("garteur." + GetParam().name + ".std_" + std::to_string(i + 1), deviations[i].get<double>());
    }
    EXPECT_LT(half_widths / 10.0, 0.02);  // found .0194 and .0192
    EXPECT_NE(prediction["note"].get<std::string>().find("do not include"), std::string::npos);
  }

  nlohmann::json summary_;
};

TEST_P(GarteurUpdating, FitsWithPlausibleParametersAndPredictsTheModification) {
  expect_fit();
  expect_plausible_parameters();
  expect_prediction();
}

INSTANTIATE_TEST_SUITE_P(Cases, GarteurUpdating,
                         testing::Values(GarteurCase{"tail", "modification_1"}, GarteurCase{"wing", "modification_2"}),
                         [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace kalfem::test
