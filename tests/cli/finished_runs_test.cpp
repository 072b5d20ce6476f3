// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/absent.hpp"
#include "base/places.hpp"
#include "short_case.hpp"

/// Verbs on the folders of finished runs: report, compare, plot.
namespace kalfem::test {
namespace {

namespace fs = std::filesystem;

/// Two runs of one case with different filters' priors, in folders a and b, and a third of other data, c.
class FinishedRuns : public testing::Test {
protected:
  static void SetUpTestSuite() {
    runs_ = new ScratchFolder("finished-runs");
    const std::string text = short_case("short");
    std::string other_prior = text, other_data = text;
    other_prior.replace(other_prior.find("std: 20 %"), 9, "std: 40 %");
    other_data.replace(other_data.find("noise: 15 %"), 11, "noise: 10 %");
    for (const auto& [name, of_case] : {std::pair{"a", text}, {"b", other_prior}, {"c", other_data}}) {
      printed_[name] = run_command(
          "run " + write_case(*runs_, std::string(name) + ".yaml", of_case) + " --out " + (*runs_ / name).string(),
          *runs_);
      ASSERT_EQ(printed_[name].code, 0) << printed_[name].errors;
    }
  }
  static void TearDownTestSuite() {
    delete runs_;
    runs_ = nullptr;
  }

  static Outcome on(const std::string& verb, const std::string& folders, const std::string& options = "") {
    std::string arguments = verb;
    for (const char name : folders) arguments += " " + (*runs_ / std::string(1, name)).string();
    return run_command(arguments + " " + options, *runs_);
  }

  static inline ScratchFolder* runs_ = nullptr;
  static inline std::map<std::string, Outcome> printed_;
};

/// The line of a text that begins with a word.
std::string line_with(const std::string& text, const std::string& word) {
  const auto at = text.find("  " + word + " ");
  return at == std::string::npos ? "" : text.substr(at, text.find('\n', at) - at);
}

TEST_F(FinishedRuns, ArePrintedAgain) {
  const auto again = on("report", "a");
  EXPECT_EQ(again.code, 0) << again.errors;
  const std::string& first = printed_["a"].output;
  EXPECT_EQ(line_with(again.output, "suspension.k"), line_with(first, "suspension.k"));
  EXPECT_FALSE(line_with(first, "suspension.k").empty());
  for (const std::string words : {"NIS ", "Verdict: consistent", "Results in "}) {
    const auto line = [&](const std::string& text) {
      const auto at = text.find(words);
      return at == std::string::npos ? "nothing" : text.substr(at, text.find('\n', at) - at);
    };
    EXPECT_EQ(line(again.output), line(first));
  }
  EXPECT_EQ(on("report", "a", "--json").output, read(*runs_ / "a" / "summary.json"));
}

TEST_F(FinishedRuns, OfUnusableNumbersEndAsTheRunDid) {
  const ScratchFolder folder("unusable");
  auto summary = read_summary(*runs_ / "a");
  summary["status"] = "unusable";
  summary["message"] = "the filter stopped";
  summary["verdict"]["state"] = "unusable";
  std::ofstream(folder / "summary.json") << summary;
  const auto told = run_command("report " + folder.path().string(), folder);
  EXPECT_EQ(told.code, 3);
  EXPECT_NE(told.output.find("Verdict: unusable"), std::string::npos) << told.output;
  EXPECT_NE(told.errors.find("the numbers are not usable: the filter stopped"), std::string::npos) << told.errors;
}

TEST_F(FinishedRuns, ThatAreNoneAreRefused) {
  const ScratchFolder folder("no-run");
  const auto refused = [&](const std::string& summary, const std::string& words) {
    if (!summary.empty()) std::ofstream(folder / "summary.json") << summary;
    const auto outcome = run_command("report " + folder.path().string(), folder);
    EXPECT_EQ(outcome.code, 2) << summary;
    EXPECT_NE(outcome.errors.find(words), std::string::npos) << outcome.errors;
    EXPECT_EQ(std::ranges::count(outcome.errors, '\n'), 1) << outcome.errors;
  };
  refused("", "it holds no results of a run");
  refused("{", "it is damaged");
  refused("[1, 2]", "it is damaged");
  auto summary = read_summary(*runs_ / "a");
  summary["kalfem"] = "0.0.1";
  refused(summary.dump(), "it was written by kalfem \"0.0.1\"");
  for (const std::string key : {"run", "verdict", "status", "case"}) {
    summary = read_summary(*runs_ / "a");
    summary.erase(key);
    refused(summary.dump(), "it is damaged");
    summary[key] = nlohmann::json::array({1});
    if (key != "status") refused(summary.dump(), "it is damaged");
  }
  const auto nowhere = run_command("report " + (folder / "nowhere").string(), folder);
  EXPECT_EQ(nowhere.code, 2);
  EXPECT_NE(nowhere.errors.find("it is no folder"), std::string::npos) << nowhere.errors;
}

TEST_F(FinishedRuns, StandSideBySide) {
  const auto outcome = on("compare", "ab", "--page " + (*runs_ / "compared.html").string());
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");  // the same data
  EXPECT_NE(outcome.output.find("The cases differ in: estimate."), std::string::npos) << outcome.output;
  EXPECT_NE(line_with(outcome.output, "suspension.k").find(" ± "), std::string::npos) << outcome.output;
  const std::string page = read(*runs_ / "compared.html");
  EXPECT_NE(page.find("Courses of the parameters"), std::string::npos);
  EXPECT_NE(page.find("id=\"chart-law-suspension\""), std::string::npos);
  EXPECT_NE(outcome.output.find("95 % interval"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("Sensors: innovation / expected"), std::string::npos) << outcome.output;
  const auto json = nlohmann::json::parse(on("compare", "ab", "--json").output);
  const auto& runs = json["parameters"]["suspension.k"]["runs"];
  const auto of = [&](int run, const char* key) { return runs[run][key].get<double>(); };
  for (int run = 0; run < 2; ++run)
    EXPECT_EQ(of(run, "estimate"),
              read_summary(*runs_ / (run == 0 ? "a" : "b"))["parameters"]["suspension.k"]["estimate"]);
  const auto deviation = [&](int run) { return std::max(of(run, "std"), of(run, "std_robust")); };
  EXPECT_NEAR(of(1, "difference"), (of(1, "estimate") - of(0, "estimate")) / std::hypot(deviation(0), deviation(1)),
              1e-12);
  EXPECT_EQ(of(0, "difference"), 0.0);
  EXPECT_EQ(json["runs"][1]["sensors"]["a"]["rms_over_expected"],
            read_summary(*runs_ / "b")["estimation"]["innovations"]["a"]["rms_over_expected"]);
}

/// The law that a comparison draws: a linear one, k d at rest or c v, with the deviation that its parameter has.
TEST_F(FinishedRuns, HoldTheirLaw) {
  const auto file = Hdf5File::open((*runs_ / "a" / "results.h5").string());
  const Eigen::VectorXd rate = file.read("/law/suspension/rate"), force = file.read("/law/suspension/force");
  EXPECT_LT((force - 10.0 * rate).norm(), 1e-9 * force.norm());  // c = 10 N s/m, not sought
  EXPECT_LT(file.read("/law/suspension/force_std").norm(), 1e-9 * force.norm());
}

/// Exact shapes of three equal masses on equal springs.
TEST(CorrelatedRun, IsToldAgainAsItWas) {
  const ScratchFolder folder("correlated");
  std::ofstream shapes(folder / "shapes.csv");
  for (int floor = 1; floor <= 3; ++floor)
    for (int mode = 0; mode < 3; ++mode)
      shapes << std::sin(floor * (2 * mode + 1) * M_PI / 7.0) << (mode < 2 ? "," : "\n");
  shapes.close();
  const std::string file = write_case(folder, "frame.yaml", R"(kalfem: 1
substructures:
  frame:
    masses: {1: 1 kg, 2: 1 kg, 3: 1 kg}
    springs:
      - {name: s1, from: ground, to: 1, stiffness: 1 kN/m}
      - {name: s2, from: 1, to: 2, stiffness: 1 kN/m}
      - {name: s3, from: 2, to: 3, stiffness: 1 kN/m}
update:
  parameters: {frame.s1.stiffness: {}}
  compare:
    modes: {modes: frame, frequencies: [2.2398607, 6.2759501, 9.0690107], deviation: 0.1 %, minimum_mac: 0.7, shapes: {file: shapes.csv, points: [1, 2, 3]}}
)");
  ASSERT_EQ(run_command("correlate " + file + " --out " + (folder / "out").string(), folder).code, 0);
  const auto again = run_command("report " + (folder / "out").string(), folder);
  EXPECT_EQ(again.code, 0) << again.errors;
  EXPECT_NE(again.output.find("Verdict: none, the model was compared with measurements, but nothing was updated"),
            std::string::npos)
      << again.output;
  EXPECT_NE(again.output.find("Correlation of 'modes'"), std::string::npos) << again.output;
  EXPECT_NE(again.output.find("1.000"), std::string::npos) << again.output;
  const std::string resolved = read(folder / "out/case.resolved.yaml");
  EXPECT_NE(resolved.find("minimum_mac: 0.7"), std::string::npos) << resolved;
}

TEST_F(FinishedRuns, OfOtherDataWarn) {
  const auto outcome = on("compare", "ac");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.errors.find("'a' and 'c' do not rest on the same data: the records of a differ"), std::string::npos)
      << outcome.errors;
}

TEST_F(FinishedRuns, WithoutAParameterHaveADash) {
  const ScratchFolder folder("other-unknown");
  std::string text = short_case("other");
  text.replace(text.find("suspension.k: {initial: 4 kN/m"), 30, "suspension.c: {initial: 8 N s/m");
  ASSERT_EQ(run_command("run " + write_case(folder, "d.yaml", text) + " --out " + (folder / "d").string(), folder).code,
            0);
  const auto outcome = run_command("compare " + (*runs_ / "a").string() + " " + (folder / "d").string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const std::string row = line_with(outcome.output, "suspension.c");
  EXPECT_NE(row.find(" - "), std::string::npos) << outcome.output;
  EXPECT_NE(row.find(" ± "), std::string::npos) << outcome.output;
}

TEST_F(FinishedRuns, OneAloneIsNoComparison) {
  const auto outcome = on("compare", "a");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.errors.find("a comparison needs at least two"), std::string::npos) << outcome.errors;
  const auto wrong = run_command(
      "compare " + (*runs_ / "a").string() + " " + (*runs_ / "x").string() + " " + (*runs_ / "y").string(), *runs_);
  EXPECT_EQ(wrong.code, 2);
  EXPECT_EQ(std::ranges::count(wrong.errors, '\n'), 2) << wrong.errors;  // each folder that is none
}

TEST_F(FinishedRuns, AreDrawn) {
  const auto outcome = on("plot", "a");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const fs::path figures = *runs_ / "a" / "figures";
  for (const std::string name :
       {"parameter-suspension.k", "displacement-body.1", "displacement-body.1-zoom", "force-suspension"}) {
    const std::string svg = read(figures / (name + ".svg"));
    EXPECT_TRUE(svg.starts_with("<svg ") && svg.ends_with("</svg>\n")) << name;
    EXPECT_EQ(svg.find("nan"), std::string::npos) << name;
    EXPECT_NE(svg.find("width=\"8.500cm\""), std::string::npos) << name;
  }
  EXPECT_NE(read(figures / "parameter-suspension.k.svg").find("95 % band"), std::string::npos);
  const auto elsewhere = on("plot", "a", "--width 17 --point body.2 --out " + (*runs_ / "wide").string());
  ASSERT_EQ(elsewhere.code, 0) << elsewhere.errors;
  EXPECT_NE(read(*runs_ / "wide" / "displacement-body.2.svg").find("width=\"17.000cm\""), std::string::npos);
  EXPECT_FALSE(fs::exists(*runs_ / "wide" / "displacement-body.1.svg"));
}

TEST_F(FinishedRuns, AreNotDrawnWhereTheyCannotBe) {
  const auto no_point = on("plot", "a", "--point body.7");
  EXPECT_EQ(no_point.code, 2);
  EXPECT_NE(no_point.errors.find("the run reports no point 'body.7' (did you mean 'body."), std::string::npos)
      << no_point.errors;
  EXPECT_EQ(on("plot", "a", "--format pdf").code, 2);
  EXPECT_EQ(on("plot", "a", "--width 1").code, 2);
  const ScratchFolder folder("mixed");
  fs::copy(*runs_ / "a", folder / "mixed");
  fs::copy_file(*runs_ / "c" / "results.h5", folder / "mixed" / "results.h5", fs::copy_options::overwrite_existing);
  const auto mixed = run_command("plot " + (folder / "mixed").string(), folder);
  EXPECT_EQ(mixed.code, 2);
  EXPECT_NE(mixed.errors.find("it does not belong to summary.json"), std::string::npos) << mixed.errors;
}

TEST_F(FinishedRuns, AreDrawnAsPicturesOfPoints) {
  const std::string arguments = "plot " + (*runs_ / "a").string() + " --format png --out " + (*runs_ / "png").string();
  const auto without = std::system(
      ("PATH=/nowhere " + command_file() + " " + arguments + " 2>" + (*runs_ / "png.txt").string()).c_str());
  EXPECT_EQ(WEXITSTATUS(without), 2);
  EXPECT_NE(read(*runs_ / "png.txt").find("apt install librsvg2-bin"), std::string::npos);
  if (std::system("command -v rsvg-convert >/dev/null") != 0) KALFEM_ABSENT("rsvg-convert is absent");
  const auto outcome = run_command(arguments, *runs_);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  for (const auto& name : files_of(*runs_ / "png")) EXPECT_TRUE(name.ends_with(".png")) << name;
  EXPECT_TRUE(read(*runs_ / "png" / "force-suspension.png").starts_with("\x89PNG"));
}

}  // namespace
}  // namespace kalfem::test
